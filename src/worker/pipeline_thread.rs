//! The pipeline on a thread of its own, so that the tick goes on whatever it does.

use std::any::Any;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};

use bytes::Bytes;
use tokio::sync::oneshot;

use crate::contract::{InputRole, JobError, Limits, MeshKind, Run, UnwrapOptions};
use crate::pipeline::{Engine, Input, InputFile, STACK, Unwrapped, unwrap_input};

/// One call of the pipeline.
pub struct Call {
    /// The mesh.
    pub mesh: Bytes,
    /// What kind of mesh that is.
    pub kind: MeshKind,
    /// What stands beside it.
    pub beside: Vec<Beside>,
    /// What to do.
    pub options: UnwrapOptions,
    /// What is accepted.
    pub limits: Limits,
    /// What computes.
    pub engine: Engine,
    /// Whom to tell, and when to stop.
    pub run: Run,
}

/// A file beside the mesh.
pub struct Beside {
    /// What it is for.
    pub role: InputRole,
    /// Its name, as the client gave it.
    pub name: String,
    /// The file.
    pub bytes: Bytes,
}

/// How the call ended.
pub enum Outcome {
    /// With a result.
    Done(Box<Unwrapped>),
    /// With an error.
    Failed(JobError),
    /// It was asked to stop, and did.
    Canceled,
    /// It panicked: a driver, or a mistake of ours. The process is not to be trusted any more.
    Panicked(String),
}

/// Begin the call. The thread is left to itself if nobody waits for the answer.
pub fn start(call: Call) -> io::Result<oneshot::Receiver<Outcome>> {
    let (answer, outcome) = oneshot::channel();
    let thread = std::thread::Builder::new().name("pipeline".into()).stack_size(STACK);
    thread.spawn(move || {
        let ended = catch_unwind(AssertUnwindSafe(|| unwrap(&call)));
        let ended = ended.unwrap_or_else(|panic| Outcome::Panicked(message_of(&*panic)));
        // Nobody waits any more: the attempt was given up.
        let _ = answer.send(ended);
    })?;
    Ok(outcome)
}

fn unwrap(call: &Call) -> Outcome {
    let beside = call.beside.iter().map(|Beside { role, name, bytes }| InputFile {
        role: *role,
        name,
        bytes,
    });
    let input = Input::new(call.kind, &call.mesh).with(beside);
    match unwrap_input(&input, &call.options, &call.limits, &call.engine, &call.run) {
        Ok(unwrapped) => Outcome::Done(Box::new(unwrapped)),
        Err(error) => match error.job_error() {
            Some(error) => Outcome::Failed(error),
            None => Outcome::Canceled,
        },
    }
}

fn message_of(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or(panic.downcast_ref::<&str>().copied()).unwrap_or("without a message").to_string()
}
