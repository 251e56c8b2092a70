//! Small charts whose best map is known, for tests.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::TrainChart;
use super::losses::CylinderTarget;
use crate::flatten::{Disk, UvMap};

/// A grid of `columns` × `rows` quads through `place`, two triangles each, and its parameters.
fn grid(columns: usize, rows: usize, place: impl Fn(DVec2) -> DVec3) -> (Disk, UvMap) {
    let mut positions = Vec::new();
    let mut flat = Vec::new();
    for j in 0..=rows {
        for i in 0..=columns {
            let at = DVec2::new(i as f64 / columns as f64, j as f64 / rows as f64);
            positions.push(place(at));
            flat.push(at);
        }
    }
    let mut triangles = Vec::new();
    let across = columns as u32 + 1;
    for j in 0..rows as u32 {
        for i in 0..columns as u32 {
            let a = j * across + i;
            triangles.push([a, a + 1, a + across + 1]);
            triangles.push([a, a + across + 1, a + across]);
        }
    }
    (Disk::new(positions, triangles), flat)
}

/// A bumpy sheet over the unit square; its start map is the projection.
pub fn bumpy(columns: usize, rows: usize) -> (Disk, UvMap) {
    let wave = |p: DVec2| 0.12 * (2.5 * PI * p.x).sin() * (2.0 * PI * p.y).cos();
    grid(columns, rows, |p| DVec3::new(p.x, p.y, wave(p)))
}

/// A strip of a barrel, bent both ways; the start map is its parameters: bad, as LSCM's are.
pub fn barrel(columns: usize, rows: usize) -> (Disk, UvMap) {
    let (disk, flat) = grid(columns, rows, |p| {
        let (angle, height) = ((p.x - 0.5) * 0.75 * PI, p.y - 0.5);
        let radius = 1.0 - 0.9 * height * height;
        DVec3::new(radius * angle.sin(), height, radius * angle.cos())
    });
    let start = flat.iter().map(|p| DVec2::new(1.6 * p.x, p.y + 0.15 * p.x * p.x)).collect();
    (disk, start)
}

/// Half of a cylinder of radius ½ and height 1; the start map is its projection along the axis of
/// least variance, as PCA gives it, pulled apart a little so that no triangle is flat.
pub fn half_cylinder(columns: usize, rows: usize) -> (Disk, UvMap) {
    let (disk, flat) = grid(columns, rows, |p| {
        let angle = (p.x - 0.5) * PI;
        DVec3::new(0.5 * angle.sin(), p.y, 0.5 * angle.cos())
    });
    let start =
        flat.iter().map(|p| DVec2::new(0.5 * (0.96 * (p.x - 0.5) * PI).sin(), p.y)).collect();
    (disk, start)
}

/// What the trainer is given for a chart with one label and no creases.
pub fn plain<'a>(disk: &'a Disk, start: &'a [DVec2], id: u64) -> TrainChart<'a> {
    let n = disk.positions.len();
    let mut normals = vec![DVec3::ZERO; n];
    for t in &disk.triangles {
        let [a, b, c] = t.map(|v| disk.positions[v as usize]);
        for v in t {
            normals[*v as usize] += (b - a).cross(c - a);
        }
    }
    TrainChart {
        disk,
        start,
        normals: normals.iter().map(|n| n.normalize_or_zero()).collect(),
        rho: vec![0.0; n],
        boundary: vec![0.0; n],
        crease: vec![0.0; n],
        cylinder: None::<CylinderTarget>,
        over_cut: None,
        id,
    }
}
