//! How long a chart is. A page holds no chart longer than its side, so that one long chart makes all
//! the others small: charts are not joined to longer ones than a well filled page is wide, and longer
//! ones are divided across.

use glam::DVec2;

use super::ChartLimits;
use super::fit::is_sound;
use crate::charts::patchwork::Patchwork;
use crate::flatten::{quality, smallest_rectangle};
use crate::mesh::NONE;

/// Charts longer than this many times the length to which they may be joined are divided.
const TOO_LONG: f64 = 1.6;

/// A division must leave charts no longer than this share of the whole.
const SHORTER: f64 = 0.75;

/// Most pieces that one chart is divided into.
const PIECES: f64 = 8.0;

/// How far a map reaches.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Extent {
    /// Longer side of the smallest rectangle around it.
    pub length: f64,
    /// Direction of that side.
    pub axis: DVec2,
    /// Area of that rectangle.
    pub rectangle: f64,
}

/// Measure a map.
pub fn extent(uv: &[DVec2]) -> Extent {
    let Some([a, b, c, _]) = smallest_rectangle(uv, 0.0) else { return Extent::default() };
    let (one, other) = (b - a, c - b);
    let long = if one.length() >= other.length() { one } else { other };
    Extent {
        length: long.length(),
        axis: long.normalize_or_zero(),
        rectangle: one.length() * other.length(),
    }
}

/// Whether a chart of such an extent and area is no longer than what is left whole, and fills its rectangle.
pub fn fits_page(extent: &Extent, area: f64, limits: &ChartLimits) -> bool {
    extent.length <= TOO_LONG * limits.length && extent.rectangle - area <= limits.waste * area
}

fn span(uv: &[DVec2], axis: DVec2) -> (f64, f64) {
    uv.iter()
        .map(|p| p.dot(axis))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)))
}

/// Divide the charts that are far too long across, into equal lengths, where their triangles
/// allow it. Maps stay as they are.
pub fn shorten(work: &mut Patchwork, limits: &ChartLimits) {
    for chart in 0..work.faces.len() as u32 {
        let Extent { length, axis, .. } = work.extent[chart as usize];
        if length > TOO_LONG * limits.length
            && let Some(pieces) = strips(work, chart, length, axis, limits)
        {
            work.divide(chart, pieces);
        }
    }
}

/// Pieces of a chart that are much shorter, if it falls into such.
fn strips(
    work: &Patchwork,
    chart: u32,
    length: f64,
    axis: DVec2,
    limits: &ChartLimits,
) -> Option<Vec<Vec<u32>>> {
    let faces = &work.faces[chart as usize];
    let center = |f: u32| (0..3).map(|k| work.uv[3 * f as usize + k].dot(axis)).sum::<f64>() / 3.0;
    let corners = faces.iter().flat_map(|&f| (0..3).map(move |k| 3 * f as usize + k));
    let all: Vec<DVec2> = corners.map(|c| work.uv[c]).collect();
    let low = span(&all, axis).0;
    let count = (length / limits.length).ceil().min(PIECES);
    let mut strip = vec![NONE; work.mesh.len()];
    for &f in faces {
        let at = ((center(f) - low) / length * count).floor().clamp(0.0, count - 1.0);
        strip[f as usize] = at as u32;
    }
    let same = |h: u32| {
        let t = work.mesh.twin[h as usize];
        work.glued[h as usize] && strip[h as usize / 3] == strip[t as usize / 3]
    };
    let pieces = work.mesh.components(faces, same);
    let shorter = |piece: &Vec<u32>| {
        let map = sound_map(work, piece, same, limits);
        map.is_some_and(|uv| extent(&uv).length <= SHORTER * length)
    };
    (pieces.len() as f64 <= 2.0 * count && pieces.iter().all(shorter)).then_some(pieces)
}

/// The map of a piece that hangs together by the edges of which `glued` says so, if it can stand alone: a
/// piece may touch itself at a corner, or have all of a chart's distortion.
pub fn sound_map(
    work: &Patchwork,
    piece: &[u32],
    glued: impl Fn(u32) -> bool,
    limits: &ChartLimits,
) -> Option<Vec<DVec2>> {
    let cut = work.mesh.cut_open_where(piece.to_vec(), glued);
    let uv = work.map_of(&cut);
    let sound = quality(&cut.disk, &uv).mean - 1.0 <= limits.bound
        && is_sound(&cut.disk, &uv, limits.clearance);
    sound.then_some(uv)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extent_is_found_in_any_direction() {
        for turn in [0.0, 0.3, 1.2, 2.9] {
            let strip = [(0.0, 0.0), (5.0, 0.0), (5.0, 0.1), (0.0, 0.1)];
            let uv = strip.map(|p| DVec2::from_angle(turn).rotate(DVec2::from(p)));
            let Extent { length, axis, .. } = extent(&uv);
            assert!((length - 5.0).abs() < 1e-9, "{length}");
            assert!(axis.dot(DVec2::from_angle(turn)).abs() > 1.0 - 1e-9);
        }
    }
}
