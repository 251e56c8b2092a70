//! One chart as a triangle mesh of its own, cut open: a vertex on a cut stands once for each side.
//! Holds each triangle's rest shape, so that the Jacobian of any map is one small product.

use super::{FlattenError, Pattern};
use glam::{DMat2, DVec2, DVec3};

use crate::tasks;

/// One coordinate pair a vertex of a [`Disk`], world units, v up.
pub type UvMap = Vec<DVec2>;

/// A triangle mesh to be flattened.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Disk {
    /// Vertex positions, world units.
    pub positions: Vec<DVec3>,
    /// Vertex triples, consistently wound. Length: faces.
    pub triangles: Vec<[u32; 3]>,
    /// Triangle areas in 3D. Length: faces.
    pub areas: Vec<f64>,
    /// Inverse of each triangle's edge matrix in its own plane: with `E = [u1−u0 | u2−u0]` the
    /// Jacobian of a map is `E · rest`. Zero for triangles without area. Length: faces.
    pub rest: Vec<DMat2>,
}

impl Disk {
    /// A disk from vertices and triangles; computes areas and rest shapes.
    pub fn new(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Self {
        let flat = |f: usize| {
            let [a, b, c] = triangles[f].map(|v| positions[v as usize]);
            let flat = flatten_triangle(a, b, c);
            let area = 0.5 * flat[1].x * flat[2].y;
            let edges = DMat2::from_cols(flat[1], flat[2]);
            (area, if area > 0.0 { edges.inverse() } else { DMat2::ZERO })
        };
        let (areas, rest) = tasks::fill("rest shapes", triangles.len(), flat).into_iter().unzip();
        Self { positions, triangles, areas, rest }
    }

    /// The pattern of systems on its vertices.
    pub fn pattern(&self) -> Result<Pattern, FlattenError> {
        Pattern::of(self.positions.len(), &self.triangles)
    }

    /// Total 3D area.
    pub fn area(&self) -> f64 {
        self.areas.iter().sum()
    }

    /// Jacobian of the map `uv` on triangle `f`: tangent plane → UV.
    pub fn jacobian(&self, f: usize, uv: &[DVec2]) -> DMat2 {
        let [a, b, c] = self.triangles[f].map(|v| uv[v as usize]);
        DMat2::from_cols(b - a, c - a) * self.rest[f]
    }

    /// Signed UV area of triangle `f`.
    pub fn uv_area(&self, f: usize, uv: &[DVec2]) -> f64 {
        let [a, b, c] = self.triangles[f].map(|v| uv[v as usize]);
        0.5 * (b - a).perp_dot(c - a)
    }
}

/// The triangle laid in the plane: first corner at the origin, second on the positive x axis, third
/// with y ≥ 0.
pub fn flatten_triangle(a: DVec3, b: DVec3, c: DVec3) -> [DVec2; 3] {
    let (e, g) = (b - a, c - a);
    let length = e.length();
    if length == 0.0 {
        return [DVec2::ZERO; 3];
    }
    let height = e.cross(g).length() / length;
    [DVec2::ZERO, DVec2::new(length, 0.0), DVec2::new(e.dot(g) / length, height)]
}
