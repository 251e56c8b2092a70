//! Parts of a chart's border that lie on each other by an edge or less, as the sides of a cut do where a map
//! was carried over from a coarser mesh, are moved apart: each side of a contact is shifted out of the other,
//! and what is near it on the chart goes along, less with each ring, so that no face is bent much.

use std::collections::BTreeMap;

use glam::DVec2;

use super::clearance::{Edge, contacts};
use super::fans::Fans;
use super::untangle::untangle;
use super::{Border, Disk, UvMap, count_flips};

/// Rounds of shifting.
const ROUNDS: u32 = 40;

/// Rounds after which more rings go along.
const WIDEN: u32 = 8;

/// Rings that go along with a contact at first.
const RINGS: u32 = 5;

/// Cosine between the outward normals of two edges above which they do not face each other.
const FACING: f64 = 0.3;

/// Contacts of more than this share of the border's edges are too many.
const FEW: f64 = 0.25;

/// Shift parts of the border that overlap or are nearer than `gap` out of each other. The map has no flips
/// then, nor does its border overlap. `None` where it overlaps in too many places, or still does.
pub fn separate(disk: &Disk, mut uv: UvMap, border: &Border, gap: f64) -> Option<UvMap> {
    let edges: usize = border.loops.iter().map(Vec::len).sum();
    let fans = Fans::of(disk);
    for round in 0..ROUNDS {
        let touching = contacts(border, &uv, gap);
        if touching.is_empty() {
            if count_flips(disk, &uv) == 0 {
                return Some(uv);
            }
            uv = untangle(disk, uv).ok()?;
            continue;
        }
        if touching.len() as f64 > FEW * edges as f64 + 8.0 {
            return None;
        }
        let rings = RINGS + RINGS * (round / WIDEN);
        // What was turned over on the way would be in the way.
        if round % WIDEN == WIDEN - 1 && count_flips(disk, &uv) > 0 {
            uv = untangle(disk, uv).ok()?;
            continue;
        }
        let mut shift = vec![(DVec2::ZERO, 0.0); uv.len()];
        for [e, f] in &touching {
            let Some(way) = way_out(&uv, e, f, gap) else { continue };
            for (v, share) in shares(disk, &fans, [e, f], rings) {
                let (sum, weight) = &mut shift[v as usize];
                *sum += share * way;
                *weight += share.abs();
            }
        }
        for (p, (sum, weight)) in uv.iter_mut().zip(shift) {
            *p += sum / f64::max(weight, 1.0);
        }
    }
    None
}

/// Half of what an edge `f` must move by to leave `e`: across both, as far as the end that is in least.
fn way_out(uv: &[DVec2], e: &Edge, f: &Edge, gap: f64) -> Option<DVec2> {
    let ends = |edge: &Edge| edge.vertices.map(|v| uv[v as usize]);
    let out = |edge: &Edge| {
        let [a, b] = ends(edge);
        -(b - a).perp().normalize_or_zero()
    };
    // Edges that look the same way, as next to the ends of a cut, come apart with their neighbours.
    if out(e).dot(out(f)) > FACING {
        return None;
    }
    let way = (out(e) - out(f)).try_normalize()?;
    let depth = |of: &Edge, through: &Edge, way: DVec2| {
        let (out, [a, _]) = (out(through), ends(through));
        let inside = ends(of).map(|p| (a - p).dot(out) / way.dot(out).max(0.2));
        inside.into_iter().filter(|depth| *depth > 0.0).fold(f64::INFINITY, f64::min)
    };
    let depth = depth(f, e, way).min(depth(e, f, -way));
    let length = |edge: &Edge| ends(edge)[0].distance(ends(edge)[1]);
    Some(way * 0.5 * (depth.min(length(e)).min(length(f)) + 1.25 * gap))
}

/// Vertices within so many rings of either edge, with a share that falls with the rings: positive by the second,
/// negative by the first, 0 in the middle, so that what lies between, as at the end of a cut, is opened evenly.
fn shares(disk: &Disk, fans: &Fans, edges: [&Edge; 2], rings: u32) -> BTreeMap<u32, f64> {
    let far = rings + 1;
    let mut ring: BTreeMap<u32, [u32; 2]> = BTreeMap::new();
    for (k, edge) in edges.iter().enumerate() {
        for (v, at) in fans.around(disk, &edge.vertices, rings) {
            ring.entry(v).or_insert([far; 2])[k] = at;
        }
    }
    let share = |[first, second]: [u32; 2]| {
        let sum = f64::from(first + second).max(1.0);
        let falls = |at: u32| (1.0 - f64::from(at) / f64::from(far)).powi(2);
        falls(second) * f64::from(first) / sum - falls(first) * f64::from(second) / sum
    };
    ring.into_iter().map(|(v, at)| (v, share(at))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::{Disk, certify_within, count_flips, is_clear, quality};
    use glam::{DVec2, DVec3};

    /// A ring of `n` × 4 cells, opened along a radius, that goes around by `turns`.
    fn ring(n: usize, turns: f64) -> (Disk, UvMap) {
        let at = |angle: f64, k: usize| DVec2::from_angle(angle) * (1.0 + 0.25 * k as f64);
        let angles =
            |turns: f64| (0..=n).map(move |i| std::f64::consts::TAU * turns * i as f64 / n as f64);
        let points = |turns: f64| -> UvMap {
            angles(turns).flat_map(|angle| (0..5).map(move |k| at(angle, k))).collect()
        };
        let mut triangles = Vec::new();
        for i in 0..n as u32 {
            for k in 0..4 {
                let [a, b] = [5 * i + k, 5 * i + 5 + k];
                triangles.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
            }
        }
        let flat: Vec<DVec3> = points(0.99).iter().map(|p| p.extend(0.0)).collect();
        (Disk::new(flat, triangles), points(turns))
    }

    #[test]
    fn sides_of_a_cut_that_overlap_come_apart() {
        for turns in [1.001, 1.004, 1.01] {
            let (disk, uv) = ring(60, turns);
            let border = Border::of(&disk);
            assert!(!certify_within(&border, &disk, &uv).is_injective());
            let apart = separate(&disk, uv.clone(), &border, 1e-3).unwrap();
            assert!(certify_within(&border, &disk, &apart).is_injective(), "{turns}");
            assert!(is_clear(&border, &apart, 1e-3) && count_flips(&disk, &apart) == 0);
            let [before, after] = [&uv, &apart].map(|uv| quality(&disk, uv).mean - 1.0);
            assert!(after < before + 0.01, "{before} {after}");
        }
    }

    #[test]
    fn what_is_clear_stays() {
        let (disk, uv) = ring(60, 0.9);
        assert_eq!(separate(&disk, uv.clone(), &Border::of(&disk), 1e-3), Some(uv));
    }

    #[test]
    fn a_chart_that_lies_on_itself_is_given_up() {
        let (disk, uv) = ring(60, 1.5);
        assert_eq!(separate(&disk, uv, &Border::of(&disk), 1e-3), None);
    }
}
