//! How well two labellings agree, by weight of their elements (faces by area, points by 1): instance
//! best-match mIoU, and the Rand index (Rand 1971, doi:10.1080/01621459.1971.10482356; Chen, Golovinskiy
//! and Funkhouser 2009, doi:10.1145/1531326.1531379, Sec. 4.3) over pairs weighted alike.

use std::collections::BTreeMap;

/// Agreement of a labelling with the truth.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Agreement {
    /// Mean over the true parts of the best intersection over union that any found part has with it.
    pub miou: f64,
    /// Share of pairs of elements on which both agree whether they are of one part.
    pub rand: f64,
    /// The same less what chance would give, over the most that could be had: 1 for the same parts, 0 for
    /// unrelated ones (Hubert and Arabie 1985, doi:10.1007/BF01908075).
    pub adjusted_rand: f64,
}

/// Weight that each pair of true and found part has in common. Elements of unknown truth (negative)
/// do not count; elements that no part has (`found` negative) are one part.
pub fn agreement(truth: &[i32], found: &[i32], weight: &[f64]) -> Agreement {
    let mut both: BTreeMap<(i32, i32), f64> = BTreeMap::new();
    let (mut rows, mut columns) = (BTreeMap::<i32, f64>::new(), BTreeMap::<i32, f64>::new());
    for ((&t, &f), &w) in
        truth.iter().zip(found).zip(weight).filter(|((t, _), w)| **t >= 0 && **w > 0.0)
    {
        let f = f.max(-1);
        *both.entry((t, f)).or_default() += w;
        *rows.entry(t).or_default() += w;
        *columns.entry(f).or_default() += w;
    }
    if rows.is_empty() {
        return Agreement::default();
    }
    let mut best: BTreeMap<i32, f64> = BTreeMap::new();
    for (&(t, f), &w) in &both {
        let union = rows[&t] + columns[&f] - w;
        let best = best.entry(t).or_default();
        *best = best.max(w / union);
    }
    let total: f64 = rows.values().sum();
    let squares = |weights: &mut dyn Iterator<Item = &f64>| -> f64 {
        weights.map(|w| (w / total).powi(2)).sum()
    };
    let (a, b) = (squares(&mut rows.values()), squares(&mut columns.values()));
    let miou = best.values().sum::<f64>() / best.len() as f64;
    let both = squares(&mut both.values());
    let (chance, most) = (a * b, 0.5 * (a + b));
    let adjusted_rand = if most > chance { (both - chance) / (most - chance) } else { 1.0 };
    Agreement { miou, rand: 1.0 - a - b + 2.0 * both, adjusted_rand }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn known_cases() {
        let weight = [1.0; 4];
        let same = agreement(&[0, 0, 1, 1], &[7, 7, 3, 3], &weight);
        assert!((same.miou - 1.0).abs() < 1e-12 && (same.rand - 1.0).abs() < 1e-12);
        let one = agreement(&[0, 0, 1, 1], &[0, 0, 0, 0], &weight);
        assert!((one.miou - 0.5).abs() < 1e-12 && (one.rand - 0.5).abs() < 1e-12);
        let weighted = agreement(&[0, 1], &[0, 0], &[3.0, 1.0]);
        assert!((weighted.miou - 0.5).abs() < 1e-12 && (weighted.rand - 0.625).abs() < 1e-12);
        assert_eq!(agreement(&[-1], &[0], &[1.0]), Agreement::default());
    }

    proptest! {
        #[test]
        fn names_do_not_matter_and_figures_are_shares(
            labels in prop::collection::vec((0..4i32, 0..4i32, 0.1..2.0f64), 1..60),
        ) {
            let truth: Vec<i32> = labels.iter().map(|l| l.0).collect();
            let found: Vec<i32> = labels.iter().map(|l| l.1).collect();
            let weight: Vec<f64> = labels.iter().map(|l| l.2).collect();
            let a = agreement(&truth, &found, &weight);
            prop_assert!((0.0..=1.0 + 1e-9).contains(&a.miou) && (-1e-9..=1.0 + 1e-9).contains(&a.rand));
            let renamed: Vec<i32> = found.iter().map(|l| 9 - l).collect();
            let b = agreement(&truth, &renamed, &weight);
            prop_assert!((a.miou - b.miou).abs() < 1e-9 && (a.rand - b.rand).abs() < 1e-9);
        }
    }
}
