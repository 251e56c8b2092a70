//! Shapes whose best charts are known, for tests.

use glam::DVec3;

use crate::contract::{Run, Winding};
use crate::mesh::{Scene, Surface, condition};

/// A conditioned surface; vertices at one place are one.
pub fn surface(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Surface {
    let scene = Scene::from_triangles(positions, triangles);
    condition(&scene, Winding::Surface, &Run::quiet()).unwrap().surface
}

/// Quads as two triangles each.
pub fn quads(positions: Vec<DVec3>, quads: &[[u32; 4]]) -> Surface {
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    surface(positions, triangles)
}

/// The same shape beside a plate of 60 × 60, on whose page nothing small is too long.
pub fn beside_a_plate(s: &Surface) -> Surface {
    let first = s.positions.len() as u32;
    let corners = [(0.0, 0.0), (60.0, 0.0), (60.0, 60.0), (0.0, 60.0)];
    let plate = corners.map(|(x, y)| DVec3::new(x + 10.0, y, 0.0));
    let positions = s.positions.iter().copied().chain(plate).collect();
    let two = [[first, first + 1, first + 2], [first, first + 2, first + 3]];
    surface(positions, s.triangles.iter().copied().chain(two).collect())
}

/// A box from the origin.
pub fn solid_box(x: f64, y: f64, z: f64) -> Surface {
    let corner =
        |i: u32| DVec3::new(f64::from(i & 1) * x, f64::from(i >> 1 & 1) * y, f64::from(i >> 2) * z);
    let sides =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    quads((0..8).map(corner).collect(), &sides)
}

/// The corners of a regular polygon of radius 1.
pub fn ring(n: u32, z: f64) -> impl Iterator<Item = DVec3> {
    (0..n).map(move |i| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / f64::from(n)).sin_cos();
        DVec3::new(cos, sin, z)
    })
}

/// The side of such a prism, open at both ends.
pub fn open_tube(n: u32, height: f64) -> Surface {
    let around = |i: u32| [i, (i + 1) % n, n + (i + 1) % n, n + i];
    let sides: Vec<[u32; 4]> = (0..n).map(around).collect();
    quads(ring(n, 0.0).chain(ring(n, height)).collect(), &sides)
}

/// A closed prism over a regular polygon of `n` corners and radius 1, `height` high.
pub fn prism(n: u32, height: f64) -> Surface {
    let ends = ring(n, 0.0).chain(ring(n, height));
    let positions = ends.chain([DVec3::ZERO, DVec3::Z * height]);
    let mut triangles = Vec::new();
    for i in 0..n {
        let j = (i + 1) % n;
        triangles.extend([[i, j, n + j], [i, n + j, n + i]]);
        triangles.extend([[j, i, 2 * n], [n + i, n + j, 2 * n + 1]]);
    }
    surface(positions.collect(), triangles)
}
