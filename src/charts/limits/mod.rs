//! What a chart may cost, for charts of one surface.

pub mod cost;
pub mod extent;
pub mod fit;
pub mod known;
pub mod visibility;

use crate::charts::build::ChartOptions;
use crate::mesh::Surface;

/// λ of the objective, as a share of the distortion bound.
const SEAM: f64 = 0.2;

/// Empty space in the rectangle around a union, over its area: an L of three squares has 0.33, a cross
/// of six has 1.
const WASTE: f64 = 0.6;

/// Length of a chart, over √ΣA, that still lets a page be filled well.
const LENGTH: f64 = 1.1;

/// What a chart less is worth: the seam of this length times √ΣA, at cost 1.
const CHART: f64 = 0.05;

/// Distance that a chart's border keeps from itself, over √ΣA: some steps of the lattice on which final
/// coordinates lie (2⁻²⁴ of a page).
const CLEARANCE: f64 = 5e-7;

/// Distance that a chart's border keeps from itself, world units.
pub fn clearance(surface: &Surface) -> f64 {
    CLEARANCE * surface.area().sqrt()
}

/// The limits of a union of charts.
#[derive(Debug, Clone, Copy)]
pub struct ChartLimits {
    /// Largest area-weighted mean symmetric Dirichlet energy of a chart, minus 1.
    pub bound: f64,
    /// √ΣA.
    pub size: f64,
    /// λ√ΣA: what a unit of seam (length times cost) is worth in energy times area.
    pub worth: f64,
    /// What one chart less is worth, as a seam: length times cost.
    pub chart: f64,
    /// Length to which charts may be joined.
    pub length: f64,
    /// Rectangle around a union, less its area, over its area.
    pub waste: f64,
    /// Distance that a border keeps from itself.
    pub clearance: f64,
    /// Whether a border may come twice to a vertex.
    pub pinches: bool,
}

impl ChartLimits {
    /// For charts that are cut like that.
    pub fn of(surface: &Surface, options: &ChartOptions) -> Self {
        Self { pinches: options.pinches, ..Self::new(surface, options.distortion_bound) }
    }

    /// For charts of a surface.
    pub fn new(surface: &Surface, bound: f64) -> Self {
        let size = surface.area().sqrt();
        Self {
            bound,
            size,
            worth: SEAM * bound * size,
            chart: CHART * size,
            length: LENGTH * size,
            waste: WASTE,
            clearance: clearance(surface),
            pinches: true,
        }
    }
}
