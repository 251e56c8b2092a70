//! The figures of `metrics.json` that are taken at every level: atlas, part, chart. A figure that cannot be
//! had is null: never 0, never absent. The definitions are in docs/metrics.md and beside the code that takes
//! each figure.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// An area-weighted per-face figure.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct FaceStats {
    /// Area-weighted mean.
    pub mean: f64,
    /// Area-weighted 95th percentile.
    pub p95: f64,
    /// Largest.
    pub max: f64,
}

/// Texels per world unit, √(σ1σ2) over the faces, at the stated page size.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct TexelDensity {
    /// Smallest.
    pub min: f64,
    /// Area-weighted mean.
    pub mean: f64,
    /// Largest.
    pub max: f64,
    /// Coefficient of variation: 0 when the density is even.
    pub cv: f64,
}

/// A length in 3D, made free of the object's size.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct SeamLength {
    /// Over √(3D area).
    pub per_sqrt_area: f64,
    /// Over the diagonal of the bounding box.
    pub per_diagonal: f64,
}

/// PartUV's area figure: max(r, 1/r) clipped at 10, unweighted over faces.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct PartUvArea {
    /// The worst chart's mean.
    pub worst_chart: f64,
    /// The mean over all faces at one scale.
    pub overall: f64,
}

/// How well seams and part boundaries agree, within 1 % of the diagonal.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct BoundaryAlignment {
    /// Seam length near a part boundary / seam length.
    pub precision: f64,
    /// Part-boundary length that is seam / part-boundary length.
    pub recall: f64,
    /// Harmonic mean of both.
    pub f1: f64,
    /// The best precision possible: part-boundary length / seam length, at most 1.
    pub ceiling: f64,
    /// Length of contact curves between components (within 0.5 % of the diagonal) / diagonal.
    pub contact_length: f64,
}

/// The paper's conformality, on the shipped atlas and at its worst rotation.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct PaperConformality {
    /// mean |cos(∂p/∂u, ∂p/∂v)|.
    pub shipped: f64,
    /// mean (σ1² − σ2²)/(σ1² + σ2²).
    pub worst_rotation: f64,
}

/// The paper's internal consistency, by distance over the chart and by straight distance.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct PaperInternalConsistency {
    /// Over the 8 nearest by chart-graph distance.
    pub geodesic: f64,
    /// Over the 8 nearest by straight distance, each term clipped at 1.
    pub euclidean: f64,
}

/// The paper's boundary compactness (reconstructed) and the usual one.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct PaperBoundaryCompactness {
    /// |S∩B| / |S∪B| of seam and part-boundary length; null without parts that share edges.
    #[schema(required)]
    pub seam_boundary_overlap: Option<f64>,
    /// Area-weighted mean over charts of 4πA/P².
    pub isoperimetric: f64,
}

/// The figures of the paper's tables, under its definitions as far as it gives them (docs/metrics.md says
/// which are reconstructed).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct PaperFigures {
    /// Angular distortion as the paper takes it.
    #[schema(required)]
    pub conformality: Option<PaperConformality>,
    /// Whether near points stay near, as the paper takes it (reconstructed).
    #[schema(required)]
    pub internal_consistency: Option<PaperInternalConsistency>,
    /// Seams against part boundaries as the paper takes it (reconstructed).
    #[schema(required)]
    pub boundary_compactness: Option<PaperBoundaryCompactness>,
    /// ΣA·½(|σ1/s − 1| + |σ2/s − 1|)/ΣA (reconstructed).
    #[schema(required)]
    pub texture_distortion: Option<f64>,
    /// √(ΣA·min_R‖J/s − R‖²/ΣA) (reconstructed).
    #[schema(required)]
    pub mean_texture_error: Option<f64>,
    /// Chamfer distance of the round trip 3D → UV → 3D; null where no chart was trained.
    #[schema(required)]
    pub chamfer: Option<f64>,
    /// Seam length over the diagonal, as in the paper's Table 2.
    #[schema(required)]
    pub total_seam_length: Option<f64>,
    /// Connected seam curves, as in the paper's Table 4.
    pub seam_count: u64,
    /// Charts, as in the paper's Table 4.
    pub island_count: u64,
    /// Share of seam length near a part boundary, as in the paper's Table 4.
    #[schema(required)]
    pub boundary_alignment_score: Option<f64>,
}

/// The figures that are taken at every level: atlas, part, chart. σ1 ≥ σ2 are the singular values
/// of the map from a face's tangent plane to UV; s is the scale that makes total UV area equal
/// total 3D area, global except where the name ends in `_chart`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct Figures {
    /// σ1/σ2.
    #[schema(required)]
    pub quasi_conformal: Option<FaceStats>,
    /// ½√(Σw(σ1²+σ2²)·Σw(σ1⁻²+σ2⁻²))/Σw at the best common scale: 1 is isometric.
    #[schema(required)]
    pub symmetric_dirichlet: Option<f64>,
    /// The same with each chart at its own best scale.
    #[schema(required)]
    pub symmetric_dirichlet_chart: Option<f64>,
    /// max(r, 1/r), r = σ1σ2/s².
    #[schema(required)]
    pub area_distortion: Option<FaceStats>,
    /// The same with each chart at its own scale.
    #[schema(required)]
    pub area_distortion_chart: Option<FaceStats>,
    /// Root of the area-weighted mean of (σ1⁻²+σ2⁻²)/2, scaled (Sander et al. 2001).
    #[schema(required)]
    pub stretch_l2: Option<f64>,
    /// Largest 1/σ2, scaled.
    #[schema(required)]
    pub stretch_linf: Option<f64>,
    /// Texels per world unit.
    #[schema(required)]
    pub texel_density: Option<TexelDensity>,
    /// Cuts: an edge of k faces needs ⌈k/2⌉ different UV edges, and each further one is a cut.
    pub seam_edges: u64,
    /// Their length in 3D, counted once.
    #[schema(required)]
    pub seam_length: Option<SeamLength>,
    /// Seam length that is neither near a part boundary, nor at a crease, nor hidden / seam length.
    #[schema(required)]
    pub avoidable_seam: Option<f64>,
    /// Seams against part boundaries; null without parts that share edges.
    #[schema(required)]
    pub boundary_alignment: Option<BoundaryAlignment>,
    /// 1 − mean |cos(∂p/∂u, ∂p/∂v)| (PartUV's table).
    #[schema(required)]
    pub partuv_angular: Option<f64>,
    /// PartUV's area figure.
    #[schema(required)]
    pub partuv_area: Option<PartUvArea>,
    /// The figures of the paper's tables.
    pub paper: PaperFigures,
}
