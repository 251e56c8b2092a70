//! Disks with known maps, for tests: grids bent over known surfaces.

use glam::{DVec2, DVec3};

use super::{Disk, UvMap};

/// The triangles of a grid of `nx` × `ny` quads, x fastest.
pub(crate) fn grid(nx: usize, ny: usize) -> Vec<[u32; 3]> {
    let at = |i: usize, j: usize| (j * (nx + 1) + i) as u32;
    let mut triangles = Vec::with_capacity(2 * nx * ny);
    for j in 0..ny {
        for i in 0..nx {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            // Alternate the diagonals, so that no direction is favoured.
            if (i + j) % 2 == 0 {
                triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    triangles
}

/// A grid over [0, 1]², bent by `surface`.
pub(crate) fn bent(nx: usize, ny: usize, surface: impl Fn(f64, f64) -> DVec3) -> Disk {
    let at = |k: usize| (k % (nx + 1), k / (nx + 1));
    let positions = (0..(nx + 1) * (ny + 1))
        .map(at)
        .map(|(i, j)| surface(i as f64 / nx as f64, j as f64 / ny as f64));
    Disk::new(positions.collect(), grid(nx, ny))
}

/// A flat rectangle and the identity on it.
pub(crate) fn plane(nx: usize, ny: usize, width: f64, height: f64) -> (Disk, UvMap) {
    let disk = bent(nx, ny, |x, y| DVec3::new(width * x, height * y, 0.0));
    let uv = disk.positions.iter().map(|p| p.truncate()).collect();
    (disk, uv)
}

/// `turn` (radians) of the side of a cylinder or cone about z, cut open: the radius goes from
/// `bottom` to `top` over `height`.
pub(crate) fn tube(nx: usize, ny: usize, turn: f64, bottom: f64, top: f64, height: f64) -> Disk {
    bent(nx, ny, |x, y| {
        let direction = DVec2::from_angle(turn * x) * (bottom + (top - bottom) * y);
        direction.extend(height * y)
    })
}

/// The side of a barrel, cut open along one line: doubly curved.
pub(crate) fn barrel(nx: usize, ny: usize) -> Disk {
    bent(nx, ny, |x, y| {
        let radius = 1.0 + 0.3 * (std::f64::consts::PI * y).sin();
        (DVec2::from_angle(std::f64::consts::TAU * x) * radius).extend(3.0 * y)
    })
}

/// Five faces of a unit box laid out as a cross: the bottom and four sides cut apart.
pub(crate) fn open_box() -> Disk {
    let mut positions: Vec<DVec3> = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
        .map(|(x, y)| DVec3::new(x, y, 0.0))
        .to_vec();
    let mut triangles = vec![[0, 2, 1], [0, 3, 2]];
    for k in 0..4u32 {
        // Each side has its own two top vertices: the vertical edges are cut.
        let (a, b) = (k, (k + 1) % 4);
        let top = positions.len() as u32;
        for v in [a, b] {
            positions.push(positions[v as usize] + DVec3::Z);
        }
        triangles.extend([[a, b, top + 1], [a, top + 1, top]]);
    }
    Disk::new(positions, triangles)
}
