//! How much a service and its workers log.

use std::ffi::OsString;

use crate::telemetry::Told;

/// The flag `--quiet`.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct LogFlag {
    /// Log errors alone. UVSEGNET_LOG, in the syntax of RUST_LOG, says otherwise.
    #[arg(long)]
    pub quiet: bool,
}

impl LogFlag {
    /// What is told.
    pub fn told(self) -> Told {
        if self.quiet { Told::Errors } else { Told::Usual }
    }

    /// The flag again, for a process that this one starts.
    pub fn flag(self) -> Option<OsString> {
        self.quiet.then(|| "--quiet".into())
    }
}
