//! Work done ahead of its turn, by threads that have nothing else to do.

use std::sync::atomic::{AtomicBool, Ordering};

/// Do `first`, and at the same time what may be needed after it. `ahead` is told whether `first` is done: nothing
/// is to be begun then, for it may come to be needed no more.
pub fn beside<A: Send, B: Send>(
    first: impl FnOnce() -> A + Send,
    ahead: impl FnOnce(&(dyn Fn() -> bool + Sync)) -> B + Send,
) -> (A, B) {
    let done = AtomicBool::new(false);
    let first = || {
        let made = first();
        done.store(true, Ordering::Relaxed);
        made
    };
    rayon::join(first, || ahead(&|| done.load(Ordering::Relaxed)))
}
