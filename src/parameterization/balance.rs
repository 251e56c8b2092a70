//! Gradient balancing (paper 2.2.1 names it and gives no formula). Every 25 steps, for each chart by
//! itself, w_i = λ_i · clamp(|g_ref| / (EMA |g_i| + 10⁻³ |g_ref at the start|), 0.1, 1), g_i the
//! gradient of term i with respect to the UVs and g_ref that of stretch + conformal. It only damps a
//! term that dominates: with an upper clamp above 1 it would amplify satisfied losses for ever. The
//! reference itself and the barrier keep their λ.

use glam::DVec2;

use super::losses::{Annealing, ChartTerms, Term, TermValues};

/// Steps between two looks at the gradients.
pub const INTERVAL: usize = 25;

/// Share of the past in the running mean of a norm. A training looks 8 times, so it is short.
const MEMORY: f64 = 0.5;

/// The least that a weight is damped to.
const LEAST: f64 = 0.1;

/// The weights of one chart's terms while it trains.
#[derive(Debug, Clone, PartialEq)]
pub struct Balance {
    weights: TermValues,
    means: Option<TermValues>,
    /// Norm of the reference gradient at the first look.
    start: f64,
}

impl Default for Balance {
    fn default() -> Self {
        Self { weights: Term::ALL.map(Term::lambda), means: None, start: 0.0 }
    }
}

impl Balance {
    /// Weights to use: the paper's λ until the first look.
    pub fn weights(&self) -> &TermValues {
        &self.weights
    }

    /// Set the weights anew at step `step` of the chart if that is a multiple of [`INTERVAL`].
    /// `scratch` is overwritten: one entry a vertex of the disk.
    pub fn refresh(
        &mut self,
        step: usize,
        terms: &ChartTerms,
        uv: &[DVec2],
        scale: f64,
        at: Annealing,
        scratch: &mut [DVec2],
    ) {
        if !step.is_multiple_of(INTERVAL) {
            return;
        }
        let mut norm = |weights: &TermValues| {
            scratch.fill(DVec2::ZERO);
            terms.evaluate_sum(weights, uv, scale, at, scratch);
            norm(scratch)
        };
        let mut norms = TermValues::default();
        for term in Term::ALL.into_iter().filter(|t| is_balanced(*t) && terms.has(*t)) {
            let mut alone = TermValues::default();
            alone[term as usize] = 1.0;
            norms[term as usize] = norm(&alone);
        }
        let mut both = TermValues::default();
        both[Term::Stretch as usize] = 1.0;
        both[Term::Conformal as usize] = 1.0;
        let reference = norm(&both);
        self.observe(reference, &norms);
    }

    /// Set the weights from the norm of the reference gradient and those of the terms' gradients.
    pub fn observe(&mut self, reference: f64, norms: &TermValues) {
        let means = match self.means {
            None => {
                self.start = reference;
                *norms
            }
            Some(means) => std::array::from_fn(|i| MEMORY * means[i] + (1.0 - MEMORY) * norms[i]),
        };
        for term in Term::ALL.into_iter().filter(|t| is_balanced(*t)) {
            let against = means[term as usize] + 1e-3 * self.start;
            let ratio = if against > 0.0 { reference / against } else { 1.0 };
            self.weights[term as usize] = term.lambda() * ratio.clamp(LEAST, 1.0);
        }
        self.means = Some(means);
    }
}

/// Whether a term may be damped.
fn is_balanced(term: Term) -> bool {
    !matches!(term, Term::Conformal | Term::Stretch | Term::Barrier)
}

/// Euclidean norm of a gradient.
pub fn norm(gradient: &[DVec2]) -> f64 {
    gradient.iter().map(|g| g.length_squared()).sum::<f64>().sqrt()
}

/// What the gradient of the inverse mapper is to be multiplied by, so that it does not outweigh the
/// forward losses: min(1, |g_uv| / |g_inv|) (paper 2.2.2, gradient clipping).
pub fn clip(forward: f64, inverse: f64) -> f64 {
    if inverse > forward { forward / inverse } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::contract::LossForm;
    use crate::parameterization::losses::LossContext;

    fn norms(value: f64) -> TermValues {
        [value; Term::ALL.len()]
    }

    #[test]
    fn a_dominating_term_is_damped_and_a_quiet_one_left_alone() {
        let mut balance = Balance::default();
        let mut seen = norms(0.01);
        seen[Term::Cluster as usize] = 4.0;
        seen[Term::Smooth as usize] = 1e6;
        balance.observe(1.0, &seen);
        let weight = |term: Term| balance.weights()[term as usize];
        assert!((weight(Term::Cluster) - 0.8 / 4.001).abs() < 1e-12);
        assert!((weight(Term::Smooth) - 0.05).abs() < 1e-12);
        assert_eq!(weight(Term::Connectivity), Term::Connectivity.lambda());
    }

    /// A loss that is satisfied while the reference is still large keeps its λ, for ever.
    #[test]
    fn a_term_that_calms_down_gets_its_weight_back_and_no_more() {
        let mut balance = Balance::default();
        balance.observe(1.0, &norms(50.0));
        assert!((balance.weights()[Term::Cluster as usize] - 0.08).abs() < 1e-12);
        for _ in 0..20 {
            balance.observe(1.0, &norms(1e-9));
        }
        assert_eq!(balance.weights(), &Term::ALL.map(Term::lambda));
    }

    proptest! {
        #[test]
        fn nothing_is_amplified_and_reference_and_barrier_are_not_balanced(
            looks in prop::collection::vec((0.0..1e3f64, prop::array::uniform8(0.0..1e6f64)), 1..6),
        ) {
            let mut balance = Balance::default();
            for (reference, seen) in looks {
                balance.observe(reference, &seen);
                for term in Term::ALL {
                    let ratio = balance.weights()[term as usize] / term.lambda();
                    prop_assert!((0.0999..=1.0).contains(&ratio));
                    prop_assert!(is_balanced(term) || ratio == 1.0);
                }
            }
        }
    }

    #[test]
    fn gradients_are_looked_at_every_25_steps() {
        // A plane, squeezed: the paper's sum over neighbours outweighs everything.
        let scene = crate::parameterization::losses::plane();
        let context = LossContext { form: LossForm::Paper, ..Default::default() };
        let terms = ChartTerms::new(&scene.disk, context);
        let uv: Vec<DVec2> = scene.uv.iter().map(|p| *p * DVec2::new(1.2, 0.9)).collect();
        let mut balance = Balance::default();
        let mut scratch = vec![DVec2::ZERO; uv.len()];
        let mut refresh = |step| {
            balance.refresh(step, &terms, &uv, 1.0, Annealing::at(0.0), &mut scratch);
            balance.weights()[Term::Connectivity as usize]
        };
        assert_eq!(refresh(24), 1.0);
        assert!((refresh(25) - 0.1).abs() < 1e-12);
    }

    #[test]
    fn the_inverse_branch_is_clipped_to_the_forward_one() {
        assert_eq!(
            (clip(1.0, 4.0), clip(4.0, 1.0), clip(0.0, 0.0), clip(0.0, 2.0)),
            (0.25, 1.0, 1.0, 0.0)
        );
    }
}
