//! The proof data of validity, for one chart or for the whole atlas. Taken on the exported
//! single-precision coordinates after packing.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// What was checked and what was found. `valid` is true when every count is zero and the gutter is
/// at least the padding that was asked for.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct Certificate {
    /// Whether every check below holds.
    pub valid: bool,
    /// Faces whose UV orientation differs from +1 (v up), by exact sign.
    pub flipped: u64,
    /// Pairs of faces whose UV triangles overlap in their interiors.
    pub overlapping_pairs: u64,
    /// Texels of the page owned by more than one chart (at the stated page size).
    pub overlap_texels: u64,
    /// Faces with a coordinate outside the unit square or not finite.
    pub out_of_range: u64,
    /// Faces of positive 3D area with no area in UV.
    pub zero_area_uv: u64,
    /// Faces of zero 3D area: exempt from `zero_area_uv`, counted here.
    pub zero_area_3d: u64,
    /// Whether the boundary polygon of each chart is simple (exact predicates).
    pub simple_boundary: bool,
    /// Least distance in texels between this chart and any other, or between any two charts of the
    /// page; null where there is no other chart.
    #[schema(required)]
    pub min_gutter_texels: Option<f64>,
    /// Whether both sheets of double-sided objects share their UVs on purpose
    /// (`double_sided = share`).
    pub shared_sheets: bool,
}
