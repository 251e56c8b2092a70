//! A chart to train on that has no isometric map, for tests and benchmarks.

use glam::{DVec2, DVec3};
use uvsegnet::flatten::{Disk, UvMap};
use uvsegnet::parameterization::TrainChart;

/// A strip of a barrel, bent both ways, and a skewed start map.
pub struct Barrel {
    disk: Disk,
    /// Its parameters, skewed.
    pub start: UvMap,
}

impl Barrel {
    /// A strip of so many quads around and along.
    pub fn new(columns: u32, rows: u32) -> Self {
        let (mut positions, mut start, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
        for j in 0..=rows {
            for i in 0..=columns {
                let (u, v) = (f64::from(i) / f64::from(columns), f64::from(j) / f64::from(rows));
                let (angle, height) = (2.0 * (u - 0.5), v - 0.5);
                let radius = 1.0 - 0.8 * height * height;
                positions.push(DVec3::new(radius * angle.sin(), height, radius * angle.cos()));
                start.push(DVec2::new(1.5 * u, v + 0.1 * u * u));
            }
        }
        for j in 0..rows {
            for i in 0..columns {
                let a = j * (columns + 1) + i;
                let above = a + columns + 1;
                triangles.extend([[a, a + 1, above + 1], [a, above + 1, above]]);
            }
        }
        Self { disk: Disk::new(positions, triangles), start }
    }

    /// The strip as a chart far from any part boundary; `id` decides its random numbers.
    pub fn chart(&self, id: u64) -> TrainChart<'_> {
        let positions = &self.disk.positions;
        let zeros = || vec![0.0; positions.len()];
        TrainChart {
            disk: &self.disk,
            start: &self.start,
            normals: positions.iter().map(|p| DVec3::new(p.x, 0.0, p.z).normalize()).collect(),
            rho: zeros(),
            boundary: zeros(),
            crease: zeros(),
            cylinder: None,
            over_cut: None,
            id,
        }
    }
}
