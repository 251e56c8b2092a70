//! Colours for numbers: a ramp from a low to a high value, and the bar that explains it.

use glam::{Vec2, Vec3};

use super::canvas::Canvas;
use super::palette::{encode, linear};
use super::text;

/// Colours at even steps from 0 to 1, sRGB.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ramp(&'static [[u8; 3]]);

/// From dark blue over green to a warm red; its ends differ in lightness as well.
pub(super) const COLD_TO_WARM: Ramp = Ramp(&[
    [0x1C, 0x2A, 0x6E],
    [0x2A, 0x6F, 0xB0],
    [0x3F, 0xB0, 0x9C],
    [0xF2, 0xC1, 0x4E],
    [0xE2, 0x4A, 0x2A],
]);

/// From pale to a warm red.
pub(super) const PALE_TO_WARM: Ramp = Ramp(&[
    [0xF3, 0xEF, 0xE2],
    [0xF7, 0xD4, 0x8A],
    [0xF2, 0x9B, 0x4B],
    [0xD9, 0x4E, 0x2F],
    [0x8E, 0x14, 0x2A],
]);

/// Width and height of a bar, pixels.
const BAR: [usize; 2] = [26, 240];

impl Ramp {
    /// The colour at `share`, clamped to 0 to 1, as linear light; mixed as sRGB, so that steps look even.
    pub(super) fn at(self, share: f32) -> Vec3 {
        let last = self.0.len() - 1;
        let along = share.clamp(0.0, 1.0) * last as f32;
        // NaN becomes 0.
        let from = (along as usize).min(last - 1);
        let [low, high] = [self.0[from], self.0[from + 1]].map(|c| Vec3::from(c.map(f32::from)));
        let mixed = low.lerp(high, (along - from as f32).max(0.0));
        linear(mixed.to_array().map(|c| c.round() as u8))
    }

    /// Draws the ramp upright, 1 at the top, with its top left corner at (`x`, `y`), and numbers beside it
    /// from the lowest to the highest, evenly apart.
    pub(super) fn draw_bar(
        self,
        page: &mut Canvas,
        [x, y]: [usize; 2],
        numbers: &[String],
        ink: Vec3,
    ) {
        let [width, height] = BAR;
        let frame = linear(encode(ink.lerp(Vec3::ONE, 0.4)));
        fill(page, [x - 1, y - 1], [width + 2, height + 2], frame);
        for row in 0..height {
            let share = 1.0 - (row as f32 + 0.5) / height as f32;
            fill(page, [x, y + row], [width, 1], self.at(share));
        }
        for (i, number) in numbers.iter().enumerate() {
            let share = i as f32 / numbers.len().saturating_sub(1).max(1) as f32;
            let level = y + ((1.0 - share) * height as f32) as usize;
            fill(page, [x + width + 1, level - usize::from(i > 0)], [5, 1], frame);
            let at = [x + width + 10, level - text::LINE / 2];
            text::write(page, number, at, page.width.saturating_sub(at[0]), ink);
        }
    }
}

/// Fills a rectangle whose top left corner is at (`x`, `y`).
pub(super) fn fill(
    page: &mut Canvas,
    [x, y]: [usize; 2],
    [width, height]: [usize; 2],
    color: Vec3,
) {
    let (low, high) =
        (Vec2::new(x as f32, y as f32), Vec2::new((x + width) as f32, (y + height) as f32));
    let [upper, lower] = [Vec2::new(high.x, low.y), Vec2::new(low.x, high.y)];
    page.fill([low, upper, high], color);
    page.fill([low, high, lower], color);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_runs_from_its_first_colour_to_its_last() {
        for ramp in [COLD_TO_WARM, PALE_TO_WARM] {
            let seen = |share| encode(ramp.at(share));
            assert_eq!([seen(0.0), seen(-1.0), seen(f32::NAN)], [ramp.0[0]; 3]);
            assert_eq!([seen(1.0), seen(7.0)], [ramp.0[4]; 2]);
            assert_eq!(seen(0.5), ramp.0[2]);
            assert!(seen(0.6)[0] > ramp.0[2][0].min(ramp.0[3][0]));
        }
    }

    #[test]
    fn a_bar_has_the_highest_colour_on_top() {
        let mut page = Canvas::gradient(120, 280, Vec3::ONE, Vec3::ONE);
        COLD_TO_WARM.draw_bar(&mut page, [10, 20], &["0".into(), "1".into()], Vec3::ZERO);
        let at = |y: usize| page.pixels[y * page.width + 10 + BAR[0] / 2];
        assert!(at(20).distance(COLD_TO_WARM.at(1.0)) < 0.05);
        assert!(at(19 + BAR[1]).distance(COLD_TO_WARM.at(0.0)) < 0.05);
    }
}
