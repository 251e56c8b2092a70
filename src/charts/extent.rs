//! How long a chart is. A page holds no chart longer than its side, so that one long chart makes all
//! the others small: charts are not joined to longer ones than a well filled page is wide, and longer
//! ones are divided across.

use std::f64::consts::PI;

use glam::DVec2;

use super::patchwork::Patchwork;
use crate::mesh::NONE;

/// Directions in which a chart is measured; between two of them it is at most 1 % longer.
const DIRECTIONS: u32 = 16;

/// A division must leave charts no longer than this share of the whole.
const SHORTER: f64 = 0.75;

/// Most pieces that one chart is divided into.
const PIECES: f64 = 8.0;

/// How far a map reaches.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Extent {
    /// In the direction in which it is longest.
    pub length: f64,
    /// That direction.
    pub axis: DVec2,
    /// Area of the smallest rectangle around it.
    pub rectangle: f64,
}

/// Measure a map.
pub fn extent(uv: &[DVec2]) -> Extent {
    let width = |k: u32| {
        let axis = DVec2::from_angle(PI * f64::from(k) / f64::from(DIRECTIONS));
        let (low, high) = span(uv, axis);
        high - low
    };
    let widths: Vec<f64> = (0..DIRECTIONS).map(width).collect();
    let longest = (0..DIRECTIONS as usize).max_by(|&i, &j| widths[i].total_cmp(&widths[j]));
    let longest = longest.unwrap_or(0);
    // Directions a quarter turn apart.
    let half = DIRECTIONS as usize / 2;
    let rectangle = (0..half).map(|k| widths[k] * widths[k + half]).fold(f64::INFINITY, f64::min);
    let axis = DVec2::from_angle(PI * longest as f64 / f64::from(DIRECTIONS));
    Extent { length: widths[longest], axis, rectangle }
}

fn span(uv: &[DVec2], axis: DVec2) -> (f64, f64) {
    uv.iter()
        .map(|p| p.dot(axis))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)))
}

/// Divide the charts that are longer than `limit` across, into equal lengths, where their triangles
/// allow it. Maps stay as they are.
pub fn shorten(work: &mut Patchwork, limit: f64) {
    for chart in 0..work.faces.len() as u32 {
        let faces = std::mem::take(&mut work.faces[chart as usize]);
        let corners = |f: &u32| 3 * *f as usize..3 * *f as usize + 3;
        let uv: Vec<DVec2> = faces.iter().flat_map(corners).map(|c| work.uv[c]).collect();
        let Extent { length, axis, .. } = extent(&uv);
        let pieces = match length > limit {
            true => divide(work, &faces, length, axis, limit),
            false => None,
        };
        let Some(pieces) = pieces else {
            work.faces[chart as usize] = faces;
            continue;
        };
        for piece in pieces {
            let number = work.faces.len() as u32;
            piece.iter().for_each(|&f| work.chart_of[f as usize] = number);
            work.faces.push(piece);
        }
    }
    let chart_of = &work.chart_of;
    for (h, glued) in work.glued.iter_mut().enumerate().filter(|(_, g)| **g) {
        *glued = chart_of[h / 3] == chart_of[work.mesh.twin[h] as usize / 3];
    }
}

/// Pieces of a chart that are much shorter, if it falls into such.
fn divide(
    work: &Patchwork,
    faces: &[u32],
    length: f64,
    axis: DVec2,
    limit: f64,
) -> Option<Vec<Vec<u32>>> {
    let center = |f: u32| (0..3).map(|k| work.uv[3 * f as usize + k].dot(axis)).sum::<f64>() / 3.0;
    let all: Vec<DVec2> = faces
        .iter()
        .flat_map(|&f| (0..3).map(move |k| 3 * f as usize + k))
        .map(|c| work.uv[c])
        .collect();
    let low = span(&all, axis).0;
    let count = (length / limit).ceil().min(PIECES);
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
    let sound = |piece: &Vec<u32>| {
        let uv: Vec<DVec2> = piece
            .iter()
            .flat_map(|&f| (0..3).map(move |k| 3 * f as usize + k))
            .map(|c| work.uv[c])
            .collect();
        extent(&uv).length <= SHORTER * length
    };
    (pieces.len() as f64 <= 2.0 * count && pieces.iter().all(sound)).then_some(pieces)
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
            assert!((4.94..5.05).contains(&length), "{length}");
            assert!(axis.dot(DVec2::from_angle(turn)).abs() > 0.98);
        }
    }
}
