//! How many base points each face gets (paper 2.1.2): in proportion to its area, at least one a
//! usable face as long as there are enough points to go round.

/// Counts for faces of these areas (0: not usable) that add up to `total`, by largest remainder.
/// With fewer points than usable faces nobody is owed one and the largest shares win.
pub(super) fn allocate(areas: &[f64], total: usize) -> Vec<u32> {
    let mut counts = vec![0u32; areas.len()];
    let mut open: Vec<usize> = (0..areas.len()).filter(|&f| areas[f] > 0.0).collect();
    if open.is_empty() {
        return counts;
    }
    let mut left = total;
    if total >= open.len() {
        // A face whose share is below one gets one; the rest share what is left. Each round takes
        // at least one face out, in practice nearly all of them in the first two.
        loop {
            let share = left as f64 / open.iter().map(|&f| areas[f]).sum::<f64>();
            let (rest, small): (Vec<usize>, Vec<usize>) =
                open.iter().partition(|&&f| areas[f] * share >= 1.0);
            for &f in &small {
                counts[f] = 1;
            }
            left -= small.len();
            open = rest;
            if small.is_empty() || open.is_empty() {
                break;
            }
        }
    }
    let share = left as f64 / open.iter().map(|&f| areas[f]).sum::<f64>();
    let mut remainders = Vec::with_capacity(open.len());
    let mut given = 0;
    for &f in &open {
        let exact = areas[f] * share;
        counts[f] = exact as u32;
        given += exact as usize;
        remainders.push((exact.fract(), f));
    }
    remainders.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    for &(_, f) in remainders.iter().take(left.saturating_sub(given)) {
        counts[f] += 1;
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::allocate;
    use proptest::prelude::*;

    #[test]
    fn shares_follow_the_areas() {
        assert_eq!(allocate(&[3.0, 1.0, 0.0, 4.0], 16), [6, 2, 0, 8]);
        assert_eq!(allocate(&[1.0, 1e-9, 1.0], 5), [2, 1, 2]);
        assert_eq!(allocate(&[1.0, 3.0, 2.0], 2), [0, 1, 1]);
        assert_eq!(allocate(&[0.0, 0.0], 9), [0, 0]);
    }

    proptest! {
        #[test]
        fn counts_add_up_and_leave_nobody_out(
            areas in prop::collection::vec(1e-6f64..10.0, 1..200), extra in 0usize..500,
        ) {
            let total = areas.len() + extra;
            let counts = allocate(&areas, total);
            prop_assert_eq!(counts.iter().sum::<u32>() as usize, total);
            prop_assert!(counts.iter().all(|&c| c >= 1));
            let sum: f64 = areas.iter().sum();
            for (count, area) in counts.iter().zip(&areas) {
                // Nobody gets more than its own share rounded up, or one.
                prop_assert!(f64::from(*count) <= (area / sum * total as f64).ceil().max(1.0));
            }
        }
    }
}
