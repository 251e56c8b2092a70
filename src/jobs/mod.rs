//! Jobs: what a job is, the queue that hands jobs to workers, the blobs that jobs name, and the
//! events that tell how a job goes. The queue is the only thing between the API and the workers:
//! both hold a [`Queue`], a [`Blobs`] and a [`Changes`], and no other protocol exists.
//!
//! ```text
//! queued ──claim──▶ running ──finish──▶ succeeded
//!   ▲  │               │ ├────fail────▶ failed
//!   │  └──cancel───────┼─┴────cancel──▶ canceled
//!   └──release, crash──┘
//! ```

mod blobs;
mod changes;
mod event;
mod housekeeping;
mod job;
mod presence;
mod queue;
mod sqlite;
mod summary;

pub use blobs::{BlobError, BlobFolder, BlobStream, BlobWriter, Blobs, OrphanError, StoredBlob};
pub use changes::Changes;
pub use event::{Event, EventKind, NewEvent};
pub use housekeeping::Housekeeping;
pub use job::{Job, JobId, JobIdError, JobProgress, JobState, NewJob, StoredArtifact, Versions};
pub use presence::Presence;
pub use queue::{
    CancelOutcome, Claim, Deleted, Handover, Lease, ListFilter, Page, Queue, QueueError, Stats,
    Swept, Tick, TickAnswer, WORKER_ALIVE, Worker,
};
pub use sqlite::{SqliteConfig, SqliteQueue};
pub use summary::MetricsSummary;
