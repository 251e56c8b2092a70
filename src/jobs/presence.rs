//! Whether a worker process of this host is alive: it holds a file lock for as long as it lives, and
//! the kernel lets go of it at its death, however it dies. A process id would not do: it is reused.

use std::fs::{File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Age below which a lock file that nobody holds may be about to be locked.
const YOUNG: Duration = Duration::from_secs(60);

/// Held by a worker while it lives.
#[derive(Debug)]
pub struct Presence {
    _lock: File,
    path: PathBuf,
}

impl Presence {
    /// Declare that the worker `id` is alive. Fails if another process has that id.
    pub fn declare(folder: &Path, id: &str) -> io::Result<Self> {
        std::fs::create_dir_all(folder)?;
        let path = lock_path(folder, id);
        let file = File::create(&path)?;
        file.try_lock().map_err(|error| match error {
            TryLockError::WouldBlock => {
                io::Error::other(format!("a worker with the id {id:?} is running already"))
            }
            TryLockError::Error(error) => error,
        })?;
        Ok(Self { _lock: file, path })
    }

    /// Whether the worker `id` of this host is dead. Forgets its lock file if so.
    pub fn is_dead(folder: &Path, id: &str) -> bool {
        let path = lock_path(folder, id);
        match File::open(&path) {
            Ok(file) if file.try_lock().is_ok() => {
                let _ = std::fs::remove_file(path);
                true
            }
            Ok(_) => false,
            Err(error) => error.kind() == io::ErrorKind::NotFound,
        }
    }

    /// Remove the lock files of workers that are dead for a while, whoever noticed their death.
    pub fn tidy(folder: &Path) -> io::Result<()> {
        for entry in std::fs::read_dir(folder)? {
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

impl Drop for Presence {
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
        assert!(Presence::is_dead(folder.path(), "w1"));
        let presence = Presence::declare(folder.path(), "w1").unwrap();
        assert!(!Presence::is_dead(folder.path(), "w1"));
        assert!(Presence::declare(folder.path(), "w1").is_err());
        drop(presence);
        assert!(Presence::is_dead(folder.path(), "w1"));
        assert!(!folder.path().join("w1.lock").exists());
    }

    #[test]
    fn only_old_locks_of_the_dead_are_tidied_away() {
        let folder = tempfile::tempdir().unwrap();
        let _alive = Presence::declare(folder.path(), "alive").unwrap();
        let [dead, young] = ["dead", "young"].map(|id| lock_path(folder.path(), id));
        File::create(&young).unwrap();
        let old = std::time::SystemTime::now() - 2 * YOUNG;
        File::create(&dead).unwrap().set_modified(old).unwrap();
        File::open(lock_path(folder.path(), "alive")).unwrap().set_modified(old).unwrap();
        Presence::tidy(folder.path()).unwrap();
        assert!(!dead.exists() && young.exists());
        assert!(!Presence::is_dead(folder.path(), "alive"));
    }
}
