//! Work done ahead of its turn, by threads that have nothing else to do. What comes out must not depend on it.

use std::sync::atomic::{AtomicBool, Ordering};

use super::fork::Fork;

/// Do `first`, and at the same time what may be needed after it. `ahead` is told whether `first` is done: nothing
/// is to be begun then, for it may come to be needed no more.
pub fn beside<A: Send, B: Send>(
    name: &'static str,
    first: impl FnOnce() -> A + Send,
    ahead: impl FnOnce(&(dyn Fn() -> bool + Sync)) -> B + Send,
) -> (A, B) {
    let (done, fork) = (AtomicBool::new(false), Fork::open(name));
    let first = || {
        let made = fork.task(first);
        done.store(true, Ordering::Relaxed);
        made
    };
    let ahead = || fork.task(|| ahead(&|| done.load(Ordering::Relaxed)));
    rayon::join(first, ahead)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tasks::record;

    #[test]
    fn what_may_be_needed_is_begun_while_the_first_is_done_and_not_after() {
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let (first, late) = pool.install(|| beside("", || 1, |is_late| is_late()));
            assert!(first == 1 && (threads > 1 || late), "one thread has no time for it");
        }
    }

    #[test]
    fn who_records_has_what_one_thread_does() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let ((first, late), recorded) =
            pool.install(|| record(|| beside("", || 1, |is_late| is_late())));
        assert_eq!((first, late), (1, true));
        assert!(recorded.schedule().span() <= recorded.schedule().work());
    }
}
