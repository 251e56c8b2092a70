//! Points on the union of overlapping solids without making its mesh: what lies inside another solid
//! is left out, and a ray through the body passes the walls between solids.

use glam::DVec3;
use rayon::prelude::*;

use crate::mesh::Surface;
use crate::mesh::rays::Rays;
use crate::sampling::PointCloud;
use crate::segmentation::thickness::{cone, diameter};

/// Where a ray that starts inside, with `depth` solids about it, leaves the last of them.
fn exit(surface: &Surface, rays: &Rays, origin: DVec3, direction: DVec3, face: u32) -> Option<f64> {
    let mut walls: Vec<(f64, i32)> = Vec::new();
    rays.hits(origin, direction, f64::INFINITY, face, |hit| {
        let leaves = surface.normals[hit.face as usize].dot(direction) > 0.0;
        walls.push((hit.distance, if leaves { -1 } else { 1 }));
    });
    walls.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut depth = 1;
    walls.iter().find_map(|&(distance, change)| {
        depth += change;
        (depth <= 0).then_some(distance)
    })
}

/// The points of a cloud that no solid covers.
pub fn outside(surface: &Surface, rays: &Rays, cloud: &PointCloud) -> PointCloud {
    let is_outside = |i: &u32| {
        let (point, face) = (cloud.positions[*i as usize], cloud.faces[*i as usize]);
        let normal = surface.normals[face as usize];
        let mut depth = 0;
        rays.hits(point + normal * (1e-5 * surface.diagonal), normal, f64::INFINITY, face, |hit| {
            depth += if surface.normals[hit.face as usize].dot(normal) > 0.0 { 1 } else { -1 };
        });
        // More walls left than entered: the point is inside something.
        depth <= 0
    };
    let kept: Vec<u32> = (0..cloud.len() as u32).into_par_iter().filter(is_outside).collect();
    cloud.subset(&kept)
}

/// The shape diameter of the union at each point.
pub fn thickness(surface: &Surface, rays: &Rays, cloud: &PointCloud) -> Vec<f32> {
    let at = |(&point, &face): (&DVec3, &u32)| {
        let normal = surface.normals[face as usize];
        let origin = point - normal * (1e-5 * surface.diagonal);
        let lengths = cone(normal).filter_map(|d| exit(surface, rays, origin, d, face));
        diameter(lengths.collect()) as f32
    };
    cloud.positions.par_iter().zip(&cloud.faces).map(at).collect()
}
