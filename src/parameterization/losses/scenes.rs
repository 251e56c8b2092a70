//! Small charts with known maps, for the tests of the losses.

use glam::{DVec2, DVec3};

use super::{ChartTerms, CutEdge, CylinderTarget, LossContext, OverCut};
use crate::contract::LossForm;
use crate::flatten::{Disk, UvMap};

/// A chart and a map of it.
pub(crate) struct Scene {
    pub name: &'static str,
    pub disk: Disk,
    pub uv: UvMap,
}

/// A pseudo-random number from −1 to 1.
pub(crate) fn noise(seed: u64, index: usize) -> f64 {
    let mut x = (seed << 32 | index as u64).wrapping_add(0x9E37_79B9_7F4A_7C15);
    for factor in [0xBF58_476D_1CE4_E5B9_u64, 0x94D0_49BB_1331_11EB] {
        x = (x ^ (x >> 29)).wrapping_mul(factor);
    }
    ((x ^ (x >> 32)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// A grid of `n` × `m` cells, each with its corners placed by column and row in space and in UV, those
/// cells that `keep` keeps, with alternating diagonals.
fn grid(
    name: &'static str,
    [n, m]: [usize; 2],
    keep: impl Fn(usize, usize) -> bool,
    place: impl Fn(usize, usize) -> (DVec3, DVec2),
) -> Scene {
    let corners = (0..=m).flat_map(|row| (0..=n).map(move |column| (column, row)));
    let (positions, uv) = corners.map(|(column, row)| place(column, row)).unzip();
    let at = |column: usize, row: usize| (row * (n + 1) + column) as u32;
    let mut triangles = Vec::new();
    for row in 0..m {
        for column in (0..n).filter(|column| keep(*column, row)) {
            let (a, b) = (at(column, row), at(column + 1, row));
            let (c, d) = (at(column + 1, row + 1), at(column, row + 1));
            triangles.extend(match (row + column) % 2 {
                0 => [[a, b, c], [a, c, d]],
                _ => [[a, b, d], [b, c, d]],
            });
        }
    }
    Scene { name, disk: Disk::new(positions, triangles), uv }
}

/// A hilly square of `n` × `n` cells of size 1, and a crumpled map of it without a flip.
pub(crate) fn hills(n: usize, seed: u64) -> Scene {
    grid(
        "hills",
        [n, n],
        |_, _| true,
        |column, row| {
            let k = row * (n + 1) + column;
            let jitter = |axis: u64| 0.2 * noise(seed, 8 * k + axis as usize);
            let (x, y) = (column as f64 + jitter(0), row as f64 + jitter(1));
            let z = 0.4 * (0.7 * x).sin() * (0.9 * y).cos() + 0.3 * jitter(2);
            let shift = DVec2::new(jitter(3), jitter(4)) * 0.7;
            (DVec3::new(x, y, z), DVec2::new(1.1 * x + 0.2 * y, 0.8 * y) + shift)
        },
    )
}

/// The hills, with one inner vertex pulled across its neighbours: some triangles are flipped.
pub(crate) fn flipped_hills(n: usize, seed: u64) -> Scene {
    let mut scene = hills(n, seed);
    scene.name = "flipped hills";
    let inner = (n / 2) * (n + 1) + n / 2;
    scene.uv[inner] += DVec2::new(1.9, 0.37);
    scene
}

/// A flat rectangle.
pub(crate) fn plane() -> Scene {
    let turn = glam::DQuat::from_rotation_x(0.7) * glam::DQuat::from_rotation_z(0.3);
    grid(
        "plane",
        [7, 4],
        |_, _| true,
        |column, row| {
            let k = 100 * row + column;
            let p =
                DVec2::new(column as f64, row as f64) + 0.2 * DVec2::new(noise(3, k), noise(4, k));
            (turn * p.extend(0.0), p)
        },
    )
}

/// A cylinder of radius 2, cut open, 24 flat strips round, and those strips side by side.
pub(crate) fn cylinder() -> Scene {
    let angle = std::f64::consts::TAU / 24.0;
    grid(
        "cylinder",
        [24, 6],
        |_, _| true,
        |column, row| {
            let (sin, cos) = (column as f64 * angle).sin_cos();
            let strip = 4.0 * (0.5 * angle).sin();
            let height = 1.5 * row as f64;
            (DVec3::new(2.0 * cos, 2.0 * sin, height), DVec2::new(strip * column as f64, height))
        },
    )
}

/// Side of a pyramid with 30 faces, tip above, cut open; and the sector that it develops to.
pub(crate) fn cone() -> Scene {
    let (angle, rise) = (std::f64::consts::TAU / 30.0, 5.0);
    let ray = |column: usize| {
        let (sin, cos) = (column as f64 * angle).sin_cos();
        DVec3::new(2.0 * cos, 2.0 * sin, -rise)
    };
    let opening = ray(0).angle_between(ray(1));
    grid(
        "cone",
        [30, 5],
        |_, _| true,
        |column, row| {
            let share = 1.0 - 0.15 * row as f64;
            let (sin, cos) = (column as f64 * opening).sin_cos();
            let p = ray(column) * share;
            (p + DVec3::Z * rise, DVec2::new(sin, -cos) * p.length())
        },
    )
}

/// Three squares at the corner of a box, open along one of its edges, and the L they unfold to.
pub(crate) fn box_corner() -> Scene {
    let n = 4;
    grid(
        "box corner",
        [2 * n, 2 * n],
        |c, r| c < n || r < n,
        |column, row| {
            let (x, y) = (column as f64 / n as f64, row as f64 / n as f64);
            let folded =
                DVec3::new(x.min(1.0), y.min(1.0), (x - 1.0).max(0.0) + (y - 1.0).max(0.0));
            (folded, DVec2::new(x, y))
        },
    )
}

/// Every chart whose map is an isometry.
pub(crate) fn isometries() -> [Scene; 4] {
    [plane(), cylinder(), cone(), box_corner()]
}

impl Scene {
    /// All losses of the chart. Its candidate seams join neighbouring vertices of its first row, its
    /// tube is fitted by `target`, or else (bent a little) is the map itself.
    pub fn terms(&self, form: LossForm, target: Option<CylinderTarget>) -> ChartTerms {
        let bent = |p: &DVec2| DVec2::new(p.x + 0.1 * p.y.sin(), 0.9 * p.y - 0.02 * p.x * p.x);
        let cylinder = target.unwrap_or_else(|| CylinderTarget {
            developed: self.uv.iter().map(bent).collect(),
            heights: self.disk.positions.iter().map(|p| p.y + 0.3 * p.z).collect(),
        });
        let cut = |k: u32| CutEdge {
            sides: [[k, k + 1], [k + 2, k + 3]],
            length: 0.5 + 0.1 * f64::from(k),
            cost: 0.05 + 0.3 * f64::from(k),
        };
        let over_cut = OverCut { edges: vec![cut(0), cut(1), cut(2)], radius: 3.0 };
        let classes: Vec<u32> = (0..self.uv.len() as u32).map(|v| v % 3).collect();
        let context = LossContext {
            form,
            faces: None,
            cylinder: Some(cylinder),
            over_cut: Some(over_cut),
            classes: Some(&classes),
        };
        ChartTerms::new(&self.disk, context)
    }
}
