//! How many threads a command works with.

use std::num::NonZeroUsize;

use crate::pipeline::STACK;
use crate::tasks;

/// The flag `--threads`.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct ThreadsFlag {
    /// Threads to work with; by default as many as the processors, the affinity mask and the cgroup of the process
    /// allow. The result does not depend on it.
    #[arg(long, value_name = "N", env = "UVSEGNET_THREADS")]
    pub threads: Option<NonZeroUsize>,
}

impl ThreadsFlag {
    /// How many they are.
    pub fn count(self) -> usize {
        self.threads.map_or_else(tasks::available, NonZeroUsize::get)
    }

    /// Start them, before anything else is done.
    pub fn start(self) {
        tasks::start(self.threads, STACK);
    }
}
