//! The checker texture: squares that are even in UV, tinted with the colour of the part, a little
//! different in every chart. Uneven or skewed squares show distortion, a step shows a seam.

use glam::Vec3;

use super::palette::{linear, part_color};
use crate::metrics::Measured;

/// Squares along the diagonal of the object, at the mean density.
const SQUARES: f64 = 40.0;
/// Most squares across a page.
const MOST: f64 = 4096.0;

/// Squares across a page: even, so that the pattern closes. `diagonal`: of all that is shown.
pub(super) fn squares(input: &Measured, diagonal: f64) -> f32 {
    let maps = (0..input.uvs.len()).filter_map(|f| input.face_map(f));
    let (uv, area) = maps.fold((0.0, 0.0), |(u, a), m| (u + m.uv_area.abs(), a + m.area));
    let density = if uv > 0.0 { (uv / area).sqrt() } else { 1.0 };
    let wanted = SQUARES / (density * diagonal.max(f64::MIN_POSITIVE));
    (2.0 * (0.5 * wanted).round().clamp(1.0, 0.5 * MOST)) as f32
}

/// The light and the dark square of a chart.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tint {
    light: Vec3,
    dark: Vec3,
}

impl Tint {
    pub(super) fn new(part: u32, chart: u32) -> Self {
        let hue = linear(part_color(part));
        // Neighbouring numbers lie far apart in the golden sequence.
        let own = (chart as f32 * 0.618_034).fract();
        Self {
            light: Vec3::splat(0.93).lerp(hue, 0.16 + 0.14 * own),
            dark: Vec3::splat(0.12).lerp(hue, 0.45 + 0.25 * own),
        }
    }

    /// The colour at a point: `uv` in squares, a square `pixels` wide on the screen. Squares that
    /// are too small to be drawn fade into their mean.
    pub(super) fn at(&self, uv: [f32; 2], pixels: f32) -> Vec3 {
        let odd = (floor(uv[0]) ^ floor(uv[1])) & 1 == 1;
        let plain = if odd { self.dark } else { self.light };
        let mean = 0.5 * (self.dark + self.light);
        mean.lerp(plain, ((pixels - 1.0) / 3.0).clamp(0.0, 1.0))
    }
}

/// The largest whole number that is not more: by a cast, since the call of a library would cost as much as all
/// else of a pixel.
fn floor(x: f32) -> i32 {
    let whole = x as i32;
    whole.wrapping_sub(i32::from(whole as f32 > x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_alternate_on_both_sides_of_zero() {
        let tint = Tint::new(0, 0);
        let is_dark = |u: f32, v: f32| tint.at([u, v], 9.0) == tint.dark;
        for (u, v) in [(0.5, 0.5), (-0.5, -0.5), (-1.5, 0.5), (3.0, 1.0), (-2.0, 0.0)] {
            assert!(!is_dark(u, v) && is_dark(u + 1.0, v) && is_dark(u, v - 1.0), "{u} {v}");
        }
        assert_eq!([2.0, 1.99, -0.01, -1.0, -1.01, f32::NAN].map(floor), [2, 1, -1, -1, -2, 0]);
    }
}
