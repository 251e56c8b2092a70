//! Words on a picture: ASCII in Noto Sans Mono, whose smooth glyphs come with a small crate.

use glam::Vec3;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

use super::canvas::Canvas;

/// Pixels from one line to the next.
pub(super) const LINE: usize = RasterHeight::Size16.val();
/// Pixels from one letter to the next.
pub(super) const LETTER: usize = get_raster_width(FontWeight::Regular, RasterHeight::Size16);

/// Writes a line of text with its top left corner at (`x`, `y`), no wider than `width` pixels. What
/// is not ASCII becomes a question mark.
pub(super) fn write(canvas: &mut Canvas, text: &str, [x, y]: [usize; 2], width: usize, ink: Vec3) {
    for (i, letter) in text.chars().take(width / LETTER).enumerate() {
        let glyph = |c: char| get_raster(c, FontWeight::Regular, RasterHeight::Size16);
        let Some(glyph) = glyph(letter).or_else(|| glyph('?')) else { continue };
        for (j, row) in glyph.rows().enumerate() {
            for (k, coverage) in row.iter().enumerate() {
                let (px, py) = (x + i * LETTER + k, y + j);
                if px < canvas.width && py < canvas.height {
                    let pixel = &mut canvas.pixels[py * canvas.width + px];
                    *pixel = pixel.lerp(ink, f32::from(*coverage) / 255.0);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Letters' share of black at each of `n` places.
    fn written(text: &str, width: usize) -> Vec<f32> {
        let mut canvas = Canvas::gradient(4 * LETTER, LINE, Vec3::ONE, Vec3::ONE);
        write(&mut canvas, text, [0, 0], width, Vec3::ZERO);
        let dark = |i: usize| {
            let own = canvas.pixels.iter().enumerate();
            own.filter(|(p, _)| p % canvas.width / LETTER == i).map(|(_, c)| 1.0 - c.x).sum()
        };
        (0..4).map(dark).collect()
    }

    #[test]
    fn letters_stand_side_by_side_and_end_where_they_must() {
        let one = written("i M", 4 * LETTER);
        assert!(one[0] > 4.0 && one[1] == 0.0 && one[2] > one[0] && one[3] == 0.0, "{one:?}");
        assert_eq!(written("iM", LETTER)[1], 0.0);
        assert_eq!(written("√", LETTER), written("?", LETTER));
        // Beyond the canvas nothing is written, and nothing breaks.
        assert!(written("MMMMMMMM", 8 * LETTER)[3] > 4.0);
    }
}
