//! The command line: one file a subcommand. `serve` is composed here: http plus the supervisor.

mod bench;
mod demo;
mod doctor;
mod ending;
mod input;
mod log;
mod many;
mod openapi;
mod options;
mod outputs;
mod reference;
mod segment;
pub mod serve;
mod signals;
mod synth;
mod threads;
mod told;
mod train;
mod unwrap;
mod watched;
mod weights;
mod worker;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// UV unwrapping with seams that follow an object's parts.
#[derive(Debug, Parser)]
#[command(name = "uvsegnet", version, about, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Show the whole service at work: start it, unwrap the sample chair over HTTP, stop it.
    Demo(demo::Args),
    /// Unwrap one file or many, without a server.
    Unwrap(unwrap::Args),
    /// Find the parts of one file; write one label a face.
    Segment(segment::Args),
    /// Run the service: HTTP API, queue and workers.
    Serve(serve::Args),
    /// Run one worker on the queue of a service.
    Worker(worker::Args),
    /// Say which device would be used and prove it with a small computation.
    Doctor(doctor::Args),
    /// Measure how good the results are on a folder of meshes.
    Bench(bench::Args),
    /// Make a labelled sample object.
    Synth(synth::Args),
    /// Train the segmentation network.
    Train(train::Args),
    /// Print the OpenAPI description of the service.
    Openapi(openapi::Args),
    /// Write the reference of options, files, warnings and error codes from the tables in the source.
    #[command(hide = true)]
    Reference(reference::Args),
}

/// Run the program. Errors go to standard error with their causes.
pub fn main() -> ExitCode {
    let result = match Cli::parse().command {
        Command::Demo(args) => demo::run(args),
        Command::Unwrap(args) => unwrap::run(args),
        Command::Segment(args) => segment::run(args),
        Command::Serve(args) => serve::run(args),
        Command::Worker(args) => worker::run(args),
        Command::Doctor(args) => doctor::run(args),
        Command::Bench(args) => bench::run(args),
        Command::Synth(args) => synth::run(args),
        Command::Train(args) => train::run(args),
        Command::Openapi(args) => openapi::run(args),
        Command::Reference(args) => reference::run(args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
