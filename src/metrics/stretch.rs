//! The map of one face, tangent plane → UV: its singular values, areas and the angle between its
//! axes. Everything that is measured about distortion starts here.

use glam::{DVec2, DVec3};

/// A UV triangle whose height is below this has no area: one unit in the last place at 1.
const FLAT_UV: f64 = 1.2e-7;
/// Below this determinant of the UV edges PartUV takes no tangents.
const NO_TANGENT: f64 = 1e-12;

/// The map of one face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaceMap {
    /// 3D area, world units squared; above 0.
    pub area: f64,
    /// Signed UV area, v up; page = 1.
    pub uv_area: f64,
    /// Larger singular value of the Jacobian, page lengths a world unit.
    pub sigma1: f64,
    /// Smaller singular value.
    pub sigma2: f64,
    /// Whether the face keeps its orientation and has area in UV: what inverse powers may see.
    pub sound: bool,
    /// |cos(∂p/∂u, ∂p/∂v)|; `None` where the UV triangle is too small to say.
    pub axis_cosine: Option<f64>,
}

impl FaceMap {
    /// The map that takes the corners of a face to `uv`. `None` for a face without area, or where
    /// `uv` is not finite.
    pub fn new([a, b, c]: [DVec3; 3], uv: [[f32; 2]; 3]) -> Option<Self> {
        // The face laid in its plane: a at the origin, b at (base, 0), c at (foot, height).
        let (along, across) = (b - a, c - a);
        let base = along.length();
        let area = 0.5 * along.cross(across).length();
        let t = uv.map(|w| DVec2::new(f64::from(w[0]), f64::from(w[1])));
        if !(area > 0.0 && t.iter().all(|w| w.is_finite())) {
            return None;
        }
        let (e, g) = (t[1] - t[0], t[2] - t[0]);
        let uv_area = 0.5 * e.perp_dot(g);
        // Columns of the Jacobian: images of the two unit axes of the face's plane.
        let (foot, height) = (along.dot(across) / base, 2.0 * area / base);
        let x = e / base;
        let y = (g - x * foot) / height;
        let sum = x.length_squared() + y.length_squared();
        let difference = (x.length_squared() - y.length_squared()).hypot(2.0 * x.dot(y));
        let sigma1 = (0.5 * (sum + difference)).max(0.0).sqrt();
        let sigma2 = if sigma1 > 0.0 { x.perp_dot(y).abs() / sigma1 } else { 0.0 };
        let longest = e.length().max(g.length()).max(e.distance(g));
        let flat = 2.0 * uv_area.abs() <= FLAT_UV * longest;
        let sound = uv_area > 0.0 && sigma2 > 0.0 && !flat;
        let axis_cosine = (2.0 * uv_area.abs() > NO_TANGENT).then(|| {
            // ∂p/∂u and ∂p/∂v, up to a common factor.
            let (u, v) = (along * g.y - across * e.y, across * e.x - along * g.x);
            (u.dot(v) / (u.length() * v.length())).abs()
        });
        let axis_cosine = axis_cosine.filter(|c| c.is_finite());
        Some(Self { area, uv_area, sigma1, sigma2, sound, axis_cosine })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_stretch_is_seen_whatever_the_face_s_place() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|p| p * 3.0 + DVec3::Z);
        let map = FaceMap::new(corners, [[0.0, 0.0], [0.5, 0.0], [0.0, 0.25]]).unwrap();
        assert!((map.sigma1 - 0.5 / 3.0).abs() < 1e-12);
        assert!((map.sigma2 - 0.25 / 3.0).abs() < 1e-12);
        assert!(map.sound && map.axis_cosine == Some(0.0));
    }

    #[test]
    fn flips_collapses_and_missing_coordinates_are_told_apart() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let flip = FaceMap::new(corners, [[0.0, 0.0], [0.0, 0.5], [0.5, 0.0]]).unwrap();
        assert!(!flip.sound && flip.uv_area < 0.0 && flip.sigma2 > 0.0);
        let collapsed = FaceMap::new(corners, [[0.1, 0.1]; 3]).unwrap();
        assert!(!collapsed.sound && collapsed.axis_cosine.is_none());
        assert!(FaceMap::new(corners, [[f32::NAN; 2]; 3]).is_none());
        assert!(FaceMap::new([DVec3::ZERO, DVec3::X, DVec3::X * 2.0], [[0.0; 2]; 3]).is_none());
    }

    proptest! {
        #[test]
        fn product_and_sum_of_squares_are_those_of_the_jacobian(
            p in prop::array::uniform3(prop::array::uniform3(-1.0f64..1.0)),
            w in prop::array::uniform3(prop::array::uniform2(0.0f32..1.0)),
        ) {
            let corners = p.map(DVec3::from_array);
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            prop_assume!(normal.length() > 1e-2);
            let map = FaceMap::new(corners, w).unwrap();
            prop_assert!(map.sigma1 >= map.sigma2);
            let ratio = map.uv_area.abs() / map.area;
            prop_assert!((map.sigma1 * map.sigma2 - ratio).abs() <= 1e-9 * (1.0 + ratio));
        }
    }
}
