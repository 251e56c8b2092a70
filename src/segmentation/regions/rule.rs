//! How likely a part ends between two regions, told without a network: nine numbers weighed by rounded
//! constants (logistic regression on the pairs of procedural and IKEA objects on which the boundary
//! classifier is trained; the constant is 1.05 higher than fitted, so that the rule, which hears less, joins
//! less at the same cut).

use super::boundary_classifier::{Heard, Opinion};
use super::features::{FEATURES, at};

/// The rule.
pub struct Rule;

/// What is added if nothing speaks.
const BASE: f64 = 1.95;

/// A number of the pair, and how much it speaks for a boundary.
const WEIGHTS: [(usize, f64); 9] = [
    // Welded components that only touch.
    (at::CONTACT, 3.2),
    // The minima rule: parts end in valleys, of edges and of initial regions; a ridge is the edge of one part.
    (at::VALLEY, 1.7),
    (at::BAY, 1.1),
    (at::RIDGE, -1.0),
    // Shape diameters differ.
    (at::THICK, 0.7),
    // No plane, cylinder or cone fits both together.
    (at::MISFIT_BOTH, 0.7),
    // The boxes about both are in each other's way: two regions of one thing.
    (at::BOXES, -2.7),
    // What is small is joined first.
    (at::SMALL, 0.8),
    (at::LARGE, 2.3),
];

impl Opinion for Rule {
    fn boundary(&self, features: &[f32; FEATURES], heard: Heard) -> f64 {
        let mut x = *features;
        heard.mask(&mut x);
        let logit = BASE + WEIGHTS.iter().map(|&(i, w)| w * f64::from(x[i])).sum::<f64>();
        1.0 / (1.0 + (-logit).exp())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_of_evidence_moves_it_the_way_it_should() {
        let of = |i: usize, x: f32| {
            let mut features = [0.0; FEATURES];
            features[at::SMALL] = -0.8;
            features[at::LARGE] = -0.3;
            features[i] = x;
            Rule.boundary(&features, Heard::SHAPE)
        };
        let plain = of(at::SMALL, -0.8);
        for i in [at::CONTACT, at::VALLEY, at::BAY, at::THICK, at::MISFIT_BOTH] {
            assert!(of(i, 0.5) > plain, "{i}");
        }
        assert!(of(at::RIDGE, 0.5) < plain && of(at::BOXES, 0.5) < plain);
        assert_eq!(of(at::APART, 1.0), plain, "the network is not heard");
    }
}
