//! Where one chart stands: a similarity from its own map to the unit square of a page.

use glam::DVec2;

/// Page, scale, rotation and translation of one chart. Never mirrors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Page, counted from 0.
    pub page: u32,
    /// Page widths per unit of the chart's map.
    pub scale: f64,
    /// The rotation, as the unit vector that the chart's u axis turns to.
    pub rotation: DVec2,
    /// Where the origin of the chart's map comes to lie, page widths.
    pub offset: DVec2,
}

impl Placement {
    /// The chart's point on the page: [0, 1]², v up.
    pub fn apply(&self, p: DVec2) -> DVec2 {
        self.rotation.rotate(p) * self.scale + self.offset
    }
}
