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
mod event_data;
mod housekeeping;
mod input;
mod job;
mod keep;
mod memory;
mod open;
mod presence;
mod queue;
mod sqlite;
mod states;
mod submit;
mod summary;
mod work;
mod worker;

pub use blobs::{BlobError, BlobFolder, BlobStream, BlobWriter, Blobs, OrphanError, StoredBlob};
pub use changes::{Changes, Commits};
pub use event::{Event, EventKind, NewEvent};
pub use event_data::{
    CanceledEvent, EventData, FailedEvent, PartCompletedEvent, RetryingEvent, StageEvent,
    SucceededEvent, WarningEvent,
};
pub use housekeeping::Housekeeping;
pub use input::{Inputs, StoredInput};
pub use job::{Job, JobId, JobIdError, JobProgress, JobState, NewJob, StoredArtifact, Versions};
pub use keep::{Keep, Swept};
pub use memory::MemoryQueue;
pub use open::{Kept, OpenError, Schema, open};
pub use presence::{Alive, LockFiles, Presence};
pub use queue::{Queue, QueueError};
pub use sqlite::SqliteQueue;
pub use states::Policy;
pub use submit::{CancelOutcome, Deleted, ListFilter, Page, Stats, Submit};
pub use summary::MetricsSummary;
pub use work::{Claim, Handover, Lease, Tick, TickAnswer, Work};
pub use worker::{WORKER_ALIVE, Worker};
