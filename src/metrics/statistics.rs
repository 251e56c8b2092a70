//! Weighted means and quantiles. Sums run in the order of the faces, whatever the thread count.

use crate::contract::FaceStats;

/// Ratios are capped at this, as PartUV caps its own: one collapsed face must not hide
/// what the others do, and infinity cannot be written in JSON. 100 reads "100 or worse".
pub(super) const CAP: f64 = 100.0;

/// Weighted mean, 95th percentile and largest of `(value, weight)` pairs; `None` without weight.
pub(super) fn face_stats(pairs: impl Iterator<Item = (f64, f64)>) -> Option<FaceStats> {
    let mut pairs: Vec<(f64, f64)> = pairs.collect();
    let weight: f64 = pairs.iter().map(|p| p.1).sum();
    if weight.is_nan() || weight <= 0.0 {
        return None;
    }
    let mean = pairs.iter().map(|(x, w)| x * w).sum::<f64>() / weight;
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let max = pairs.last().map_or(mean, |p| p.0);
    Some(FaceStats { mean, p95: quantile(&pairs, 0.95), max })
}

/// The least value at which the running weight of sorted `(value, weight)` pairs reaches the share
/// `q` of the whole.
fn quantile(sorted: &[(f64, f64)], q: f64) -> f64 {
    let total = sorted.iter().fold(0.0, |sum, p| sum + p.1);
    let mut running = 0.0;
    for &(x, w) in sorted {
        running += w;
        if running >= q * total {
            return x;
        }
    }
    sorted.last().map_or(0.0, |p| p.0)
}

/// Weighted mean of `(value, weight)` pairs; `None` without weight.
pub(super) fn weighted_mean(pairs: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let (sum, weight) = pairs.fold((0.0, 0.0), |(s, t), (x, w)| (s + x * w, t + w));
    (weight > 0.0).then(|| sum / weight)
}

/// `max(r, 1/r)`, capped.
pub(super) fn either_way(r: f64) -> f64 {
    if r > 0.0 { r.max(1.0 / r).min(CAP) } else { CAP }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weight_counts_not_number() {
        let s = face_stats([(1.0, 96.0), (5.0, 3.0), (9.0, 1.0)].into_iter()).unwrap();
        assert_eq!((s.p95, s.max), (1.0, 9.0));
        assert!((s.mean - 1.2).abs() < 1e-12);
        let s = face_stats([(9.0, 6.0), (1.0, 94.0)].into_iter()).unwrap();
        assert_eq!(s.p95, 9.0);
    }

    #[test]
    fn nothing_has_no_figures() {
        assert_eq!(face_stats(std::iter::empty()), None);
        assert_eq!(weighted_mean([(3.0, 0.0)].into_iter()), None);
    }

    #[test]
    fn ratios_are_symmetric_and_capped() {
        assert_eq!((either_way(4.0), either_way(0.25), either_way(0.0)), (4.0, 4.0, CAP));
    }
}
