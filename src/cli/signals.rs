//! Signals that ask a process to finish.

use std::io;

use tokio::signal::unix::{SignalKind, signal};
use tokio_util::sync::CancellationToken;

/// Cancel `token` at SIGTERM or SIGINT; exit at once at the second. A `supervised` process leaves
/// SIGINT to its server, for a terminal sends it to both.
pub fn cancel_on_signal(token: CancellationToken, supervised: bool) -> io::Result<()> {
    let mut terminate = signal(SignalKind::terminate())?;
    let mut interrupt = signal(SignalKind::interrupt())?;
    tokio::spawn(async move {
        loop {
            tokio::select! {
                _ = terminate.recv() => {}
                _ = interrupt.recv() => if supervised { continue },
            }
            if token.is_cancelled() {
                tracing::warn!("told to stop a second time: exiting at once");
                std::process::exit(1);
            }
            token.cancel();
        }
    });
    Ok(())
}
