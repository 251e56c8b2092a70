//! Flips that a map carried over from a coarser mesh leaves at its border, at slivers and in noise are mended
//! where they are: in a patch about them, which grows, each vertex in turn goes where its faces are most
//! nearly rigid (Liu et al. 2008, "A local/global approach to mesh parameterization",
//! doi:10.1111/j.1467-8659.2008.01290.x), which turns most flipped faces back. What cannot lie flat, as a
//! spike of noise, is then moved to where its faces are positive (projections onto half-planes; Agmon 1954,
//! doi:10.4153/CJM-1954-037-2). The rest stays.

use glam::{DMat2, DVec2};

use super::lscm::hat_gradients;
use super::relax::Fans;
use super::{Disk, UvMap, is_positive};
use crate::mesh::NONE;

/// Rings of faces about the flipped ones that a patch has at first …
const RINGS: u32 = 2;

/// … and times that they are doubled.
const GROWTHS: u32 = 3;

/// Rounds over a patch before it grows.
const ROUNDS: u32 = 60;

/// Rounds in which vertices are set free.
const FREED: u32 = 24;

/// Projections of one vertex.
const PROJECTIONS: u32 = 12;

/// Least height of a face that is set free, over its base.
const ROOM: f64 = 0.02;

/// Share of faces that may be flipped where mending is tried.
const FEW: f64 = 0.1;

/// The map, at the scale of the disk, without flips, where they could be mended; `None` where they are too
/// many, or stay.
pub fn untangle(disk: &Disk, mut uv: UvMap) -> Option<UvMap> {
    let mut flipped = flips(disk, &uv);
    if flipped.len() as f64 > FEW * disk.triangles.len() as f64 + 8.0 {
        return None;
    }
    let fans = if flipped.is_empty() { return Some(uv) } else { Fans::of(disk) };
    for growth in 0..=GROWTHS {
        let patch = around(disk, &fans, &flipped, RINGS << growth);
        for round in 0..ROUNDS {
            for &v in &patch {
                make_rigid(disk, &mut uv, v as usize, fans.at(v as usize));
            }
            if round % 8 == 7 && patch_is_sound(disk, &fans, &patch, &uv) {
                break;
            }
        }
        flipped = flips(disk, &uv);
        for round in 0..FREED {
            if flipped.is_empty() {
                break;
            }
            for v in around(disk, &fans, &flipped, round / 8) {
                set_free(disk, &mut uv, v as usize, fans.at(v as usize));
            }
            flipped = flips(disk, &uv);
        }
        if flipped.is_empty() {
            return Some(uv);
        }
    }
    None
}

/// Move a vertex into the half-planes in which its faces are positive, from the mean of its neighbours.
fn set_free(disk: &Disk, uv: &mut UvMap, v: usize, fan: &[u32]) {
    let edge = |c: u32, uv: &UvMap| {
        let (t, k) = (disk.triangles[c as usize / 3], c as usize % 3);
        [t[(k + 1) % 3], t[(k + 2) % 3]].map(|w| uv[w as usize])
    };
    let positive = |p: DVec2, uv: &UvMap| {
        fan.iter().all(|&c| {
            let [a, b] = edge(c, uv);
            is_positive([p, a, b])
        })
    };
    if positive(uv[v], uv) {
        return;
    }
    let mean = fan.iter().flat_map(|&c| edge(c, uv)).sum::<DVec2>() / (2.0 * fan.len() as f64);
    for from in [mean, uv[v]] {
        let mut p = from;
        for _ in 0..PROJECTIONS {
            for &c in fan {
                let [a, b] = edge(c, uv);
                let inwards = (b - a).perp().normalize_or_zero();
                let room = ROOM * a.distance(b);
                let inside = inwards.dot(p - a);
                if inside < room {
                    p += inwards * (room - inside);
                }
            }
            if positive(p, uv) {
                uv[v] = p;
                return;
            }
        }
    }
}

/// Vertices within so many rings of faces.
fn around(disk: &Disk, fans: &Fans, faces: &[u32], rings: u32) -> Vec<u32> {
    let mut ring = vec![NONE; disk.positions.len()];
    let mut patch: Vec<u32> = Vec::new();
    for v in faces.iter().flat_map(|&f| disk.triangles[f as usize]) {
        if ring[v as usize] == NONE {
            ring[v as usize] = 0;
            patch.push(v);
        }
    }
    let mut at = 0;
    while at < patch.len() {
        let v = patch[at] as usize;
        at += 1;
        if ring[v] >= rings {
            break;
        }
        for w in fans.at(v).iter().flat_map(|&c| disk.triangles[c as usize / 3]) {
            if ring[w as usize] == NONE {
                ring[w as usize] = ring[v] + 1;
                patch.push(w);
            }
        }
    }
    patch
}

/// Move a vertex to where its faces are nearest to the rotations that they are nearest to.
pub(super) fn make_rigid(disk: &Disk, uv: &mut UvMap, v: usize, fan: &[u32]) {
    let (mut pull, mut stiffness) = (DVec2::ZERO, 0.0);
    for &c in fan {
        let (f, k) = (c as usize / 3, c as usize % 3);
        let area = disk.areas[f];
        if area > 0.0 {
            let j = disk.jacobian(f, uv);
            let turn = DMat2::from_angle((j.x_axis.y - j.y_axis.x).atan2(j.x_axis.x + j.y_axis.y));
            let hat = hat_gradients(&disk.rest[f])[k];
            pull += (j - turn) * hat * area;
            stiffness += area * hat.length_squared();
        }
    }
    let step = pull / stiffness;
    if step.is_finite() {
        uv[v] -= step;
    }
}

fn patch_is_sound(disk: &Disk, fans: &Fans, patch: &[u32], uv: &[DVec2]) -> bool {
    patch.iter().flat_map(|&v| fans.at(v as usize)).all(|&c| {
        let f = c as usize / 3;
        disk.areas[f] <= 0.0 || is_positive(disk.triangles[f].map(|v| uv[v as usize]))
    })
}

fn flips(disk: &Disk, uv: &[DVec2]) -> Vec<u32> {
    let flipped = |f: &u32| {
        let f = *f as usize;
        disk.areas[f] > 0.0 && !is_positive(disk.triangles[f].map(|v| uv[v as usize]))
    };
    (0..disk.triangles.len() as u32).filter(flipped).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::samples;

    #[test]
    fn a_vertex_pushed_through_its_neighbours_comes_back() {
        let (disk, mut uv) = samples::plane(12, 12, 1.0, 1.0);
        uv[70] += DVec2::splat(0.2);
        assert!(!flips(&disk, &uv).is_empty());
        let mended = untangle(&disk, uv).unwrap();
        assert!(flips(&disk, &mended).is_empty());
    }

    #[test]
    fn a_mirrored_map_is_not_tried() {
        let (disk, uv) = samples::plane(12, 12, 1.0, 1.0);
        assert_eq!(untangle(&disk, uv.iter().map(|p| DVec2::new(-p.x, p.y)).collect()), None);
    }
}
