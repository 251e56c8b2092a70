//! The frame in which a chart's networks work: positions about the chart's centre and UVs about the
//! start map's, both in units of the chart's radius; and the inputs of the forward mapper.

use glam::{DVec2, DVec3};

use super::TrainChart;
use super::mapper::BOUNDARY;

/// Centre and radius of a chart.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    centre: DVec3,
    uv_centre: DVec2,
    /// Radius of the sphere about the centre, world units. Above 0.
    pub radius: f64,
}

/// Channels of a vertex after its position: normal, boundary features, start UV.
pub(super) const REST: usize = 3 + BOUNDARY + 2;

impl Frame {
    /// The frame of a chart: the middle of its bounding box and the farthest vertex from there.
    pub fn new(chart: &TrainChart) -> Self {
        let (low, high) = bounds(&chart.disk.positions, DVec3::min, DVec3::max);
        let (uv_low, uv_high) = bounds(chart.start, DVec2::min, DVec2::max);
        let (centre, uv_centre) = (0.5 * (low + high), 0.5 * (uv_low + uv_high));
        let farthest = chart.disk.positions.iter().map(|p| p.distance(centre)).fold(0.0, f64::max);
        let radius = if farthest > 0.0 { farthest } else { 1.0 };
        Self { centre, uv_centre, radius }
    }

    /// A point in the frame.
    pub fn point(&self, p: DVec3) -> [f32; 3] {
        ((p - self.centre) / self.radius).as_vec3().to_array()
    }

    /// A UV in the frame.
    pub fn uv(&self, u: DVec2) -> [f32; 2] {
        ((u - self.uv_centre) / self.radius).as_vec2().to_array()
    }

    /// A start UV moved by what the forward mapper adds, in world units.
    pub fn moved(&self, start: DVec2, delta: [f32; 2]) -> DVec2 {
        start + DVec2::new(f64::from(delta[0]), f64::from(delta[1])) * self.radius
    }

    /// The channels of a vertex after its position.
    pub fn rest(&self, chart: &TrainChart, vertex: usize) -> [f32; REST] {
        let n = chart.normals[vertex].as_vec3();
        let [rho, boundary, crease] =
            [&chart.rho, &chart.boundary, &chart.crease].map(|a| a[vertex] as f32);
        let [u, v] = self.uv(chart.start[vertex]);
        [n.x, n.y, n.z, rho, boundary, crease, u, v]
    }
}

fn bounds<T: Copy + Default>(all: &[T], low: fn(T, T) -> T, high: fn(T, T) -> T) -> (T, T) {
    let first = all.first().copied().unwrap_or_default();
    all.iter().fold((first, first), |(a, b), &x| (low(a, x), high(b, x)))
}
