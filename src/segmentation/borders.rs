//! How well the borders of two labellings lie on each other: shares of their length within a distance.

use glam::DVec3;
use kiddo::{ImmutableKdTree, SquaredEuclidean};

use crate::mesh::{NONE, Surface};

/// Length of found borders near true ones, of true near found ones, and their harmonic mean.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BorderAgreement {
    /// Of the found borders.
    pub precision: f64,
    /// Of the true borders.
    pub recall: f64,
    /// Harmonic mean; 1 where neither has a border, 0 where one has none.
    pub f1: f64,
}

/// Agreement of borders within `reach` (world units). A border is a mesh edge between two labels; faces of
/// unknown truth have none.
pub fn border_agreement(
    surface: &Surface,
    truth: &[i32],
    found: &[i32],
    reach: f64,
) -> BorderAgreement {
    let step = 0.5 * reach;
    let known = |h: u32| truth[h as usize / 3] >= 0;
    let (real, seen) = (places(surface, truth, step, known), places(surface, found, step, known));
    if real.is_empty() || seen.is_empty() {
        let f1 = if real.is_empty() && seen.is_empty() { 1.0 } else { 0.0 };
        return BorderAgreement { precision: f1, recall: f1, f1 };
    }
    let (precision, recall) = (near(&seen, &real, reach), near(&real, &seen, reach));
    let sum = precision + recall;
    let f1 = if sum > 0.0 { 2.0 * precision * recall / sum } else { 0.0 };
    BorderAgreement { precision, recall, f1 }
}

/// Points along the borders, each with the length that it stands for.
fn places(
    surface: &Surface,
    label: &[i32],
    step: f64,
    known: impl Fn(u32) -> bool,
) -> Vec<(DVec3, f64)> {
    let mut places = Vec::new();
    for (h, &t) in (0u32..).zip(&surface.twin).filter(|(h, t)| **t != NONE && h < *t) {
        if label[h as usize / 3] == label[t as usize / 3] || !known(h) || !known(t) {
            continue;
        }
        let from = surface.positions[surface.from(h) as usize];
        let to = surface.positions[surface.to(h) as usize];
        let length = from.distance(to);
        let count = (length / step).ceil().clamp(1.0, 10_000.0) as usize;
        let at = |i: usize| from.lerp(to, (i as f64 + 0.5) / count as f64);
        places.extend((0..count).map(|i| (at(i), length / count as f64)));
    }
    places
}

/// Share of the length of `of` within `reach` of `to`.
fn near(of: &[(DVec3, f64)], to: &[(DVec3, f64)], reach: f64) -> f64 {
    let points: Vec<[f64; 3]> = to.iter().map(|p| p.0.to_array()).collect();
    let Ok(tree) = ImmutableKdTree::<f64, 3>::new_from_slice(&points) else { return 0.0 };
    let close = |p: &DVec3| {
        let found = tree.query(&p.to_array()).nearest_one::<SquaredEuclidean<f64>>().execute();
        found.distance <= reach * reach
    };
    let total: f64 = of.iter().map(|p| p.1).sum();
    of.iter().filter(|p| close(&p.0)).map(|p| p.1).sum::<f64>() / total.max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of `n` unit squares, two triangles each.
    fn strip(n: u32) -> Surface {
        let positions: Vec<DVec3> = (0..=n)
            .flat_map(|i| [DVec3::new(f64::from(i), 0.0, 0.0), DVec3::new(f64::from(i), 1.0, 0.0)])
            .collect();
        let triangles: Vec<[u32; 3]> = (0..n)
            .flat_map(|i| [[2 * i, 2 * i + 2, 2 * i + 1], [2 * i + 1, 2 * i + 2, 2 * i + 3]])
            .collect();
        let mut twin = vec![NONE; 3 * triangles.len()];
        for i in 0..n {
            // The diagonal, then the edge to the next square.
            let (a, b) = (6 * i + 1, 6 * i + 3);
            (twin[a as usize], twin[b as usize]) = (b, a);
            if i + 1 < n {
                let (a, b) = (6 * i + 4, 6 * i + 8);
                (twin[a as usize], twin[b as usize]) = (b, a);
            }
        }
        Surface { positions, triangles, twin, ..Default::default() }
    }

    #[test]
    fn a_shifted_border_is_near_within_its_shift_only() {
        let s = strip(10);
        let cut = |at: i32| -> Vec<i32> { (0..20).map(|f| i32::from(f / 2 >= at)).collect() };
        let of = |a: i32, b: i32, reach| border_agreement(&s, &cut(a), &cut(b), reach).f1;
        for (a, b, reach, want) in [(5, 5, 0.1, 1.0), (5, 6, 0.5, 0.0), (5, 6, 1.1, 1.0)] {
            assert!((of(a, b, reach) - want).abs() < 1e-9, "{a} {b} {reach}");
        }
        assert_eq!(border_agreement(&s, &cut(0), &cut(5), 1.0).f1, 0.0);
        assert_eq!(border_agreement(&s, &cut(0), &cut(0), 1.0).f1, 1.0);
        // One true border, two found: half of what was found is right.
        let two: Vec<i32> = (0..20).map(|f| f / 2 / 3).map(|k| k.min(2)).collect();
        let got = border_agreement(&s, &cut(3), &two, 0.2);
        assert!((got.precision - 0.5).abs() < 1e-9 && (got.recall - 1.0).abs() < 1e-9, "{got:?}");
    }
}
