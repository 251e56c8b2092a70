//! The shape of one chart as the packer is given it: its own flat triangles in single precision, or,
//! where those would not survive that (the packer drops thin triangles, takes the chart apart there
//! and unwraps what is left anew, without a word), the smallest rectangle around it.

use glam::DVec2;

use crate::flatten::{Disk, smallest_rectangle};

/// The packer drops triangles thinner than 1e-6 of their mesh; a margin for rounding.
const THINNEST: f64 = 4e-6;

/// It refuses triangles smaller than 1e-12 of their chart.
const SMALLEST: f64 = 4e-12;

/// Thickness of a rectangle, as a share of its length, at the least.
const THINNEST_RECTANGLE: f64 = 1e-4;

/// Flat triangles in single precision.
#[derive(Debug, Clone)]
pub(super) struct Shape {
    /// Vertices; z is 0.
    pub positions: Vec<[f32; 3]>,
    /// The same, as texture coordinates.
    pub uvs: Vec<[f32; 2]>,
    /// Three vertices a triangle.
    pub indices: Vec<u32>,
    /// What a coordinate here stands for: `chart = coordinate · unit + low`.
    low: DVec2,
    unit: f64,
}

impl Shape {
    /// The chart's own triangles; `None` where they would not survive.
    pub fn of_triangles(disk: &Disk, uv: &[DVec2], unit: f64) -> Option<Self> {
        let used: Vec<u32> = (0..disk.triangles.len())
            .filter(|&f| disk.areas[f] > 0.0)
            .flat_map(|f| disk.triangles[f])
            .collect();
        let shape = Self::new(uv, used, unit)?;
        shape.survives().then_some(shape)
    }

    /// The smallest rectangle around the chart; `None` where the chart is a point.
    pub fn of_rectangle(uv: &[DVec2], unit: f64) -> Option<Self> {
        let corners = smallest_rectangle(uv, THINNEST_RECTANGLE)?;
        Self::new(&corners, vec![0, 1, 2, 0, 2, 3], unit)
    }

    fn new(points: &[DVec2], indices: Vec<u32>, unit: f64) -> Option<Self> {
        let used = || indices.iter().map(|&v| points[v as usize]);
        let low = used().reduce(DVec2::min).filter(|p| p.is_finite())?;
        let uvs: Vec<[f32; 2]> =
            points.iter().map(|p| ((p - low) / unit).as_vec2().to_array()).collect();
        let positions = uvs.iter().map(|&[x, y]| [x, y, 0.0]).collect();
        Some(Self { positions, uvs, indices, low, unit })
    }

    /// A vertex, in the shape's own coordinates.
    pub fn point(&self, v: u32) -> DVec2 {
        DVec2::from(self.uvs[v as usize].map(f64::from))
    }

    /// Origin of the shape's coordinates, in the chart's.
    pub fn low(&self) -> DVec2 {
        self.low
    }

    /// Length of the shape's unit, in the chart's.
    pub fn unit(&self) -> f64 {
        self.unit
    }

    /// Whether every triangle is still wound as it was and thick enough, and no two vertices have
    /// fallen together.
    fn survives(&self) -> bool {
        let mut vertices = self.indices.clone();
        vertices.sort_unstable();
        vertices.dedup();
        let low = vertices.iter().map(|&v| self.point(v)).fold(DVec2::INFINITY, DVec2::min);
        let high = vertices.iter().map(|&v| self.point(v)).fold(DVec2::NEG_INFINITY, DVec2::max);
        let diagonal = (high - low).length();
        let areas: Vec<(f64, f64)> = self
            .indices
            .chunks_exact(3)
            .map(|t| {
                let [a, b, c] = [t[0], t[1], t[2]].map(|v| self.point(v));
                let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
                ((b - a).perp_dot(c - a), longest)
            })
            .collect();
        let total: f64 = areas.iter().map(|(double, _)| double).sum();
        let thick = areas.iter().all(|&(double, longest)| {
            double > THINNEST * diagonal * longest && double > SMALLEST * total
        });
        let mut places: Vec<[u32; 2]> =
            vertices.iter().map(|&v| self.uvs[v as usize].map(|x| (x + 0.0).to_bits())).collect();
        places.sort_unstable();
        let apart = places.windows(2).all(|pair| pair[0] != pair[1]);
        thick && apart && diagonal.is_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn strip(width: f64) -> (Disk, Vec<DVec2>) {
        let uv: Vec<DVec2> =
            [(0.0, 0.0), (1.0, 0.0), (1.0, width), (0.0, width)].map(DVec2::from).to_vec();
        let positions: Vec<DVec3> = uv.iter().map(|p| p.extend(0.0)).collect();
        (Disk::new(positions, vec![[0, 1, 2], [0, 2, 3]]), uv)
    }

    #[test]
    fn sound_triangles_are_kept_and_thin_ones_are_not() {
        let (disk, uv) = strip(0.1);
        assert!(Shape::of_triangles(&disk, &uv, 1.0).is_some());
        let (disk, uv) = strip(1e-7);
        assert!(Shape::of_triangles(&disk, &uv, 1.0).is_none());
        let rectangle = Shape::of_rectangle(&uv, 1.0).unwrap();
        assert!(rectangle.survives());
        assert!(Shape::of_rectangle(&[DVec2::ZERO; 3], 1.0).is_none());
    }
}
