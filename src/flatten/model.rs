//! Quadratic models of the symmetric Dirichlet energy of one triangle, about a Jacobian
//! J = U Σ Vᵀ: what a descent step minimises over all triangles at once. Both are positive
//! semidefinite and have the energy's own gradient.

use glam::{DMat2, DVec2};

use super::jacobian::singular_values;

/// Stiffnesses are kept below this, so that a triangle near collapse does not overflow.
const LARGEST: f64 = 1e24;

/// The direction at half the angle of a unit vector.
fn half(u: DVec2) -> DVec2 {
    // Each half plane by the root that loses no digits.
    let long = (0.5 * (1.0 + u.x.abs())).sqrt();
    let short = 0.5 * u.y / long;
    if u.x >= 0.0 { DVec2::new(long, short) } else { DVec2::new(short.abs(), long.copysign(u.y)) }
}

/// Second derivative of a model by the Jacobian.
pub(super) struct Model {
    /// First left and right singular vectors.
    left: DVec2,
    right: DVec2,
    /// With p, q the parts of the direction across the right singular vectors: stiffness of the
    /// first left direction along p and q, of the second along p and q, and between them.
    first: [f64; 2],
    second: [f64; 2],
    between: f64,
}

impl Model {
    /// The reweighted proxy of SLIM (Rabinovich et al. 2017, section 4): ‖W(J − UVᵀ)‖² with
    /// W² = U diag(w(σ)) Uᵀ, w(σ) = f′(σ)/(σ − 1) = (1 + σ)(1 + σ²)/(2σ³). Takes large steps from
    /// afar, and slow ones near the optimum.
    pub fn reweighted(j: DMat2) -> Self {
        let (s1, s2) = singular_values(j);
        let weight = |s: f64| bounded(0.5 * (1.0 + s) * (1.0 + s * s) / (s * s * s));
        let (w1, w2) = (weight(s1), weight(s2));
        Self::new(j, [w1; 2], [w2; 2], 0.0)
    }

    /// The energy's Hessian without its negative part, by the closed-form eigensystem of isotropic
    /// energies (Smith, de Goes, Kim, "Analytic Eigensystems for Isotropic Distortion Energies",
    /// 2019, section 5): stretch along each singular direction, shear (flip) and rotation (twist),
    /// of which only the last can be negative. Converges quadratically near the optimum.
    pub fn newton(j: DMat2) -> Self {
        let (s1, s2) = singular_values(j);
        let cube = |s: f64| 1.0 / (s * s * s);
        let stretch = |s: f64| bounded(0.5 * (1.0 + 3.0 * cube(s) / s));
        let shear = 0.5 * (1.0 + (s1 * s1 + s1 * s2 + s2 * s2) * cube(s1) * cube(s2));
        let twist = 0.5 * (1.0 - (cube(s1) + cube(s2)) / (s1 + s2));
        let (shear, twist) = (bounded(shear), twist.max(0.0));
        let (sum, difference) = (0.5 * (shear + twist), 0.5 * (shear - twist));
        Self::new(j, [stretch(s1), sum], [sum, stretch(s2)], difference)
    }

    fn new(j: DMat2, first: [f64; 2], second: [f64; 2], between: f64) -> Self {
        let (a, b, c, d) = (j.x_axis.x, j.y_axis.x, j.x_axis.y, j.y_axis.y);
        // The conformal part turns by the difference of U's and V's angles, the anticonformal part
        // by their sum: U's direction is half of both.
        let difference = DVec2::new(a + d, c - b).normalize_or(DVec2::X);
        let sum = DVec2::new(a - d, c + b).normalize_or(DVec2::X);
        let left = half(sum.rotate(difference));
        let right = left.rotate(DVec2::new(difference.x, -difference.y));
        Self { left, right, first, second, between }
    }

    /// The 2×2 block that joins two corners with hat gradients `g` (row) and `h` (column).
    pub fn block(&self, g: DVec2, h: DVec2) -> DMat2 {
        let across = |g: DVec2| DVec2::new(self.right.dot(g), self.right.perp_dot(g));
        let (g, h) = (across(g), across(h));
        let inner = DMat2::from_cols(
            DVec2::new(
                self.first[0] * g.x * h.x + self.first[1] * g.y * h.y,
                self.between * g.x * h.y,
            ),
            DVec2::new(
                self.between * g.y * h.x,
                self.second[0] * g.x * h.x + self.second[1] * g.y * h.y,
            ),
        );
        let frame = DMat2::from_cols(self.left, self.left.perp());
        frame * inner * frame.transpose()
    }
}

/// A triangle so thin that a stiffness overflows gets the largest.
fn bounded(stiffness: f64) -> f64 {
    if stiffness.is_nan() { LARGEST } else { stiffness.min(LARGEST) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::symmetric_dirichlet_gradient;
    use proptest::prelude::*;

    /// Change of the gradient along the direction u gᵀ, seen through h: what `block` predicts.
    fn difference(j: DMat2, g: DVec2, h: DVec2, u: DVec2) -> DVec2 {
        let moved = |t: f64| j + DMat2::from_cols(u * g.x, u * g.y) * t;
        let force = |t: f64| symmetric_dirichlet_gradient(moved(t)) * h;
        (force(1e-6) - force(-1e-6)) / 2e-6
    }

    proptest! {
        #[test]
        fn newton_is_the_hessian_where_that_is_positive(
            stretch in prop::array::uniform2(1.05..3.0f64), turn in prop::array::uniform2(0.0..6.3f64),
            a in 0.0..6.3f64, b in 0.0..6.3f64, c in 0.0..6.3f64,
        ) {
            let [left, right] = turn.map(DMat2::from_angle);
            let j = left * DMat2::from_diagonal(DVec2::from(stretch)) * right;
            let [g, h, u] = [a, b, c].map(DVec2::from_angle);
            let want = difference(j, g, h, u);
            prop_assert!((Model::newton(j).block(h, g) * u - want).length() < 1e-5);
        }

        #[test]
        fn both_models_are_positive(e in prop::array::uniform4(-2.0..2.0f64), a in 0.0..6.3f64) {
            let j = DMat2::from_cols(DVec2::new(e[0], e[1]), DVec2::new(e[2], e[3]));
            prop_assume!(j.determinant() > 1e-3);
            let g = DVec2::from_angle(a);
            for model in [Model::newton(j), Model::reweighted(j)] {
                let block = model.block(g, g);
                let scale = block.x_axis.x + block.y_axis.y;
                prop_assert!((block.x_axis.y - block.y_axis.x).abs() <= 1e-9 * scale);
                prop_assert!(scale > 0.0 && block.determinant() >= -1e-9 * scale * scale);
            }
        }
    }

    #[test]
    fn at_an_isometry_all_but_rotation_is_stiff() {
        let block = Model::newton(DMat2::IDENTITY).block(DVec2::X, DVec2::X);
        // u_x is stretch (stiffness 2); v_x is half shear (2), half rotation (0).
        assert!(
            (block - DMat2::from_diagonal(DVec2::new(2.0, 1.0)))
                .abs()
                .to_cols_array()
                .iter()
                .all(|x| *x < 1e-12)
        );
    }
}
