//! Tasks that end when they would not: whoever tests that a result does not depend on the order in which they end
//! has threads give way at the ends of tasks, as often as numbers from a seed say.

use std::sync::atomic::{AtomicU64, Ordering};

/// 0 while nothing is disturbed; else what the next numbers are drawn from.
static STATE: AtomicU64 = AtomicU64::new(0);

/// Most times that a thread gives way.
const MOST: u64 = 16;

/// Disturb the tasks of this process from now on; with 0 no more.
pub fn disturb(seed: u64) {
    STATE.store(seed, Ordering::Relaxed);
}

/// A task ends.
pub(super) fn ended() {
    if STATE.load(Ordering::Relaxed) == 0 {
        return;
    }
    // A Weyl sequence through the finaliser of SplitMix64 (Steele, Lea & Flood 2014, doi:10.1145/2714064.2660195).
    let mut z = STATE.fetch_add(0x9E37_79B9_7F4A_7C15, Ordering::Relaxed);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    for _ in 0..(z ^ (z >> 31)) % MOST {
        std::thread::yield_now();
    }
}
