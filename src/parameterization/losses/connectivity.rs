//! Connectivity loss (paper 2.3.7). Sound form: the mean of max(0, ‖Δu‖ / (s ℓ) − (1 + δ_c))² over mesh
//! edges: neighbours stay neighbours, and an edge may stretch by δ_c before it counts. Paper's form:
//! the *sum* of ‖u_i − u_j‖ over nearest neighbours, whose optimum is a point.

use glam::DVec2;

use super::edges::Edge;
use super::{Loss, Map};

/// Stretch that an edge is granted.
const DELTA: f64 = 0.05;

/// The sound form.
#[derive(Debug)]
pub(super) struct Tearing {
    edges: Vec<Edge>,
}

impl Tearing {
    pub fn prepare(edges: Vec<Edge>) -> Option<Box<dyn Loss>> {
        (!edges.is_empty()).then(|| Box::new(Self { edges }) as Box<dyn Loss>)
    }
}

impl Loss for Tearing {
    fn evaluate(&self, map: Map, weight: f64, gradient: &mut [DVec2]) -> f64 {
        let per_edge = 1.0 / self.edges.len() as f64;
        let mut sum = 0.0;
        for Edge { ends, length } in &self.edges {
            let [i, j] = ends.map(|v| v as usize);
            let delta = map.uv[i] - map.uv[j];
            let (square, unit) = (delta.length_squared(), map.scale * length);
            let granted = (1.0 + DELTA) * unit;
            if square > granted * granted {
                let long = square.sqrt();
                let excess = (long - granted) / unit;
                sum += excess * excess;
                let force = delta * (2.0 * weight * per_edge * excess / (unit * long));
                gradient[i] += force;
                gradient[j] -= force;
            }
        }
        sum * per_edge
    }
}

/// The paper's form.
#[derive(Debug)]
pub(super) struct Distances {
    pairs: Vec<[u32; 2]>,
}

impl Distances {
    pub fn prepare(pairs: Vec<[u32; 2]>) -> Option<Box<dyn Loss>> {
        (!pairs.is_empty()).then(|| Box::new(Self { pairs }) as Box<dyn Loss>)
    }
}

impl Loss for Distances {
    fn evaluate(&self, map: Map, weight: f64, gradient: &mut [DVec2]) -> f64 {
        let mut sum = 0.0;
        for [i, j] in self.pairs.iter().map(|pair| pair.map(|v| v as usize)) {
            let delta = map.uv[i] - map.uv[j];
            sum += delta.length();
            let force = delta.normalize_or_zero() * weight;
            gradient[i] += force;
            gradient[j] -= force;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::super::scenes::plane;
    use super::super::{Annealing, Term};
    use super::*;
    use crate::contract::LossForm;

    #[test]
    fn an_edge_may_stretch_by_the_grant_and_no_more() {
        let scene = plane();
        let terms = scene.terms(LossForm::Sound, None);
        let value = |size: f64| {
            let uv: Vec<DVec2> = scene.uv.iter().map(|p| *p * size).collect();
            let mut gradient = vec![DVec2::ZERO; uv.len()];
            terms.evaluate(Term::Connectivity, &uv, 1.0, Annealing::at(0.0), &mut gradient)
        };
        assert_eq!((value(0.5), value(1.0), value(1.049)), (0.0, 0.0, 0.0));
        assert!((value(1.25) - 0.04).abs() < 1e-12);
    }

    #[test]
    fn the_papers_form_is_a_sum_whose_optimum_is_a_point() {
        let scene = plane();
        let terms = scene.terms(LossForm::Paper, None);
        let value = |size: f64| {
            let uv: Vec<DVec2> = scene.uv.iter().map(|p| *p * size).collect();
            let mut gradient = vec![DVec2::ZERO; uv.len()];
            terms.evaluate(Term::Connectivity, &uv, 1.0, Annealing::at(0.0), &mut gradient)
        };
        assert!(value(0.0) == 0.0 && (value(2.0) / value(1.0) - 2.0).abs() < 1e-12);
    }
}
