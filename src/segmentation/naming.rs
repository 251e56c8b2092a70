//! What the network calls a part, and how sure that is: the mean over the part's area of the probability that
//! it gives each name, calibrated on labelled objects (`uvsegnet bench names`; docs/results.md).

use super::point_mae::NAMES;

/// A part is named from this confidence on; below it is "part".
const NAMED: f64 = 0.5;

/// Newton steps of a fit.
const STEPS: usize = 50;

/// Calibration of probabilities: log-odds of being right = slope · log-odds as given + offset (Platt 1999).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Platt {
    /// The slope.
    pub slope: f64,
    /// The offset.
    pub offset: f64,
}

impl Platt {
    /// The one that ships, fitted on 2,897 parts of 168 families.
    pub const SHIPS: Self = Self { slope: 1.27, offset: -0.16 };

    /// How likely it is right, 0 to 1, where `share` is the probability as given.
    pub fn confidence(self, share: f64) -> f64 {
        1.0 / (1.0 + (-self.slope * log_odds(share) - self.offset).exp())
    }

    /// The likeliest calibration for pairs of a probability as given and whether it was right. A weak pull
    /// towards none keeps it finite.
    pub fn fit(pairs: &[(f64, bool)]) -> Self {
        let mut fit = Self { slope: 1.0, offset: 0.0 };
        for _ in 0..STEPS {
            // Gradient and Hessian of −Σ log likelihood + ½((slope − 1)² + offset²).
            let (mut g, mut h) = ([fit.slope - 1.0, fit.offset], [1.0, 0.0, 1.0]);
            for &(share, right) in pairs {
                let (x, p) = (log_odds(share), fit.confidence(share));
                let (miss, w) = (p - f64::from(u8::from(right)), p * (1.0 - p));
                g[0] += miss * x;
                g[1] += miss;
                h[0] += w * x * x;
                h[1] += w * x;
                h[2] += w;
            }
            let determinant = h[0] * h[2] - h[1] * h[1];
            fit.slope -= (h[2] * g[0] - h[1] * g[1]) / determinant;
            fit.offset -= (h[0] * g[1] - h[1] * g[0]) / determinant;
        }
        fit
    }
}

fn log_odds(share: f64) -> f64 {
    let share = share.clamp(1e-6, 1.0 - 1e-6);
    (share / (1.0 - share)).ln()
}

/// A name and how sure the network is of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Naming {
    /// Index into [`NAMES`].
    pub name: usize,
    /// Its mean probability over the part, 0 to 1, as the network gives it.
    pub share: f64,
}

impl Naming {
    /// The likeliest name for a part, from the sums of each name's probability over its area. `None` where the
    /// network was not asked.
    pub fn of(sums: &[f64]) -> Option<Self> {
        let total: f64 = sums.iter().sum();
        let name = (0..sums.len()).max_by(|&a, &b| sums[a].total_cmp(&sums[b]))?;
        (total > 0.0).then(|| Self { name, share: sums[name] / total })
    }

    /// How likely the name is right, 0 to 1.
    pub fn confidence(self) -> f64 {
        Platt::SHIPS.confidence(self.share)
    }

    /// The word, where it is more likely right than not.
    pub fn word(self) -> Option<&'static str> {
        (self.confidence() >= NAMED).then(|| NAMES[self.name])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fit_finds_how_odds_were_bent() {
        // Right as often as 1/(1 + exp(-(0.7 x - 0.4))) says, each share 1,000 times.
        let want = Platt { slope: 0.7, offset: -0.4 };
        let pairs = (1..20).map(|k| f64::from(k) / 20.0).flat_map(|share| {
            let right = (1000.0 * want.confidence(share)).round() as usize;
            (0..1000).map(move |i| (share, i < right))
        });
        let fit = Platt::fit(&pairs.collect::<Vec<_>>());
        assert!((fit.slope - want.slope).abs() < 0.01, "{fit:?}");
        assert!((fit.offset - want.offset).abs() < 0.01, "{fit:?}");
        assert_eq!(Platt::fit(&[]), Platt { slope: 1.0, offset: 0.0 });
    }

    #[test]
    fn the_likeliest_name_is_given_where_it_is_likely_right() {
        let mut sums = vec![0.0; NAMES.len()];
        assert_eq!(Naming::of(&sums), None);
        assert_eq!(Naming::of(&[]), None);
        (sums[3], sums[5]) = (1.98, 0.02);
        let sure = Naming::of(&sums).unwrap();
        assert_eq!((sure.name, sure.share, sure.word()), (3, 0.99, Some(NAMES[3])));
        assert!(sure.confidence() > 0.5);
        let uncertain = Naming { share: 0.1, ..sure };
        assert!(uncertain.confidence() < 0.5 && uncertain.word().is_none());
        // The more of the part agrees, the surer.
        let rising = |w: &[f64]| w[0] < w[1];
        let confidences =
            [0.0, 0.3, 0.6, 0.9, 1.0].map(|share| Naming { share, ..sure }.confidence());
        assert!(confidences.windows(2).all(rising), "{confidences:?}");
    }
}
