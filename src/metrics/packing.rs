//! How much of the page is used, measured on the full square page.

use super::Measured;
use crate::contract::PackingEfficiency;

/// Covered share of the pages: by exact UV area, and by texels that some chart owns at the stated
/// page size (`owned_texels`, from the certificate's raster).
pub fn packing_efficiency(input: &Measured, owned_texels: u64) -> PackingEfficiency {
    let pages = f64::from(input.pages.max(1));
    let covered = (0..input.uvs.len())
        .filter_map(|f| input.face_map(f))
        .fold(0.0, |sum, m| sum + m.uv_area.abs());
    let texels = f64::from(input.page_size).powi(2) * pages;
    PackingEfficiency {
        covered: covered / pages,
        delivered: if texels > 0.0 { owned_texels as f64 / texels } else { 0.0 },
    }
}
