//! The shape diameter function (Shapira, Shamir and Cohen-Or 2008, doi:10.1007/s00371-007-0197-5): how
//! far it is through the object to its other side, from rays in a cone about the inward normal.

use glam::DVec3;
use rayon::prelude::*;

use crate::mesh::Surface;
use crate::mesh::rays::Rays;
use crate::tasks;

/// Rays about the middle one.
const AROUND: u32 = 4;

/// Half angle of the cone, as sine and cosine (35°; the paper's 60° sees around corners of thin
/// parts).
const SIN: f64 = 0.573_576;
const COS: f64 = 0.819_152;

/// Directions of the rays of a point whose unit normal this is.
pub fn cone(normal: DVec3) -> impl Iterator<Item = DVec3> {
    let inward = -normal;
    let (side, up) = inward.any_orthonormal_pair();
    let around = (0..AROUND).map(move |i| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / f64::from(AROUND)).sin_cos();
        inward * COS + (side * cos + up * sin) * SIN
    });
    std::iter::once(inward).chain(around)
}

/// Median of the lengths of the rays that met the other side, 0 where none did.
pub fn diameter(mut lengths: Vec<f64>) -> f64 {
    if lengths.is_empty() {
        return 0.0;
    }
    let middle = lengths.len() / 2;
    *lengths.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// The diameter at each point, world units; 0 where no ray met anything. `faces` are those on which
/// the points lie.
pub fn thickness(surface: &Surface, rays: &Rays, points: &[DVec3], faces: &[u32]) -> Vec<f32> {
    let reach = surface.diagonal;
    let at = |(&point, &face): (&DVec3, &u32)| {
        let normal = surface.normals[face as usize];
        let origin = point - normal * (1e-5 * surface.diagonal);
        // What faces the ray is no other side but the front of another component.
        let length = |d: DVec3| {
            let hit = rays.closest_hit(origin, d, reach, face)?;
            (surface.normals[hit.face as usize].dot(d) > 0.0).then_some(hit.distance)
        };
        diameter(cone(normal).filter_map(length).collect()) as f32
    };
    tasks::even("thickness", points.len(), || points.par_iter().zip(faces).map(at).collect())
}
