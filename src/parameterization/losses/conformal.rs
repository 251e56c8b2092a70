//! Conformal loss (paper 2.3.3). Sound form: Σ A (‖J̃‖² / (2 det J̃) − 1) / ΣA, that is
//! ½ (σ1/σ2 + σ2/σ1) − 1, 0 where angles are kept. Written as ½ (‖J̃‖² − 2 det J̃) / det J̃, so that the
//! continuation below ε cannot fall under 0. Paper's form: (1/|F|) Σ (θ_3D − θ_UV)² over corners; it
//! does not see flips.

use glam::{DVec2, DVec3};

use super::continuation::inverse;
use super::triangles::{Energy, Invariants};
use super::{Loss, Map};
use crate::flatten::Disk;

/// The sound form on one triangle.
#[inline]
pub(super) fn energy(Invariants { norm, det, epsilon }: Invariants) -> Energy {
    let inverse = inverse(det, epsilon);
    let excess = 0.5 * (norm - 2.0 * det);
    Energy {
        value: excess * inverse.value,
        by_norm: 0.5 * inverse.value,
        by_det: excess * inverse.derivative - inverse.value,
    }
}

/// The paper's form.
#[derive(Debug)]
pub(super) struct Angles {
    /// Corners of each triangle and its angles there in 3D.
    triangles: Vec<([u32; 3], [f64; 3])>,
}

impl Angles {
    pub fn prepare(disk: &Disk, selected: &[u32]) -> Option<Box<dyn Loss>> {
        let angles = |f: &u32| {
            let corners = disk.triangles[*f as usize];
            let p = corners.map(|v| disk.positions[v as usize]);
            let angle =
                |k: usize| DVec3::angle_between(p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
            (corners, [0, 1, 2].map(angle))
        };
        let triangles: Vec<_> = selected.iter().map(angles).collect();
        (!triangles.is_empty()).then(|| Box::new(Self { triangles }) as Box<dyn Loss>)
    }
}

impl Loss for Angles {
    fn evaluate(&self, map: Map, weight: f64, gradient: &mut [DVec2]) -> f64 {
        let per_face = 1.0 / self.triangles.len() as f64;
        let mut sum = 0.0;
        for (corners, angles) in &self.triangles {
            for (k, angle) in angles.iter().enumerate() {
                let [at, b, c] = [0, 1, 2].map(|i| corners[(k + i) % 3] as usize);
                let (e, g) = (map.uv[b] - map.uv[at], map.uv[c] - map.uv[at]);
                let (cross, squares) = (e.perp_dot(g), [e.length_squared(), g.length_squared()]);
                if squares[0] == 0.0 || squares[1] == 0.0 {
                    continue; // no angle there
                }
                let difference = cross.abs().atan2(e.dot(g)) - angle;
                sum += difference * difference;
                let slope = 2.0 * weight * per_face * difference * cross.signum();
                let (by_e, by_g) = (-e.perp() / squares[0], g.perp() / squares[1]);
                gradient[b] += slope * by_e;
                gradient[c] += slope * by_g;
                gradient[at] -= slope * (by_e + by_g);
            }
        }
        sum * per_face
    }
}

#[cfg(test)]
mod tests {
    use super::super::scenes::plane;
    use super::super::{Annealing, Term};
    use super::*;
    use crate::contract::LossForm;

    /// ½ (σ1/σ2 + σ2/σ1) − 1 for a map with the singular values 2 and 1, at any scale.
    #[test]
    fn a_stretched_plane_has_the_value_of_its_singular_values() {
        let scene = plane();
        let uv: Vec<DVec2> = scene.uv.iter().map(|p| *p * DVec2::new(6.0, 3.0)).collect();
        let terms = scene.terms(LossForm::Sound, None);
        let mut gradient = uv.clone();
        let scale = terms.scale(&uv);
        let value = terms.evaluate(Term::Conformal, &uv, scale, Annealing::at(0.0), &mut gradient);
        assert!((value - 0.25).abs() < 1e-12);
    }

    #[test]
    fn the_papers_form_is_zero_at_similarities_and_blind_to_mirrors() {
        let scene = plane();
        let terms = scene.terms(LossForm::Paper, None);
        let value = |factor: DVec2| {
            let uv: Vec<DVec2> = scene.uv.iter().map(|p| *p * factor).collect();
            let mut gradient = uv.clone();
            terms.evaluate(Term::Conformal, &uv, 1.0, Annealing::at(0.0), &mut gradient)
        };
        assert!(value(DVec2::new(3.0, 3.0)) < 1e-20);
        assert!(value(DVec2::new(-3.0, 3.0)) < 1e-20);
        assert!(value(DVec2::new(2.0, 1.0)) > 0.01);
    }
}
