//! Error quadrics: the weighted sum of squared distances to planes, as one quadratic function of a point
//! (Garland & Heckbert 1997, doi:10.1145/258734.258849).

use glam::{DMat3, DVec3};

/// Share of the quadric's trace that holds a vertex near its edge's middle where planes leave it free.
const HOLD: f64 = 1e-3;

/// x ↦ xᵀA x + 2 bᵀx + c, A symmetric.
#[derive(Debug, Clone, Copy, Default)]
pub struct Quadric {
    diagonal: DVec3,
    /// A's entries yz, xz, xy.
    mixed: DVec3,
    b: DVec3,
    c: f64,
}

impl Quadric {
    /// `weight` times the squared distance to the plane through `point` across the unit `normal`.
    pub fn plane(normal: DVec3, point: DVec3, weight: f64) -> Self {
        let offset = -normal.dot(point);
        Self {
            diagonal: weight * normal * normal,
            mixed: weight
                * DVec3::new(normal.y * normal.z, normal.x * normal.z, normal.x * normal.y),
            b: weight * offset * normal,
            c: weight * offset * offset,
        }
    }

    /// The sum of both.
    pub fn plus(self, other: &Self) -> Self {
        Self {
            diagonal: self.diagonal + other.diagonal,
            mixed: self.mixed + other.mixed,
            b: self.b + other.b,
            c: self.c + other.c,
        }
    }

    /// A x.
    fn times(&self, x: DVec3) -> DVec3 {
        let (d, m) = (self.diagonal, self.mixed);
        DVec3::new(
            d.x * x.x + m.z * x.y + m.y * x.z,
            m.z * x.x + d.y * x.y + m.x * x.z,
            m.y * x.x + m.x * x.y + d.z * x.z,
        )
    }

    /// The value at a point, never below 0.
    pub fn at(&self, x: DVec3) -> f64 {
        (x.dot(self.times(x)) + 2.0 * self.b.dot(x) + self.c).max(0.0)
    }

    /// The point of least value, held near `near` in the directions that no plane decides.
    pub fn least(&self, near: DVec3) -> DVec3 {
        let (d, m) = (self.diagonal, self.mixed);
        let hold = HOLD * d.element_sum();
        let matrix = DMat3::from_cols(
            DVec3::new(d.x + hold, m.z, m.y),
            DVec3::new(m.z, d.y + hold, m.x),
            DVec3::new(m.y, m.x, d.z + hold),
        );
        let step = matrix.inverse() * (self.times(near) + self.b);
        if step.is_finite() { near - step } else { near }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_planes_meet_in_their_corner() {
        let corner = DVec3::new(0.3, -0.7, 0.2);
        let planes = [DVec3::X, DVec3::Y, DVec3::new(0.6, 0.0, 0.8)];
        let sum = planes.iter().fold(Quadric::default(), |sum, &normal| {
            sum.plus(&Quadric::plane(normal, corner, 2.0))
        });
        assert!(sum.least(corner + 0.01).distance(corner) < 1e-3);
        assert!(sum.at(corner) < 1e-12);
        assert!((sum.at(corner + 0.1 * DVec3::Y) - 0.02).abs() < 1e-12);
        // One plane leaves a point where it is along it.
        let one = Quadric::plane(DVec3::X, DVec3::ZERO, 1.0);
        assert!(one.least(DVec3::new(1.0, 2.0, 3.0)).distance(DVec3::new(0.0, 2.0, 3.0)) < 2e-3);
    }
}
