//! Long loops in blocks of one size, whatever the number of threads: what is summed over them is the same to the
//! last bit.

use std::ops::Range;

use rayon::prelude::*;

use super::fork::even;

/// Items of a block; fewer than two blocks are done by the thread that asks.
const BLOCK: usize = 2048;

/// The item at each place.
pub fn fill<T: Send>(
    name: &'static str,
    count: usize,
    item: impl Fn(usize) -> T + Send + Sync,
) -> Vec<T> {
    if count <= BLOCK {
        return (0..count).map(item).collect();
    }
    let blocks = count.div_ceil(BLOCK);
    even(name, blocks, || (0..count).into_par_iter().with_min_len(BLOCK).map(item).collect())
}

/// What each block comes to, in order. `of` is told which places it has.
pub fn blocks<T: Send>(
    name: &'static str,
    count: usize,
    of: impl Fn(Range<usize>) -> T + Send + Sync,
) -> Vec<T> {
    let number = count.div_ceil(BLOCK);
    let block = |i: usize| of(i * BLOCK..((i + 1) * BLOCK).min(count));
    if number <= 1 {
        return (0..number).map(block).collect();
    }
    even(name, number, || (0..number).into_par_iter().map(block).collect())
}

/// The sum over all places, block by block and the blocks in order.
pub fn sum(name: &'static str, count: usize, item: impl Fn(usize) -> f64 + Send + Sync) -> f64 {
    blocks(name, count, |places| places.map(&item).sum::<f64>()).into_iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sum_has_the_same_bits_at_any_number_of_threads() {
        let term = |i: usize| 1.0 / (1.0 + i as f64).powf(1.3);
        for count in [0, 1, BLOCK, BLOCK + 1, 10 * BLOCK - 7] {
            let of = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| (sum("", count, term).to_bits(), fill("", count, term)))
            };
            let one = of(1);
            assert_eq!(one.1, (0..count).map(term).collect::<Vec<_>>());
            assert!([2, 3, 8].iter().all(|&threads| of(threads) == one));
            assert_eq!(blocks("", count, |places| places.len()).iter().sum::<usize>(), count);
        }
    }
}
