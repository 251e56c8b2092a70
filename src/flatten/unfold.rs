//! Triangle-by-triangle unfolding along a spanning tree of the dual graph: exact on developable
//! charts, a mere guess on others. The tree is grown over the longest edges first (Prim 1957), so
//! that placing a triangle loses the least precision.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::{DVec2, DVec3};

use super::disk::flatten_triangle;
use super::injective::count_flips;
use super::{Disk, UvMap};

/// Unfold a disk into the plane; `None` when the triangles do not close up, so that some are
/// flipped. Vertices that no triangle of positive area uses stay at the origin.
pub fn unfold(disk: &Disk) -> Option<UvMap> {
    let faces = disk.triangles.len();
    let across = across(disk);
    let mut uv = vec![DVec2::ZERO; disk.positions.len()];
    let mut placed = vec![false; disk.positions.len()];
    let mut done = vec![false; faces];
    let mut frontier = BinaryHeap::new();
    let corners = |f: usize| disk.triangles[f].map(|v| disk.positions[v as usize]);

    // The largest triangle is the root; further components get roots of their own.
    let mut roots: Vec<usize> = (0..faces).filter(|&f| disk.areas[f] > 0.0).collect();
    roots.sort_by(|&f, &g| disk.areas[g].total_cmp(&disk.areas[f]).then(f.cmp(&g)));
    for root in roots {
        if done[root] {
            continue;
        }
        let [a, b, c] = corners(root);
        for (v, p) in disk.triangles[root].into_iter().zip(flatten_triangle(a, b, c)) {
            if !placed[v as usize] {
                (uv[v as usize], placed[v as usize]) = (p, true);
            }
        }
        done[root] = true;
        push_edges(disk, &across, root, &done, &mut frontier);
        while let Some((_, Reverse(h))) = frontier.pop() {
            let (f, k) = (h as usize / 3, h as usize % 3);
            if done[f] {
                continue;
            }
            done[f] = true;
            let t = disk.triangles[f];
            let [a, b, c] = [k, (k + 1) % 3, (k + 2) % 3].map(|k| t[k] as usize);
            if !placed[c] {
                let solid = [a, b, c].map(|v| disk.positions[v]);
                (uv[c], placed[c]) = (third_corner(uv[a], uv[b], solid), true);
            }
            push_edges(disk, &across, f, &done, &mut frontier);
        }
    }
    (count_flips(disk, &uv) == 0).then_some(uv)
}

/// Where the third corner of a triangle lies when the first two are at `a` and `b`.
pub(super) fn third_corner(a: DVec2, b: DVec2, [pa, pb, pc]: [DVec3; 3]) -> DVec2 {
    let [_, _, apex] = flatten_triangle(pa, pb, pc);
    a + (b - a).normalize_or(DVec2::X).rotate(apex)
}

/// Offer the triangles across the edges of `f`, by the length of the edge (as the bits of a
/// positive number, which order as the number does).
fn push_edges(
    disk: &Disk,
    across: &[Option<u32>],
    f: usize,
    done: &[bool],
    frontier: &mut BinaryHeap<(u64, Reverse<u32>)>,
) {
    for k in 0..3 {
        let Some(h) = across[3 * f + k] else { continue };
        if !done[h as usize / 3] {
            let t = disk.triangles[f];
            let [a, b] = [t[k], t[(k + 1) % 3]].map(|v| disk.positions[v as usize]);
            frontier.push((a.distance(b).to_bits(), Reverse(h)));
        }
    }
}

/// The half-edge that runs the other way, for each half-edge that has one.
fn across(disk: &Disk) -> Vec<Option<u32>> {
    let ends = |h: usize| {
        let t = disk.triangles[h / 3];
        (t[h % 3], t[(h % 3 + 1) % 3])
    };
    let mut sorted: Vec<(u32, u32, u32)> =
        (0..3 * disk.triangles.len()).map(|h| (ends(h).0, ends(h).1, h as u32)).collect();
    sorted.sort_unstable();
    let find = |(a, b): (u32, u32)| {
        let at = sorted.partition_point(|&(x, y, _)| (x, y) < (b, a));
        sorted.get(at).filter(|&&(x, y, _)| (x, y) == (b, a)).map(|&(_, _, h)| h)
    };
    (0..sorted.len()).map(|h| find(ends(h))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::{certify, quality, samples};
    use std::f64::consts::TAU;

    #[test]
    fn a_box_net_unfolds_to_a_cross() {
        let disk = samples::open_box();
        let uv = unfold(&disk).unwrap();
        assert!(certify(&disk, &uv).is_injective());
        assert!(quality(&disk, &uv).max - 1.0 < 1e-12);
        // Five unit squares as a cross: from a corner of one arm to that of the opposite one.
        let farthest = uv.iter().flat_map(|p| uv.iter().map(|q| p.distance(*q)));
        assert!((farthest.fold(0.0, f64::max) - 10f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn developable_tubes_unfold_exactly() {
        // Coarse facets: unlike the closed form, unfolding is exact on them.
        let prism = samples::tube(7, 3, TAU, 1.0, 1.0, 2.0);
        assert!(quality(&prism, &unfold(&prism).unwrap()).max - 1.0 < 1e-12);
        let cone = samples::tube(200, 1, TAU, 1.0, 0.3, 1.0);
        let q = quality(&cone, &unfold(&cone).unwrap());
        assert!(q.flips == 0 && q.max - 1.0 < 1e-9, "{q:?}");
    }
}
