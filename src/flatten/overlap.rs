//! How many pairs of triangles overlap: the reported figure behind the certificate's yes or no.
//! Two triangles overlap when no direction separates them by more than a tolerance (separating axis
//! theorem; in the plane the edge normals are all the directions there are to try).

use glam::DVec2;

use super::sweep::Sweep;

/// Pairs of triangles whose interiors overlap by more than `tolerance` (a length, in the units of
/// the triangles). Triangles that share an edge or a vertex do not overlap by that. Triangles with
/// a coordinate that is not finite, and those without area, overlap nothing.
pub fn overlapping_pairs(triangles: &[[DVec2; 3]], tolerance: f64) -> u64 {
    sweep(triangles, tolerance)
        .count(|i, j| overlap_depth(&triangles[i as usize], &triangles[j as usize]) > tolerance)
}

/// Which pairs, in ascending order.
pub fn list_overlapping_pairs(triangles: &[[DVec2; 3]], tolerance: f64) -> Vec<(u32, u32)> {
    sweep(triangles, tolerance)
        .pairs(|i, j| overlap_depth(&triangles[i as usize], &triangles[j as usize]) > tolerance)
}

fn sweep(triangles: &[[DVec2; 3]], tolerance: f64) -> Sweep {
    // Boxes that meet by less than the tolerance cannot hold triangles that overlap by more.
    let margin = DVec2::splat(0.5 * tolerance);
    let bounds = |t: &[DVec2; 3]| {
        if (t[1] - t[0]).perp_dot(t[2] - t[0]) == 0.0 {
            return [DVec2::NAN; 2];
        }
        let [a, b, c] = *t;
        let (lower, upper) = (a.min(b).min(c) + margin, a.max(b).max(c) - margin);
        // A triangle thinner than the tolerance meets nothing.
        if lower.cmple(upper).all() { [lower, upper] } else { [DVec2::NAN; 2] }
    };
    Sweep::new(triangles.iter().map(bounds).collect())
}

/// Least distance by which one triangle must be moved along one of the six edge normals to leave
/// the other; negative or zero when they are apart or touch.
pub fn overlap_depth(a: &[DVec2; 3], b: &[DVec2; 3]) -> f64 {
    let mut depth = f64::INFINITY;
    for t in [a, b] {
        for k in 0..3 {
            let Some(normal) = (t[(k + 1) % 3] - t[k]).perp().try_normalize() else { continue };
            let span = |t: &[DVec2; 3]| {
                let [x, y, z] = t.map(|p| p.dot(normal));
                (x.min(y).min(z), x.max(y).max(z))
            };
            let ((low_a, high_a), (low_b, high_b)) = (span(a), span(b));
            depth = depth.min((high_a - low_b).min(high_b - low_a));
            if depth <= 0.0 {
                return depth;
            }
        }
    }
    depth
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::samples;

    fn corners(offset: DVec2) -> Vec<[DVec2; 3]> {
        let (disk, uv) = samples::plane(8, 8, 1.0, 1.0);
        disk.triangles.iter().map(|t| t.map(|v| uv[v as usize] + offset)).collect()
    }

    #[test]
    fn a_triangulation_does_not_overlap_itself() {
        assert_eq!(overlapping_pairs(&corners(DVec2::ZERO), 1e-6), 0);
    }

    #[test]
    fn two_sheets_overlap_as_brute_force_says() {
        let mut all = corners(DVec2::ZERO);
        all.extend(corners(DVec2::new(0.51, 0.33)));
        let mut want = 0;
        for i in 0..all.len() {
            for j in 0..i {
                want += u64::from(overlap_depth(&all[i], &all[j]) > 1e-6);
            }
        }
        assert!(want > 50);
        assert_eq!(overlapping_pairs(&all, 1e-6), want);
        assert_eq!(list_overlapping_pairs(&all, 1e-6).len() as u64, want);
    }

    #[test]
    fn depth_is_measured_and_containment_counts() {
        let big = [DVec2::ZERO, DVec2::X, DVec2::Y];
        let beside = big.map(|p| p + DVec2::new(1.0, 0.0));
        assert!(overlap_depth(&big, &beside) <= 1e-15);
        let inside = big.map(|p| p * 0.1 + DVec2::splat(0.2));
        assert!(overlap_depth(&big, &inside) > 0.1);
        let nan = [DVec2::NAN; 3];
        assert_eq!(overlapping_pairs(&[big, inside, nan, [DVec2::ZERO; 3]], 1e-6), 1);
    }
}
