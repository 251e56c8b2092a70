//! A contact sheet: the previews of many results on one page, each with its checker, its layout and
//! a few words.

use glam::Vec3;
use rayon::prelude::*;

use super::canvas::Canvas;
use super::palette::linear;
use super::picture::{LARGE, SMALL, encode_png};
use super::text::{LINE, write};

/// The checker is shown at this fraction of its size in the preview, the layout at that.
const CHECKER_FACTOR: usize = 3;
const LAYOUT_FACTOR: usize = 2;
/// Width and height of what remains, pixels.
const CHECKER: usize = LARGE / CHECKER_FACTOR;
const LAYOUT: usize = SMALL / LAYOUT_FACTOR;
/// Free pixels around each cell.
const GAP: usize = 8;

/// One object on a sheet.
#[derive(Debug, Clone)]
pub struct SheetCell {
    /// Its `preview.png`; `None` leaves the place empty.
    pub preview: Option<Vec<u8>>,
    /// Lines of at most 27 ASCII letters; three find room.
    pub caption: Vec<String>,
}

/// Why there is no sheet.
#[derive(Debug, thiserror::Error)]
pub enum SheetError {
    /// A preview is no PNG that can be read.
    #[error("a preview could not be read: {0}")]
    Decoding(#[from] png::DecodingError),
    /// A preview is a PNG, but not one of ours.
    #[error("a preview has {width} × {height} pixels, which is not the size of ours")]
    Foreign {
        /// Its width.
        width: u32,
        /// Its height.
        height: u32,
    },
    /// The sheet could not be written.
    #[error("the sheet could not be encoded: {0}")]
    Encoding(#[from] png::EncodingError),
}

/// Draws the sheet, `columns` cells a row, as PNG.
pub fn contact_sheet(cells: &[SheetCell], columns: usize) -> Result<Vec<u8>, SheetError> {
    let columns = columns.clamp(1, cells.len().max(1));
    let rows = cells.len().div_ceil(columns);
    let (across, down) = (CHECKER + LAYOUT + GAP, CHECKER + GAP);
    let mut page =
        Canvas::gradient(columns * across + GAP, rows * down + GAP, Vec3::ONE, Vec3::ONE);
    let ink = linear([0x20, 0x22, 0x28]);
    for (i, cell) in cells.iter().enumerate() {
        let (x, y) = (GAP + i % columns * across, GAP + i / columns * down);
        if let Some(preview) = &cell.preview {
            let preview = decode(preview)?;
            let checker = preview.part(0, 0, LARGE, LARGE);
            page.paste_smaller(&checker, CHECKER_FACTOR, x, y);
            // The line between the panels of the preview stays behind.
            let layout = preview.part(LARGE + 1, SMALL + 1, SMALL - 1, SMALL - 1);
            page.paste_smaller(&layout, LAYOUT_FACTOR, x + CHECKER, y);
        }
        for (line, text) in cell.caption.iter().enumerate() {
            let at = [x + CHECKER + 2, y + LAYOUT + 6 + line * (LINE + 2)];
            if at[1] + LINE <= y + CHECKER {
                write(&mut page, text, at, LAYOUT, ink);
            }
        }
    }
    Ok(encode_png(&page, png::Compression::High)?)
}

/// A preview as linear light.
fn decode(bytes: &[u8]) -> Result<Canvas, SheetError> {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info()?;
    let (width, height) = reader.info().size();
    let ours = (width as usize, height as usize) == (LARGE + SMALL, LARGE)
        && reader.output_color_type() == (png::ColorType::Rgb, png::BitDepth::Eight);
    if !ours {
        return Err(SheetError::Foreign { width, height });
    }
    let mut colors = vec![0; 3 * (LARGE + SMALL) * LARGE];
    reader.next_frame(&mut colors)?;
    let pixels = colors.as_chunks().0.par_iter().map(|color| linear(*color)).collect();
    Ok(Canvas { width: LARGE + SMALL, height: LARGE, pixels })
}
