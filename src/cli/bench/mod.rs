//! `uvsegnet bench`: how good the results are on a folder of meshes.

mod object;
mod peer;
mod quality;
mod table;

use anyhow::Result;
use clap::Subcommand;

/// Arguments of `uvsegnet bench`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Unwrap every mesh of a folder, next to the classical unwrapper on the same sheets; write one
    /// JSON line an object and print the table.
    Quality(quality::Args),
}

/// Run it.
pub fn run(args: Args) -> Result<()> {
    match args.what {
        What::Quality(args) => quality::run(args),
    }
}
