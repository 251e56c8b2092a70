//! The options of a job as the flags of a command: checked before any work, and told by their flags.

use anyhow::{Result, bail};

use crate::contract::{OptionError, UnwrapOptions};

/// An error that names every flag whose value cannot be.
pub fn valid(options: &UnwrapOptions) -> Result<()> {
    let Err(errors) = options.validate() else { return Ok(()) };
    let line = |e: &OptionError| {
        format!("--{} {}", e.pointer.trim_start_matches('/').replace('_', "-"), e.detail)
    };
    bail!("{}", errors.iter().map(line).collect::<Vec<_>>().join("\n"))
}
