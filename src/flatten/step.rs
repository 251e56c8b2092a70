//! The longest step before a triangle loses its area (Smith & Schaefer, "Bijective Parameterization
//! with Free Boundaries", 2015, section 5): the area along a straight motion is a quadratic in the
//! step, and its least positive root is where the triangle collapses.

use std::ops::Range;

use glam::DVec2;

use super::Disk;
use crate::tasks;

/// The longest step t for which every triangle keeps its orientation on all of [0, t), when the
/// vertices move from `uv` along `direction`; infinite when none ever collapses.
pub(super) fn longest_step(disk: &Disk, uv: &[DVec2], direction: &[DVec2]) -> f64 {
    let of = |f: usize| {
        let [a, b, c] = disk.triangles[f].map(|v| v as usize);
        let (e, g) = (uv[b] - uv[a], uv[c] - uv[a]);
        let (de, dg) = (direction[b] - direction[a], direction[c] - direction[a]);
        let linear = de.perp_dot(g) + e.perp_dot(dg);
        first_root(de.perp_dot(dg), linear, e.perp_dot(g))
    };
    let longest = |faces: Range<usize>| {
        faces.filter(|&f| disk.areas[f] > 0.0).map(of).fold(f64::INFINITY, f64::min)
    };
    let blocks = tasks::blocks("longest step", disk.triangles.len(), longest);
    blocks.into_iter().fold(f64::INFINITY, f64::min)
}

/// Least positive root of a t² + b t + c with c > 0; infinite where there is none.
fn first_root(a: f64, b: f64, c: f64) -> f64 {
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return f64::INFINITY;
    }
    // The stable form: no difference of like numbers. For b < 0 both roots have the sign of a's
    // like term and 2c/(…) is the lesser; for b ≥ 0 only a < 0 leaves a positive root.
    let root = discriminant.sqrt();
    if b < 0.0 {
        2.0 * c / (root - b)
    } else if a < 0.0 {
        (b + root) / (-2.0 * a)
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::samples;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_root_is_a_root_and_the_first(a in -3.0..3.0f64, b in -3.0..3.0f64, c in 0.01..3.0f64) {
            let value = |t: f64| (a * t + b) * t + c;
            let t = first_root(a, b, c);
            prop_assert!(t > 0.0);
            if t < 1e3 {
                prop_assert!(value(t).abs() < 1e-7 * (1.0 + t * t));
            }
            let end = t.min(100.0);
            prop_assert!((0..100).all(|k| value(end * f64::from(k) / 100.0) > 0.0));
        }
    }

    #[test]
    fn a_vertex_that_crosses_an_edge_is_stopped_at_it() {
        let (disk, uv) = samples::plane(1, 1, 1.0, 1.0);
        let mut direction = vec![DVec2::ZERO; 4];
        // Vertex 1 = (1, 0) towards the diagonal 0–3 … 2: it collapses at (½, ½).
        direction[1] = DVec2::new(-1.0, 1.0);
        assert!((longest_step(&disk, &uv, &direction) - 0.5).abs() < 1e-12);
        direction[1] = DVec2::new(1.0, -1.0);
        assert_eq!(longest_step(&disk, &uv, &direction), f64::INFINITY);
    }
}
