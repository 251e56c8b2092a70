//! The two distortion figures of PartUV (Wang et al. 2025, arXiv:2511.16659), by its own definitions:
//! unweighted over faces, each face's ratio clipped at 10, faces far smaller than their chart's mean
//! left out.

use super::FaceMap;
use crate::contract::PartUvArea;

/// Clip of a face's ratio.
const CLIP: f64 = 10.0;
/// A face smaller than this share of the mean face of its group does not count.
const SMALL: f64 = 1e-4;

/// 1 − mean |cos(∂p/∂u, ∂p/∂v)|.
pub(super) fn angular<'a>(maps: impl Iterator<Item = &'a FaceMap>) -> Option<f64> {
    let (sum, count) =
        maps.filter_map(|m| m.axis_cosine).fold((0.0, 0u64), |(s, n), c| (s + c, n + 1));
    (count > 0).then(|| 1.0 - sum / count as f64)
}

/// Mean of max(r, 1/r) over one group of faces, r at the group's own scale.
fn group(maps: &[&FaceMap]) -> Option<f64> {
    let (uv, area) = maps.iter().fold((0.0, 0.0), |(u, a), m| (u + m.uv_area.abs(), a + m.area));
    let least = SMALL * area / maps.len() as f64;
    let (sum, count) = maps
        .iter()
        .filter(|m| m.area >= least && m.uv_area != 0.0)
        .map(|m| (m.uv_area.abs() / m.area) * (area / uv))
        .fold((0.0, 0u64), |(s, n), r| (s + r.max(1.0 / r).min(CLIP), n + 1));
    (count > 0).then(|| sum / count as f64)
}

/// The worst chart, and all faces as one group.
pub(super) fn area<'a>(
    all: impl Iterator<Item = &'a FaceMap>,
    charts: impl Iterator<Item = Vec<&'a FaceMap>>,
) -> Option<PartUvArea> {
    let overall = group(&all.collect::<Vec<_>>())?;
    let worst_chart = charts.filter_map(|c| group(&c)).reduce(f64::max)?;
    Some(PartUvArea { worst_chart, overall })
}
