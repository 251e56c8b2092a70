//! `uvsegnet openapi`: the description of the HTTP API that `openapi.yaml` holds.

use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result, anyhow};

/// Arguments of `uvsegnet openapi`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Where it goes; standard output if not given.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

/// Run it.
pub fn run(args: Args) -> Result<()> {
    let yaml = crate::http::openapi_yaml().map_err(|error| anyhow!(error))?;
    match args.output {
        Some(path) => {
            std::fs::write(&path, yaml).with_context(|| format!("cannot write {}", path.display()))
        }
        None => std::io::stdout().write_all(yaml.as_bytes()).context("cannot write"),
    }
}
