//! A triangle against a ray and against a point.
//!
//! Ray: Möller and Trumbore, "Fast, minimum storage ray/triangle intersection", 1997,
//! doi:10.1080/10867651.1997.10487468. Closest point: Ericson, "Real-Time Collision Detection", 2005,
//! section 5.1.5.

use glam::DVec3;

/// Slack of the barycentric test, so that no ray slips through between two faces.
const SLACK: f64 = 1e-9;

/// Distance along a ray to a triangle, from either side (Möller and Trumbore 1997).
pub(super) fn crossing(origin: DVec3, direction: DVec3, [a, b, c]: [DVec3; 3]) -> Option<f64> {
    let (e, g) = (b - a, c - a);
    let p = direction.cross(g);
    let determinant = e.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let inverse = 1.0 / determinant;
    let s = origin - a;
    let u = s.dot(p) * inverse;
    if !(-SLACK..=1.0 + SLACK).contains(&u) {
        return None;
    }
    let q = s.cross(e);
    let v = direction.dot(q) * inverse;
    if v < -SLACK || u + v > 1.0 + SLACK {
        return None;
    }
    let t = g.dot(q) * inverse;
    (t > 0.0 && t.is_finite()).then_some(t)
}

/// The point of a triangle that is nearest to `p` (Ericson 2005).
pub fn nearest_on_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let (d3, d4) = (ab.dot(p - b), ac.dot(p - b));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let (d5, d6) = (ab.dot(p - c), ac.dot(p - c));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    a + (ab * vb + ac * vc) / (va + vb + vc)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-1.0f64..1.0).prop_map(DVec3::from_array)
    }

    proptest! {
        #[test]
        fn nearest_point_is_no_farther_than_any_other(
            t in prop::array::uniform3(point()),
            p in point(),
        ) {
            let best = nearest_on_triangle(p, t).distance(p);
            for a in 0..=20 {
                for b in 0..=20 - a {
                    let (u, v) = (f64::from(a) / 20.0, f64::from(b) / 20.0);
                    let q = t[0] * (1.0 - u - v) + t[1] * u + t[2] * v;
                    prop_assert!(best <= q.distance(p) + 1e-12);
                }
            }
        }

        #[test]
        fn a_ray_at_an_inner_point_meets_it(
            t in prop::array::uniform3(point()),
            origin in point(),
            u in 0.1f64..0.4,
            v in 0.1f64..0.4,
        ) {
            let q = t[0] * (1.0 - u - v) + t[1] * u + t[2] * v;
            let normal = (t[1] - t[0]).cross(t[2] - t[0]);
            prop_assume!(normal.length() > 1e-2 && (q - origin).dot(normal).abs() > 1e-2);
            let distance = crossing(origin, q - origin, t);
            prop_assert!(distance.is_some_and(|d| (d - 1.0).abs() < 1e-9));
            prop_assert!(crossing(origin, origin - q, t).is_none());
        }
    }
}
