//! Notices that something was committed, by this process or another, so that streams, long polls
//! and idle workers need not ask the queue all the time. A store holds a [`Commits`] and tells;
//! whoever waits holds a [`Changes`].

use std::time::Duration;

use tokio::sync::watch;

/// A subscription to commits. Take one (clone it), *then* read, then wait, then read again: no
/// commit is missed. It does not say what changed.
#[derive(Debug, Clone)]
pub struct Changes(watch::Receiver<u64>);

impl Changes {
    /// A subscription, and what feeds it.
    pub fn new() -> (Commits, Self) {
        let (sender, receiver) = watch::channel(0);
        (Commits(sender), Self(receiver))
    }

    /// Wait until something was committed since this returned last (or since this subscription was
    /// taken). Commits in quick succession are noticed once.
    pub async fn changed(&mut self) {
        if self.0.changed().await.is_err() {
            // The store is gone, so the runtime is going: nothing will change any more.
            std::future::pending::<()>().await;
        }
    }

    /// [`Changes::changed`], or the end of `patience`, whatever is first.
    pub async fn changed_within(&mut self, patience: Duration) {
        // Both ends mean the same to the caller: look again.
        let _ = tokio::time::timeout(patience, self.changed()).await;
    }
}

/// The store's end: it tells of every commit that it makes or notices.
#[derive(Debug)]
pub struct Commits(watch::Sender<u64>);

impl Commits {
    /// Something was committed.
    pub fn tell(&self) {
        self.0.send_modify(|count| *count += 1);
    }

    /// Whether nobody listens any more.
    pub fn is_closed(&self) -> bool {
        self.0.is_closed()
    }
}
