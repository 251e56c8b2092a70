//! The tie between a worker and the server that started it: the worker's standard input. A line
//! `drain` asks it to finish; the end of the input means that the server is gone, however it went,
//! and nobody would supervise the worker any more.

use std::io::{self, BufRead};

use tokio_util::sync::CancellationToken;

/// What the server writes to ask a worker to finish.
pub const DRAIN: &str = "drain\n";

/// Watch the input from a thread of its own, which no busy runtime can hold up.
pub fn watch(drain: CancellationToken) -> io::Result<()> {
    let watcher = std::thread::Builder::new().name("parent".into());
    watcher.spawn(move || {
        for line in io::stdin().lock().lines() {
            match line {
                Ok(line) if line == DRAIN.trim_end() => drain.cancel(),
                Ok(_) => {}
                Err(_) => break,
            }
        }
        // At once: the job is taken back when the lock of this process falls.
        std::process::exit(0);
    })?;
    Ok(())
}
