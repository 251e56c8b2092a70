//! The stores, and how one promise is checked on each of them.

use std::ops::Deref;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use tempfile::TempDir;
use uvsegnet::jobs::{Changes, MemoryQueue, Policy, Queue, SqliteQueue};

/// Which store.
#[derive(Debug, Clone, Copy)]
pub enum Store {
    Sqlite,
    Memory,
}

/// A fresh queue; what it lies in goes with it.
pub struct Fresh {
    queue: Arc<dyn Queue>,
    pub changes: Changes,
    lies_in: LiesIn,
}

enum LiesIn {
    Folder(TempDir),
    Memory(MemoryQueue),
}

impl Store {
    /// A fresh queue with the usual policy.
    pub async fn fresh(self) -> Fresh {
        self.fresh_with(|_| {}).await
    }

    /// A fresh queue whose policy is changed.
    pub async fn fresh_with(self, change: impl FnOnce(&mut Policy)) -> Fresh {
        let mut policy = Policy::default();
        change(&mut policy);
        match self {
            Store::Sqlite => {
                let folder = tempfile::tempdir().unwrap();
                let file = folder.path().join("queue.db");
                SqliteQueue::migrate(&file).await.unwrap();
                let queue = SqliteQueue::open(&file, policy, Duration::ZERO).await.unwrap();
                let changes = queue.changes();
                Fresh { queue: Arc::new(queue), changes, lies_in: LiesIn::Folder(folder) }
            }
            Store::Memory => {
                let queue = MemoryQueue::new(policy);
                let changes = queue.changes();
                let lies_in = LiesIn::Memory(queue.clone());
                Fresh { queue: Arc::new(queue), changes, lies_in }
            }
        }
    }
}

impl Fresh {
    /// The same queue as another process would see it: with connections of its own, where it has
    /// such.
    pub async fn again(&self) -> Arc<dyn Queue> {
        match &self.lies_in {
            LiesIn::Folder(folder) => {
                let file: PathBuf = folder.path().join("queue.db");
                let policy = Policy::default();
                Arc::new(SqliteQueue::open(&file, policy, Duration::ZERO).await.unwrap())
            }
            LiesIn::Memory(queue) => Arc::new(queue.clone()),
        }
    }
}

impl Deref for Fresh {
    type Target = dyn Queue;

    fn deref(&self) -> &Self::Target {
        &*self.queue
    }
}

/// `on_every_store!(promise…)` makes tests `sqlite::promise` and `memory::promise` of each
/// `async fn promise(store: Store)` beside it.
macro_rules! on_every_store {
    ($($promise:ident),+ $(,)?) => {
        on_every_store!(@ sqlite Sqlite $($promise)+);
        on_every_store!(@ memory Memory $($promise)+);
    };
    (@ $module:ident $store:ident $($promise:ident)+) => {
        mod $module {
            $(#[tokio::test(flavor = "multi_thread")]
            async fn $promise() {
                super::$promise(crate::stores::Store::$store).await;
            })+
        }
    };
}
pub(crate) use on_every_store;
