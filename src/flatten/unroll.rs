//! The side of a cylinder or cone unrolled in closed form: a cylinder to the rectangle (rθ, z), a
//! cone to its developed sector (do Carmo, "Differential Geometry of Curves and Surfaces", 4-2,
//! example 2).

use std::collections::VecDeque;
use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::{Disk, UvMap};

/// Above this change of radius along the axis a tube is developed as a cone.
const CONE: f64 = 0.01;

/// Unroll a disk from the axis through `origin` along the unit vector `axis`, with `radius` at the
/// origin and `taper` its change along the axis. The angle is unwrapped by walking over the mesh,
/// so the two sides of a cut get different values; the map is turned so that the disk is not
/// mirrored.
pub fn unroll(disk: &Disk, origin: DVec3, axis: DVec3, radius: f64, taper: f64) -> UvMap {
    let (across, along) = axis.any_orthonormal_pair();
    let polar = |p: DVec3| {
        let q = p - origin;
        let radial = DVec2::new(q.dot(across), q.dot(along));
        (radial, q.dot(axis))
    };
    let (radial, heights): (Vec<DVec2>, Vec<f64>) =
        disk.positions.iter().map(|&p| polar(p)).unzip();
    let angles = unwrapped_angles(disk, &radial, 1e-9 * radius.abs());
    let (low, high) = angles.iter().fold((f64::MAX, f64::MIN), |(l, h), &a| (l.min(a), h.max(a)));
    let middle = 0.5 * (low + high);

    let mut uv: UvMap = if taper.abs() > CONE {
        // A turn of the tube is a turn by sin(half the opening angle) of the sector.
        let slant = (1.0 + taper * taper).sqrt();
        let place = |(&angle, &z): (&f64, &f64)| {
            let distance = (radius + taper * z) * slant / taper.abs();
            let turned = (angle - middle) * taper.abs() / slant;
            DVec2::from_angle(turned) * distance
        };
        angles.iter().zip(&heights).map(place).collect()
    } else {
        let place = |(&angle, &z): (&f64, &f64)| DVec2::new((angle - middle) * radius, z);
        angles.iter().zip(&heights).map(place).collect()
    };
    if (0..disk.triangles.len()).map(|f| disk.uv_area(f, &uv)).sum::<f64>() < 0.0 {
        uv.iter_mut().for_each(|p| p.y = -p.y);
    }
    uv
}

/// Angle of each vertex about the axis, continuous over the mesh: along an edge it changes by at
/// most half a turn. A vertex on the axis (closer than `on_axis`) has the angle from which it was
/// reached, and the walk does not go on from there.
fn unwrapped_angles(disk: &Disk, radial: &[DVec2], on_axis: f64) -> Vec<f64> {
    let neighbours = neighbours(disk);
    let mut angles = vec![f64::NAN; radial.len()];
    let mut queue = VecDeque::new();
    // Start off the axis where there is such a vertex.
    let mut seeds: Vec<usize> = (0..radial.len()).collect();
    seeds.sort_by_key(|&v| radial[v].length() <= on_axis);
    for seed in seeds {
        if !angles[seed].is_nan() {
            continue;
        }
        angles[seed] = radial[seed].to_angle();
        queue.push_back(seed);
        while let Some(v) = queue.pop_front() {
            for &w in &neighbours[v] {
                let w = w as usize;
                if !angles[w].is_nan() {
                    continue;
                }
                angles[w] = angles[v];
                if radial[w].length() > on_axis {
                    let turn = radial[w].to_angle() - angles[v];
                    angles[w] += turn - TAU * ((turn + PI) / TAU).floor();
                    queue.push_back(w);
                }
            }
        }
    }
    angles
}

/// Vertices joined to each vertex by an edge, in ascending order.
fn neighbours(disk: &Disk) -> Vec<Vec<u32>> {
    let mut neighbours = vec![Vec::new(); disk.positions.len()];
    for t in &disk.triangles {
        for k in 0..3 {
            neighbours[t[k] as usize].extend([t[(k + 1) % 3], t[(k + 2) % 3]]);
        }
    }
    for list in &mut neighbours {
        list.sort_unstable();
        list.dedup();
    }
    neighbours
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::{certify, quality, samples};

    #[test]
    fn a_cylinder_unrolls_to_its_rectangle() {
        let disk = samples::tube(96, 4, TAU, 0.5, 0.5, 2.0);
        let uv = unroll(&disk, DVec3::ZERO, DVec3::Z, 0.5, 0.0);
        assert!(certify(&disk, &uv).is_injective());
        let width = uv.iter().map(|p| p.x).fold(f64::MIN, f64::max)
            - uv.iter().map(|p| p.x).fold(f64::MAX, f64::min);
        assert!((width - PI).abs() < 1e-12, "the whole turn, r θ");
        // Chords are shorter than arcs by θ²/24 only.
        assert!(quality(&disk, &uv).is_isometric());
        let shifted = unroll(&disk, DVec3::new(0.0, 0.0, 7.0), -DVec3::Z, 0.5, 0.0);
        assert!(certify(&disk, &shifted).is_injective());
    }

    #[test]
    fn a_cone_unrolls_to_its_sector() {
        let disk = samples::tube(96, 6, TAU, 1.0, 0.4, 1.5);
        let uv = unroll(&disk, DVec3::ZERO, DVec3::Z, 1.0, -0.4);
        assert!(certify(&disk, &uv).is_injective());
        assert!(quality(&disk, &uv).is_isometric(), "{:?}", quality(&disk, &uv));
        // A cone that opens upwards, down to its apex.
        let disk = samples::tube(96, 6, TAU, 0.0, 1.0, 2.0);
        let uv = unroll(&disk, DVec3::new(0.0, 0.0, 1.0), DVec3::Z, 0.5, 0.5);
        let q = quality(&disk, &uv);
        assert!(q.flips == 0 && q.mean - 1.0 < 1e-3, "{q:?}");
    }

    #[test]
    fn more_than_one_turn_keeps_turning() {
        let disk = samples::bent(80, 2, |x, y| {
            (DVec2::from_angle(2.5 * TAU * x) * (1.0 + 1e-3 * x)).extend(y)
        });
        let uv = unroll(&disk, DVec3::ZERO, DVec3::Z, 1.0, 0.0);
        assert!(certify(&disk, &uv).is_injective());
        assert!(quality(&disk, &uv).mean < 1.001);
    }
}
