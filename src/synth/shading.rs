//! Smooth normals with creases: the faces round a vertex share a normal as long as they meet
//! at 30° or less, so a vertex on a crease becomes several.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::mesh::{CREASE, DisjointSets};

/// Vertices ready for a file.
pub(super) struct Shaded {
    pub positions: Vec<DVec3>,
    pub normals: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
}

/// Split the vertices at creases and give each its normal (weighted by corner angle). Faces keep
/// their order.
pub(super) fn shade(positions: &[DVec3], triangles: &[[u32; 3]]) -> Shaded {
    let corner = |f: usize, k: usize| positions[triangles[f][k] as usize];
    let normals: Vec<DVec3> = (0..triangles.len())
        .map(|f| {
            (corner(f, 1) - corner(f, 0)).cross(corner(f, 2) - corner(f, 0)).normalize_or_zero()
        })
        .collect();
    let mut across: BTreeMap<(u32, u32), usize> = BTreeMap::new();
    for (f, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            across.insert((t[k], t[(k + 1) % 3]), f);
        }
    }
    // Corners 3f + k that share a vertex and a smooth edge are one.
    let mut corners = DisjointSets::new(3 * triangles.len());
    for (&(a, b), &f) in &across {
        let Some(&g) = across.get(&(b, a)) else { continue };
        if normals[f].dot(normals[g]) < CREASE.cos() {
            continue;
        }
        for v in [a, b] {
            let at = |f: usize| (0..3).find(|&k| triangles[f][k] == v).unwrap_or(0);
            corners.join((3 * f + at(f)) as u32, (3 * g + at(g)) as u32);
        }
    }
    let mut number: Vec<u32> = vec![u32::MAX; 3 * triangles.len()];
    let mut out = Shaded { positions: vec![], normals: vec![], triangles: vec![] };
    for f in 0..triangles.len() {
        let mut t = [0; 3];
        for k in 0..3 {
            let r = corners.root((3 * f + k) as u32) as usize;
            if number[r] == u32::MAX {
                number[r] = out.positions.len() as u32;
                out.positions.push(corner(f, k));
                out.normals.push(DVec3::ZERO);
            }
            t[k] = number[r];
            let p = corner(f, k);
            let angle = (corner(f, (k + 1) % 3) - p).angle_between(corner(f, (k + 2) % 3) - p);
            out.normals[t[k] as usize] += normals[f] * angle;
        }
        out.triangles.push(t);
    }
    for n in &mut out.normals {
        *n = n.normalize_or(DVec3::Y);
    }
    out
}
