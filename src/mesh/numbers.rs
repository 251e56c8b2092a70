//! Where each of some numbers stands among them.

use super::NONE;

/// A table is made where at least one number in so many of their span is among them; fewer are searched for.
const SPARSE: usize = 16;

/// The places of ascending numbers. A search for each of many would take most of the time of those who ask.
pub enum Numbers<'a> {
    /// Few: searched for.
    Sorted(&'a [u32]),
    /// From `first` on; [`NONE`] for numbers that are not among them.
    Table {
        /// The lowest number.
        first: u32,
        /// A place for each number from there to the highest.
        places: Vec<u32>,
    },
}

impl<'a> Numbers<'a> {
    /// Of ascending numbers.
    pub fn of(numbers: &'a [u32]) -> Self {
        let first = numbers.first().copied().unwrap_or(0);
        let span = numbers.last().map_or(0, |last| (last - first) as usize + 1);
        if SPARSE * numbers.len() < span {
            return Self::Sorted(numbers);
        }
        let mut places = vec![NONE; span];
        (0u32..).zip(numbers).for_each(|(i, &n)| places[(n - first) as usize] = i);
        Self::Table { first, places }
    }

    /// Where a number is, [`NONE`] where it is not.
    pub fn get(&self, number: u32) -> u32 {
        match self {
            Self::Sorted(numbers) => numbers.binary_search(&number).map_or(NONE, |i| i as u32),
            Self::Table { first, places } => {
                let at = number.checked_sub(*first).and_then(|at| places.get(at as usize));
                at.copied().unwrap_or(NONE)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_and_many_have_the_same_places() {
        let dense: Vec<u32> = (100..200).filter(|n| n % 3 == 0).collect();
        let sparse = [5, 1_000, 70_000];
        for numbers in [&dense[..], &sparse[..], &[]] {
            let places = Numbers::of(numbers);
            for n in [0, 4, 5, 99, 102, 103, 198, 999, 1_000, 70_000, NONE] {
                let want = numbers.iter().position(|&m| m == n).map_or(NONE, |i| i as u32);
                assert_eq!(places.get(n), want, "{n}");
            }
        }
    }
}
