//! The threads of this process: one pool, kept warm for its life.

use std::num::NonZeroUsize;

/// How many threads the processors, the affinity mask and the cgroup of this process give it.
pub fn available() -> usize {
    std::thread::available_parallelism().map_or(1, NonZeroUsize::get)
}

/// How many threads the pool has in which this is asked.
pub fn threads() -> usize {
    rayon::current_num_threads()
}

/// Start the pool that everything runs on: so many threads, or as many as are [`available`] (RAYON_NUM_THREADS, if
/// it is set), each with so many bytes of stack. Once, before anything is done in parallel; later calls change
/// nothing.
pub fn start(threads: Option<NonZeroUsize>, stack: usize) {
    let threads = threads.map_or(0, NonZeroUsize::get);
    let name = |i| format!("task-{i}");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).stack_size(stack);
    // The only error is that there is one already.
    let _ = pool.thread_name(name).build_global();
}
