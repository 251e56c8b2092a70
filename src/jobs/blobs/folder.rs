//! What a store in a local directory needs besides: its folders made, and the temporary files swept
//! that writers left behind when they died. All of it off the async threads.

use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use super::{BlobError, BlobFolder};

/// The directory that a local store lies in.
#[derive(Debug, Clone)]
pub(super) struct Folder {
    root: PathBuf,
}

impl Folder {
    pub(super) fn new(root: &Path) -> Self {
        Self { root: root.to_path_buf() }
    }

    /// Make what is not there.
    pub(super) async fn make(&self) -> Result<(), BlobError> {
        self.off_thread(|root| {
            BlobFolder::ALL
                .into_iter()
                .try_for_each(|folder| std::fs::create_dir_all(root.join(folder.as_str())))
        })
        .await
    }

    /// Remove temporary files of at least this age, which the store does not list. Returns how many
    /// went.
    pub(super) async fn sweep(&self, now: SystemTime, grace: Duration) -> Result<u64, BlobError> {
        self.off_thread(move |root| {
            let mut gone = 0;
            for folder in BlobFolder::ALL {
                for entry in std::fs::read_dir(root.join(folder.as_str()))? {
                    gone += u64::from(swept(&entry?, now, grace));
                }
            }
            Ok(gone)
        })
        .await
    }

    async fn off_thread<T: Send + 'static>(
        &self,
        work: impl FnOnce(&Path) -> io::Result<T> + Send + 'static,
    ) -> Result<T, BlobError> {
        let root = self.root.clone();
        let done = tokio::task::spawn_blocking(move || work(&root)).await;
        let done = done.unwrap_or_else(|error| Err(error.into()));
        done.map_err(|source| BlobError::Directory { path: self.root.clone(), source })
    }
}

/// Whether this was an old temporary file (`name#1`), and is gone.
fn swept(entry: &std::fs::DirEntry, now: SystemTime, grace: Duration) -> bool {
    let temporary = entry.file_name().to_string_lossy().contains('#');
    // A file that went in the meantime has no age.
    let Ok(modified) = entry.metadata().and_then(|data| data.modified()) else { return false };
    let age = now.duration_since(modified).unwrap_or_default();
    temporary && age >= grace && std::fs::remove_file(entry.path()).is_ok()
}
