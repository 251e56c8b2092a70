//! Where the picture is taken from: in front, a little to the right and above (glTF: +y up, +z
//! towards the viewer), far enough for mild perspective, framed so that the object fills the view.

use glam::{DMat3, DVec3, Vec2};

/// Turn about the vertical axis and elevation, radians.
const YAW: f64 = 0.62;
const PITCH: f64 = 0.42;
/// Distance of the eye, in radii of the object.
const DISTANCE: f64 = 4.5;
/// Share of the view that is left free on each side.
const MARGIN: f64 = 0.06;

/// A view of an object.
#[derive(Debug, Clone, Copy)]
pub(super) struct Camera {
    center: DVec3,
    /// World → camera: x right, y up, z towards the eye.
    turn: DMat3,
    distance: f64,
    /// Pixels a unit of (x/depth).
    zoom: f64,
    /// Its inverse.
    unit: f64,
    /// Pixel of the optical axis.
    middle: (f64, f64),
}

/// A point as the camera sees it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Seen {
    /// Pixels, y down.
    pub at: Vec2,
    /// 1/depth: larger is nearer, and linear over a triangle on the screen.
    pub nearness: f32,
}

impl Camera {
    /// A camera that shows all `points` in a square view of `size` pixels. `None` without points.
    pub(super) fn framing(
        points: impl Iterator<Item = DVec3> + Clone,
        size: usize,
    ) -> Option<Self> {
        let low = points.clone().reduce(DVec3::min)?;
        let high = points.clone().reduce(DVec3::max)?;
        let center = 0.5 * (low + high);
        let radius = (0.5 * low.distance(high)).max(f64::MIN_POSITIVE);
        let turn = DMat3::from_rotation_x(PITCH) * DMat3::from_rotation_y(-YAW);
        let distance = DISTANCE * radius;
        let mut camera = Self { center, turn, distance, zoom: 1.0, unit: 1.0, middle: (0.0, 0.0) };
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        let (mut bottom, mut top) = (f64::INFINITY, f64::NEG_INFINITY);
        for p in points {
            let q = camera.place(p);
            let (x, y) = (q.x / -q.z, q.y / -q.z);
            (left, right) = (left.min(x), right.max(x));
            (bottom, top) = (bottom.min(y), top.max(y));
        }
        let extent = (right - left).max(top - bottom).max(1e-9);
        let half = 0.5 * size as f64;
        camera.zoom = size as f64 * (1.0 - 2.0 * MARGIN) / extent;
        camera.unit = 1.0 / camera.zoom;
        camera.middle =
            (half - camera.zoom * 0.5 * (left + right), half + camera.zoom * 0.5 * (bottom + top));
        Some(camera)
    }

    /// A point in camera space: the eye at the origin, looking along −z.
    pub(super) fn place(&self, p: DVec3) -> DVec3 {
        self.turn * (p - self.center) - DVec3::Z * self.distance
    }

    /// A direction in camera space.
    pub(super) fn turned(&self, v: DVec3) -> DVec3 {
        self.turn * v
    }

    /// A point on the screen.
    pub(super) fn see(&self, p: DVec3) -> Seen {
        let q = self.place(p);
        let nearness = 1.0 / -q.z;
        let x = self.middle.0 + self.zoom * q.x * nearness;
        let y = self.middle.1 - self.zoom * q.y * nearness;
        Seen { at: Vec2::new(x as f32, y as f32), nearness: nearness as f32 }
    }

    /// The point in camera space that is seen at a pixel.
    pub(super) fn unsee(&self, at: Vec2, nearness: f32) -> glam::Vec3 {
        let depth = 1.0 / f64::from(nearness);
        let scale = depth * self.unit;
        let x = (f64::from(at.x) - self.middle.0) * scale;
        let y = (self.middle.1 - f64::from(at.y)) * scale;
        DVec3::new(x, y, -depth).as_vec3()
    }

    /// Pixels a world unit at a depth.
    pub(super) fn pixels(&self, nearness: f32) -> f32 {
        self.zoom as f32 * nearness
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_object_fills_the_view_and_no_more() {
        let points = [DVec3::ZERO, DVec3::new(3.0, 1.0, 0.0), DVec3::new(0.0, 0.5, 8.0)];
        let camera = Camera::framing(points.into_iter(), 100).unwrap();
        let seen = points.map(|p| camera.see(p));
        let (low, high) = seen
            .iter()
            .fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(l, h), s| (l.min(s.at), h.max(s.at)));
        assert!(low.min_element() >= 5.9 && high.max_element() <= 94.1, "{low} {high}");
        assert!(((high - low).max_element() - 88.0).abs() < 0.1);
        for (p, s) in points.iter().zip(seen) {
            let back = camera.unsee(s.at, s.nearness);
            assert!(back.distance(camera.place(*p).as_vec3()) < 1e-3);
        }
    }

    #[test]
    fn up_is_up_and_the_near_side_is_near() {
        let points = [DVec3::NEG_ONE, DVec3::ONE];
        let camera = Camera::framing(points.into_iter(), 100).unwrap();
        assert!(camera.see(DVec3::Y).at.y < camera.see(-DVec3::Y).at.y);
        assert!(camera.see(DVec3::X).at.x > camera.see(-DVec3::X).at.x);
        assert!(camera.see(DVec3::Z).nearness > camera.see(-DVec3::Z).nearness);
        assert!(Camera::framing(std::iter::empty(), 100).is_none());
    }
}
