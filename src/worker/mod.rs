//! Workers: processes that take jobs from the queue, one at a time, and run the pipeline on them; and
//! the supervisor that keeps the local ones alive. A worker is a process of its own because a lost
//! GPU, a panicking driver or the killer of memory hogs must cost one attempt of one job and never
//! the service.

mod attempt;
mod claims;
mod parent;
mod pipeline_thread;
mod reporter;
mod results;
mod supervisor;

pub use claims::{WorkerSettings, run};
pub use parent::watch as watch_parent;
pub use supervisor::Supervisor;

/// What ended a worker, or kept it from starting.
#[derive(Debug, thiserror::Error)]
pub enum WorkerError {
    /// The queue cannot be used.
    #[error(transparent)]
    Queue(#[from] crate::jobs::QueueError),
    /// There is no such device, or it does not compute.
    #[error(transparent)]
    Device(#[from] crate::device::DeviceError),
    /// Anything that the system refused.
    #[error(transparent)]
    System(#[from] std::io::Error),
}

/// The exit status of a worker that must be replaced by a fresh one: EX_TEMPFAIL of `sysexits.h`.
pub const EXIT_RENEW: i32 = 75;
