//! Outlines of slabs: the square [−1, 1]² pressed into rounder shapes, lattice and all.

use glam::DVec2;

/// The square [−1, 1]² pressed into the superellipse |x|ᵖ + |y|ᵖ ≤ 1, less and less towards the
/// middle. `power` 2 is a disk, ∞ the square.
pub(super) fn squircle(u: f64, v: f64, power: f64) -> DVec2 {
    let m = u.abs().max(v.abs());
    if m < 1e-12 {
        return DVec2::ZERO;
    }
    let full = ((u / m).abs().powf(power) + (v / m).abs().powf(power)).powf(-1.0 / power);
    DVec2::new(u, v) * (1.0 + (full - 1.0) * m * m)
}

/// A lattice over a rectangle with round corners: the square [−1, 1]² in `cells`, of which each
/// corner takes enough to be round.
#[derive(Debug, Clone, Copy)]
pub(super) struct RoundedRectangle {
    /// Half sizes along x and z.
    pub half: DVec2,
    pub radius: f64,
    pub cells: [usize; 2],
}

impl RoundedRectangle {
    /// Where a point of the square lies.
    pub fn at(&self, u: f64, v: f64) -> DVec2 {
        let r = self.radius;
        // Distance into the corner zone (0 to 1; negative outside) and the straight part.
        let split = |t: f64, half: f64, cells: usize| {
            let share = 2.0 * (0.17 * cells as f64).round().max(1.0) / cells as f64;
            let into = (t.abs() - (1.0 - share)) / share;
            (into, (half - r) * (t.abs() / (1.0 - share)).min(1.0))
        };
        let (iu, x) = split(u, self.half.x, self.cells[0]);
        let (iv, z) = split(v, self.half.y, self.cells[1]);
        let mut corner = DVec2::new(iu.max(0.0), iv.max(0.0));
        if iu > 0.0 && iv > 0.0 {
            corner = squircle(iu, iv, 2.0);
        }
        DVec2::new(u.signum() * (x + r * corner.x), v.signum() * (z + r * corner.y))
    }
}
