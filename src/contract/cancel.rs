//! A token that asks running work to stop. Every loop of the pipeline looks at it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Shared by whoever may cancel and the work that is to stop.
#[derive(Debug, Clone, Default)]
pub struct Cancel {
    asked: Arc<AtomicBool>,
    /// When the work is to stop of itself.
    end: Option<Instant>,
}

/// The work was asked to stop, or its time is over, and it did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("canceled")]
pub struct Canceled;

impl Cancel {
    /// The same token for work that must be over by then.
    pub fn until(self, end: Option<Instant>) -> Self {
        Self { end, ..self }
    }

    /// Ask the work to stop. Idempotent.
    pub fn cancel(&self) {
        self.asked.store(true, Ordering::Release);
    }

    /// Whether somebody asked the work to stop.
    pub fn is_asked(&self) -> bool {
        self.asked.load(Ordering::Acquire)
    }

    /// Whether the work is to stop: somebody asked, or its time is over.
    pub fn is_canceled(&self) -> bool {
        self.is_asked() || self.end.is_some_and(|end| Instant::now() >= end)
    }

    /// `Err(Canceled)` once the work is to stop: `cancel.check()?` in every loop.
    pub fn check(&self) -> Result<(), Canceled> {
        if self.is_canceled() { Err(Canceled) } else { Ok(()) }
    }
}
