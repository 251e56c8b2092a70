//! Whether a worker process is alive, told by its host and not by any table.

use std::any::Any;
use std::fs::{File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Who lives on this host.
pub trait Presence: Send + Sync + 'static {
    /// Declare that the worker `id` is alive, for as long as the answer is kept and its process
    /// lives, however it ends. Fails if another process has that id.
    fn declare(&self, id: &str) -> io::Result<Alive>;

    /// Whether the worker `id` of this host is dead.
    fn is_dead(&self, id: &str) -> bool;

    /// Remove what the dead left behind.
    fn tidy(&self) -> io::Result<()>;
}

/// Held by a worker while it lives.
pub struct Alive(#[expect(dead_code, reason = "it is its end that tells")] Box<dyn Any + Send>);

/// Age below which a lock file that nobody holds may be about to be locked.
const YOUNG: Duration = Duration::from_secs(60);

/// Presence by file locks: a worker holds one for as long as it lives, and the kernel lets go of it
/// at its death. A process id would not do: it is reused.
#[derive(Debug, Clone)]
pub struct LockFiles {
    folder: PathBuf,
}

struct Lock {
    _file: File,
    path: PathBuf,
}

impl LockFiles {
    /// Locks in this folder, which is made when the first worker declares itself.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into() }
    }
}

impl Presence for LockFiles {
    fn declare(&self, id: &str) -> io::Result<Alive> {
        std::fs::create_dir_all(&self.folder)?;
        let path = lock_path(&self.folder, id);
        let file = File::create(&path)?;
        file.try_lock().map_err(|error| match error {
            TryLockError::WouldBlock => {
                io::Error::other(format!("a worker with the id {id:?} is running already"))
            }
            TryLockError::Error(error) => error,
        })?;
        Ok(Alive(Box::new(Lock { _file: file, path })))
    }

    /// Forgets its lock file if so.
    fn is_dead(&self, id: &str) -> bool {
        let path = lock_path(&self.folder, id);
        match File::open(&path) {
            Ok(file) if file.try_lock().is_ok() => {
                let _ = std::fs::remove_file(path);
                true
            }
            Ok(_) => false,
            Err(error) => error.kind() == io::ErrorKind::NotFound,
        }
    }

    /// Removes the lock files of workers that are dead for a while, whoever noticed their death.
    fn tidy(&self) -> io::Result<()> {
        let entries = match std::fs::read_dir(&self.folder) {
            Ok(entries) => entries,
            // The folder is not there before the first worker.
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
            Err(error) => return Err(error),
        };
        for entry in entries {
            let path = entry?.path();
            let Ok(age) = path.metadata().and_then(|data| data.modified()).map(|at| at.elapsed())
            else {
                continue;
            };
            let free = |path: &Path| File::open(path).is_ok_and(|file| file.try_lock().is_ok());
            if age.is_ok_and(|age| age >= YOUNG) && free(&path) {
                std::fs::remove_file(path)?;
            }
        }
        Ok(())
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // What cannot be removed is tidied away later.
        let _ = std::fs::remove_file(&self.path);
    }
}

fn lock_path(folder: &Path, id: &str) -> PathBuf {
    folder.join(format!("{id}.lock"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_worker_is_alive_while_it_holds_its_lock() {
        let folder = tempfile::tempdir().unwrap();
        let locks = LockFiles::new(folder.path());
        assert!(locks.is_dead("w1"));
        let alive = locks.declare("w1").unwrap();
        assert!(!locks.is_dead("w1"));
        assert!(locks.declare("w1").is_err());
        drop(alive);
        assert!(locks.is_dead("w1"));
        assert!(!folder.path().join("w1.lock").exists());
    }

    #[test]
    fn only_old_locks_of_the_dead_are_tidied_away() {
        let folder = tempfile::tempdir().unwrap();
        let locks = LockFiles::new(folder.path().join("made-by-the-first"));
        locks.tidy().unwrap();
        let _alive = locks.declare("alive").unwrap();
        let [dead, young] = ["dead", "young"].map(|id| lock_path(&locks.folder, id));
        File::create(&young).unwrap();
        let old = std::time::SystemTime::now() - 2 * YOUNG;
        File::create(&dead).unwrap().set_modified(old).unwrap();
        File::open(lock_path(&locks.folder, "alive")).unwrap().set_modified(old).unwrap();
        locks.tidy().unwrap();
        assert!(!dead.exists() && young.exists());
        assert!(!locks.is_dead("alive"));
    }
}
