//! How long the search for a denser arrangement goes on: it ends when a batch of trials is expected to gain
//! less than it costs, and in any case after so much work.

use crate::contract::Quality;

/// When one search ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Effort {
    /// Words looked at after which nothing further is begun; 10⁸ are about a third of a second of one core.
    pub work: u64,
    /// Batches without gain, at the smallest step of the density, after which no more is expected: of n
    /// batches without one the next gains with a chance of about 1/n.
    pub idle: u32,
}

impl Effort {
    /// On the coarse pages, where arrangements are found, and on those that count, where the best one
    /// is settled.
    pub fn of(quality: Quality) -> [Self; 2] {
        let effort = |millions: u64, idle| Self { work: millions * 1_000_000, idle };
        match quality {
            Quality::Fast => [effort(24, 6), effort(10, 6)],
            Quality::Balanced => [effort(60, 20), effort(20, 8)],
            Quality::Best => [effort(400, 60), effort(100, 20)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_quality_is_more_effort() {
        let [fast, balanced, best] =
            [Quality::Fast, Quality::Balanced, Quality::Best].map(Effort::of);
        for k in 0..2 {
            assert!(fast[k].work < balanced[k].work && balanced[k].work < best[k].work);
            assert!(fast[k].idle <= balanced[k].idle && balanced[k].idle < best[k].idle);
        }
    }
}
