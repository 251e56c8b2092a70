//! Parse the command line, call `cli`.

use std::process::ExitCode;

/// Large tensors come and go at every training step; glibc would hand them back to the kernel each
/// time, which costs two fifths of a step.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    uvsegnet::cli::main()
}
