//! Barrier: Σ A (σ̃1² + σ̃2² + σ̃1⁻² + σ̃2⁻² − 4) / 4 / ΣA, the symmetric Dirichlet energy (Smith & Schaefer
//! 2015, doi:10.1145/2766947), 0 at isometries. Written as
//! ¼ [(‖J̃‖² − 2 det J̃)(1 + 1/det²) + 2 (det + 1/det − 2)], whose two parts are both ≥ 0, also with the
//! inverse powers continued below ε: neither a collapse nor a flip can score below an isometry.

use super::continuation::{inverse, inverse_square};
use super::triangles::{Energy, Invariants};

/// The barrier on one triangle.
#[inline]
pub(super) fn energy(Invariants { norm, det, epsilon }: Invariants) -> Energy {
    let (inverse, square) = (inverse(det, epsilon), inverse_square(det, epsilon));
    let (excess, factor) = (norm - 2.0 * det, 1.0 + square.value);
    Energy {
        value: 0.25 * (excess * factor + 2.0 * (det + inverse.value - 2.0)),
        by_norm: 0.25 * factor,
        by_det: 0.25
            * (excess * square.derivative - 2.0 * factor + 2.0 * (1.0 + inverse.derivative)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_the_symmetric_dirichlet_energy_above_epsilon() {
        for (s1, s2) in [(1.0, 1.0), (2.0, 0.5), (3.0, 2.0), (0.5, 0.4)] {
            let at = Invariants { norm: s1 * s1 + s2 * s2, det: s1 * s2, epsilon: 0.1 };
            let dirichlet = |s: f64| s * s + 1.0 / (s * s) - 2.0;
            let expected = (dirichlet(s1) + dirichlet(s2)) / 4.0;
            assert!((energy(at).value - expected).abs() < 1e-12);
        }
    }
}
