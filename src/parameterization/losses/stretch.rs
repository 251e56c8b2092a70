//! Stretch loss (paper 2.3.4). Sound form: Σ A [½ (σ̃1² + σ̃2²) − σ̃1 σ̃2 + ½ log² max(det J̃, ε)] / ΣA, 0
//! exactly at isometries; σ̃1 σ̃2 is the signed det J̃, so a flipped triangle is pushed back. Paper's form:
//! the mean of (‖Δu‖ / ℓ − 1)² over edges.

use glam::DVec2;

use super::edges::Edge;
use super::triangles::{Energy, Invariants};
use super::{Loss, Map};

/// The sound form on one triangle.
#[inline]
pub(super) fn energy(Invariants { norm, det, epsilon }: Invariants) -> Energy {
    let log = det.max(epsilon).ln();
    let by_log = if det > epsilon { log / det } else { 0.0 };
    Energy { value: 0.5 * norm - det + 0.5 * log * log, by_norm: 0.5, by_det: by_log - 1.0 }
}

/// The paper's form.
#[derive(Debug)]
pub(super) struct EdgeRatios {
    edges: Vec<Edge>,
}

impl EdgeRatios {
    pub fn prepare(edges: Vec<Edge>) -> Option<Box<dyn Loss>> {
        (!edges.is_empty()).then(|| Box::new(Self { edges }) as Box<dyn Loss>)
    }
}

impl Loss for EdgeRatios {
    fn evaluate(&self, map: Map, weight: f64, gradient: &mut [DVec2]) -> f64 {
        let per_edge = 1.0 / self.edges.len() as f64;
        let mut sum = 0.0;
        for Edge { ends, length } in &self.edges {
            let [i, j] = ends.map(|v| v as usize);
            let delta = map.uv[i] - map.uv[j];
            let long = delta.length();
            let excess = long / length - 1.0;
            sum += excess * excess;
            if long > 0.0 {
                let force = delta * (2.0 * weight * per_edge * excess / (length * long));
                gradient[i] += force;
                gradient[j] -= force;
            }
        }
        sum * per_edge
    }
}

#[cfg(test)]
mod tests {
    use super::super::scenes::plane;
    use super::super::{Annealing, Term};
    use super::*;
    use crate::contract::LossForm;

    #[test]
    fn a_stretched_plane_has_the_value_of_its_singular_values() {
        let scene = plane();
        let uv: Vec<DVec2> = scene.uv.iter().map(|p| *p * DVec2::new(2.0, 1.0)).collect();
        let mut gradient = uv.clone();
        let at = Annealing::at(0.0);
        let value =
            scene.terms(LossForm::Sound, None).evaluate(Term::Stretch, &uv, 1.0, at, &mut gradient);
        assert!((value - (0.5 + 0.5 * 2.0_f64.ln().powi(2))).abs() < 1e-12);
    }

    /// The paper's form knows no scale: a map twice as large has every ratio 2.
    #[test]
    fn the_papers_form_is_zero_at_isometries_and_counts_scale() {
        let scene = plane();
        let terms = scene.terms(LossForm::Paper, None);
        let value = |size: f64| {
            let uv: Vec<DVec2> = scene.uv.iter().map(|p| *p * size).collect();
            let mut gradient = uv.clone();
            terms.evaluate(Term::Stretch, &uv, size, Annealing::at(0.0), &mut gradient)
        };
        assert!(value(1.0) < 1e-20 && (value(2.0) - 1.0).abs() < 1e-12);
    }
}
