//! Parse the command line, call `cli`.

use std::process::ExitCode;

fn main() -> ExitCode {
    uvsegnet::cli::main()
}
