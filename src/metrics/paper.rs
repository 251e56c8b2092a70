//! The paper's figures of distortion (UVSegNet, J. Imaging 2026, 12(3), 92, Tables 1 and 2), which it
//! names but does not define: reconstructed. Conformality depends on the direction of the UV axes, so
//! it is taken on the shipped atlas, with its worst over all rotations beside it.

use super::statistics::weighted_mean;
use super::{EdgeTable, FaceMap, Measured};
use crate::contract::PaperConformality;

/// mean |cos(∂p/∂u, ∂p/∂v)| as shipped, and (σ1² − σ2²)/(σ1² + σ2²), its largest value at any
/// rotation.
pub(super) fn conformality<'a>(
    maps: impl Iterator<Item = &'a FaceMap> + Clone,
) -> Option<PaperConformality> {
    let shipped = maps.clone().filter_map(|m| Some((m.axis_cosine?, m.area)));
    let worst = |m: &FaceMap| {
        let (p, q) = (m.sigma1 * m.sigma1, m.sigma2 * m.sigma2);
        if p > 0.0 { (p - q) / (p + q) } else { 1.0 }
    };
    Some(PaperConformality {
        shipped: weighted_mean(shipped)?,
        worst_rotation: weighted_mean(maps.map(|m| (worst(m), m.area)))?,
    })
}

/// ΣA·½(|σ1/s − 1| + |σ2/s − 1|)/ΣA.
pub(super) fn texture_distortion<'a>(
    maps: impl Iterator<Item = &'a FaceMap>,
    s2: f64,
) -> Option<f64> {
    let s = s2.sqrt();
    let term = |m: &FaceMap| 0.5 * ((m.sigma1 / s - 1.0).abs() + (m.sigma2 / s - 1.0).abs());
    weighted_mean(maps.map(|m| (term(m), m.area)))
}

/// √(ΣA·min_R‖J/s − R‖²/ΣA) over rotations R: a mirrored face counts its smaller singular value as
/// negative.
pub(super) fn mean_texture_error<'a>(
    maps: impl Iterator<Item = &'a FaceMap>,
    s2: f64,
) -> Option<f64> {
    let s = s2.sqrt();
    let term = |m: &FaceMap| {
        let smaller = m.sigma2.copysign(m.uv_area);
        (m.sigma1 / s - 1.0).powi(2) + (smaller / s - 1.0).powi(2)
    };
    weighted_mean(maps.map(|m| (term(m), m.area))).map(f64::sqrt)
}

/// UV perimeter of every chart, page = 1. Length: charts.
pub(super) fn perimeters(input: &Measured, table: &EdgeTable) -> Vec<f64> {
    let mut perimeters = vec![0.0; input.charts];
    for e in 0..table.len() {
        for h in table.rim(e) {
            let (f, k) = (h as usize / 3, h as usize % 3);
            let ([a, b], [c, d]) = (input.uvs[f][k], input.uvs[f][(k + 1) % 3]);
            let length = f64::from(c - a).hypot(f64::from(d - b));
            if let Some(sum) = perimeters.get_mut(input.chart_of[f] as usize) {
                *sum += length;
            }
        }
    }
    perimeters
}

/// 4πA/P² of a chart in UV: 1 for a disk.
pub(super) fn isoperimetric(uv_area: f64, perimeter: f64) -> f64 {
    if perimeter > 0.0 { 4.0 * std::f64::consts::PI * uv_area / perimeter.powi(2) } else { 0.0 }
}
