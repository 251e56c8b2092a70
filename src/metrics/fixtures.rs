//! Small surfaces with known figures, for tests.

use glam::DVec3;

use crate::mesh::{NONE, Surface};
use crate::metrics::Measured;

/// A surface from welded triangles; half-edges of opposite direction are twins, the flattest first.
pub(crate) fn surface(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Surface {
    let n = triangles.len();
    let low = positions.iter().fold(DVec3::INFINITY, |a, &p| a.min(p));
    let high = positions.iter().fold(DVec3::NEG_INFINITY, |a, &p| a.max(p));
    let cross = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        (b - a).cross(c - a)
    };
    let mut surface = Surface {
        normals: triangles.iter().map(|t| cross(t).normalize_or_zero()).collect(),
        areas: triangles.iter().map(|t| 0.5 * cross(t).length()).collect(),
        twin: vec![NONE; 3 * n],
        sheet_mate: vec![NONE; n],
        origins: vec![Default::default(); n],
        diagonal: low.distance(high),
        positions,
        triangles,
        ..Surface::default()
    };
    let mut pairs = vec![];
    for h in 0..3 * n as u32 {
        for t in h + 1..3 * n as u32 {
            if surface.from(h) == surface.to(t) && surface.to(h) == surface.from(t) {
                let flat = surface.normals[h as usize / 3].dot(surface.normals[t as usize / 3]);
                pairs.push((flat, h, t));
            }
        }
    }
    pairs.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    for (_, h, t) in pairs {
        if surface.twin[h as usize] == NONE && surface.twin[t as usize] == NONE {
            surface.twin[h as usize] = t;
            surface.twin[t as usize] = h;
        }
    }
    for f in 0..n {
        let turned = |g: &usize| {
            let (mut a, mut b) = (surface.triangles[f], surface.triangles[*g]);
            a.sort_unstable();
            b.sort_unstable();
            a == b && surface.normals[f].dot(surface.normals[*g]) < 0.0
        };
        surface.sheet_mate[f] = (0..n).find(turned).map_or(NONE, |g| g as u32);
    }
    surface
}

/// An `nx` × `ny` grid over the unit square, mapped by `place`; positions that coincide are welded.
/// Also the parameters of each corner.
pub(crate) fn grid(
    nx: u32,
    ny: u32,
    place: impl Fn(f64, f64) -> DVec3,
) -> (Surface, Vec<[[f64; 2]; 3]>) {
    let mut positions: Vec<DVec3> = vec![];
    let mut index = vec![];
    let parameter =
        |i: u32| [f64::from(i / (ny + 1)) / f64::from(nx), f64::from(i % (ny + 1)) / f64::from(ny)];
    for i in 0..(nx + 1) * (ny + 1) {
        let [x, y] = parameter(i);
        let p = place(x, y);
        let known = positions.iter().position(|q| q.distance(p) < 1e-9);
        index.push(known.unwrap_or_else(|| {
            positions.push(p);
            positions.len() - 1
        }) as u32);
    }
    let corners: Vec<[u32; 3]> = (0..nx)
        .flat_map(|i| (0..ny).map(move |j| i * (ny + 1) + j))
        .flat_map(|a| [[a, a + ny + 1, a + ny + 2], [a, a + ny + 2, a + 1]])
        .collect();
    let triangles = corners.iter().map(|t| t.map(|v| index[v as usize])).collect();
    (surface(positions, triangles), corners.iter().map(|t| t.map(parameter)).collect())
}

/// Single-precision corners of parameters, moved by `place`.
pub(crate) fn uvs(
    parameters: &[[[f64; 2]; 3]],
    place: impl Fn([f64; 2]) -> [f64; 2],
) -> Vec<[[f32; 2]; 3]> {
    parameters.iter().map(|t| t.map(|p| place(p).map(|x| x as f32))).collect()
}

/// The unit cube, outward, two faces a side in the order −x +x −y +y −z +z, and a map that lays its
/// six sides out in a 3 × 2 table of cells, each side 0.25 wide.
pub(crate) fn cube() -> (Surface, Vec<[[f32; 2]; 3]>) {
    let positions: Vec<DVec3> = (0..8)
        .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
        .collect();
    let sides: [[u32; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let mut triangles = vec![];
    let mut uvs = vec![];
    for (i, s) in sides.iter().enumerate() {
        let (x, y) = (0.05 + 0.3 * (i % 3) as f32, 0.05 + 0.3 * (i / 3) as f32);
        let p = [[x, y], [x + 0.25, y], [x + 0.25, y + 0.25], [x, y + 0.25]];
        triangles.extend([[s[0], s[1], s[2]], [s[0], s[2], s[3]]]);
        uvs.extend([[p[0], p[1], p[2]], [p[0], p[2], p[3]]]);
    }
    (surface(positions, triangles), uvs)
}

/// A result on one page; charts and parts are numbered from 0.
pub(crate) fn measured<'a>(
    surface: &'a Surface,
    uvs: &'a [[[f32; 2]; 3]],
    chart_of: &'a [u32],
    part_of: &'a [u32],
) -> Measured<'a> {
    let count = |of: &[u32]| of.iter().filter(|c| **c != NONE).max().map_or(0, |m| *m as usize + 1);
    Measured {
        surface,
        uvs,
        chart_of,
        part_of,
        charts: count(chart_of),
        parts: count(part_of),
        boundary_labels: None,
        page_size: 1024,
        pages: 1,
        page_of: &[],
        chamfer: &[],
    }
}
