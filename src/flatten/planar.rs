//! Projection onto the best plane: exact on flat charts, injective on gentle height fields.

use glam::{DVec2, DVec3};

use super::{Disk, UvMap};

/// The disk seen along its mean normal (area-weighted), right-handed: front faces keep their
/// winding.
pub fn planar(disk: &Disk) -> UvMap {
    let sum: DVec3 = disk.triangles.iter().map(|t| double_area_normal(disk, t)).sum();
    let normal = sum.try_normalize().unwrap_or(DVec3::Z);
    let (u, v) = normal.any_orthonormal_pair();
    let origin = disk.positions.first().copied().unwrap_or_default();
    let project = |&p: &DVec3| DVec2::new((p - origin).dot(u), (p - origin).dot(v));
    disk.positions.iter().map(project).collect()
}

fn double_area_normal(disk: &Disk, t: &[u32; 3]) -> DVec3 {
    let [a, b, c] = t.map(|v| disk.positions[v as usize]);
    (b - a).cross(c - a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::{quality, samples};
    use glam::DQuat;

    #[test]
    fn a_tilted_plane_is_mapped_without_distortion() {
        let (flat, _) = samples::plane(5, 4, 3.0, 1.0);
        let tilt = DQuat::from_euler(glam::EulerRot::XYZ, 0.7, -2.1, 0.3);
        let tilted = flat.positions.iter().map(|&p| tilt * p + DVec3::splat(10.0));
        let disk = Disk::new(tilted.collect(), flat.triangles.clone());
        let q = quality(&disk, &planar(&disk));
        assert!(q.flips == 0 && q.max - 1.0 < 1e-12);
    }
}
