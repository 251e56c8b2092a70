//! Pinches: a border that comes twice to the same vertex of the surface, as where two corners of a chart meet in a
//! point. In the plane it touches itself there, and a border must not; a few steps of the lattice on which final
//! coordinates lie are enough to part its corners, each drawn into its own faces.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use super::{Border, Disk, UvMap};

/// How far a corner is drawn in, over the distance that a border keeps from itself.
const DRAWN: f64 = 2.0;

/// Corners in one place beyond which nothing is parted: no shape has such vertices, and pairs grow with the square.
const MOST: usize = 64;

/// The map with its pinched corners drawn in; `None` where there is no pinch. Flips and crossings are the caller's to
/// look for.
pub fn parted(disk: &Disk, border: &Border, uv: &UvMap, clearance: f64) -> Option<UvMap> {
    let pinched = pinched(disk, border, uv, clearance);
    if pinched.is_empty() {
        return None;
    }
    let mut inward: BTreeMap<u32, DVec2> = pinched.into_iter().map(|v| (v, DVec2::ZERO)).collect();
    for t in &disk.triangles {
        for k in 0..3 {
            let Some(sum) = inward.get_mut(&t[k]) else { continue };
            let [p, a, b] = [t[k], t[(k + 1) % 3], t[(k + 2) % 3]].map(|v| uv[v as usize]);
            // Integral of the direction over the corner's angle.
            let (a, b) = ((a - p).normalize_or_zero(), (b - p).normalize_or_zero());
            let half = 0.5 * a.dot(b).clamp(-1.0, 1.0).acos();
            *sum += 2.0 * half.sin() * (a + b).normalize_or_zero();
        }
    }
    let mut uv = uv.clone();
    for (v, sum) in inward {
        uv[v as usize] += DRAWN * clearance * sum.normalize_or_zero();
    }
    Some(uv)
}

/// Vertices of a border that lie on another of the same place, in the plane as in space.
fn pinched(disk: &Disk, border: &Border, uv: &UvMap, clearance: f64) -> Vec<u32> {
    let bits = |p: DVec3| p.to_array().map(f64::to_bits);
    let mut at: BTreeMap<[u64; 3], Vec<u32>> = BTreeMap::new();
    for &v in border.loops.iter().flatten() {
        at.entry(bits(disk.positions[v as usize])).or_default().push(v);
    }
    let near = |v: u32, w: u32| v != w && uv[v as usize].distance(uv[w as usize]) < clearance;
    let has_other = |group: &[u32], v: u32| group.iter().any(|&w| near(v, w));
    let groups = at.into_values().filter(|group| (2..=MOST).contains(&group.len()));
    groups
        .flat_map(|group| group.clone().into_iter().filter(move |&v| has_other(&group, v)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::{count_flips, has_simple_boundary, is_clear, planar};

    #[test]
    fn corners_that_meet_in_a_point_are_parted_and_nothing_else_moves() {
        // A path of seven cells whose last touches the first at (1, 1), where it has a vertex of its own.
        let path = [[0, 0], [0, -1], [1, -1], [2, -1], [2, 0], [2, 1], [1, 1]];
        let mut positions: Vec<DVec3> = Vec::new();
        let mut triangles = Vec::new();
        for (i, [x, y]) in path.into_iter().enumerate() {
            let corners = [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]].map(|[x, y]| {
                let p = DVec3::new(f64::from(x), f64::from(y), 0.0);
                let own = i == 6 && p == DVec3::new(1.0, 1.0, 0.0);
                let known = positions.iter().position(|q| *q == p).filter(|_| !own);
                known.unwrap_or_else(|| {
                    positions.push(p);
                    positions.len() - 1
                }) as u32
            });
            let [a, b, c, d] = corners;
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        let disk = Disk::new(positions, triangles);
        let (uv, border) = (planar(&disk), Border::of(&disk));
        let clearance = 1e-6;
        assert!(border.manifold && !has_simple_boundary(&border, &uv));
        let apart = parted(&disk, &border, &uv, clearance).unwrap();
        assert!(has_simple_boundary(&border, &apart) && is_clear(&border, &apart, clearance));
        assert_eq!(count_flips(&disk, &apart), 0);
        let moved: Vec<usize> = (0..uv.len()).filter(|&v| uv[v] != apart[v]).collect();
        assert_eq!(moved.len(), 2);
        assert_eq!(disk.positions[moved[0]], disk.positions[moved[1]]);
        assert!(moved.iter().all(|&v| uv[v].distance(apart[v]) < 3.0 * clearance));
        assert_eq!(parted(&disk, &border, &apart, clearance), None);
    }
}
