//! A run recorded on one thread, and what many threads would take for it.

use anyhow::Result;
use serde::{Deserialize, Serialize};

use crate::cli::input::Files;
use crate::contract::{Budget, Cancel, Limits, Progress, Run, UnwrapOptions};
use crate::pipeline::{self, Engine};
use crate::tasks::{self, Schedule};

/// Threads whose seconds are told.
pub const THREADS: [usize; 5] = [1, 2, 4, 16, 64];

/// Links of the longest chain that are told.
const LINKS: usize = 10;

/// Work, span and schedules of a whole run, or of a stage of it, s.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Span {
    pub name: String,
    pub work: f64,
    pub span: f64,
    /// Seconds on each of [`THREADS`].
    pub on: Vec<f64>,
}

impl Span {
    /// Seconds to expect of so many threads.
    pub fn expected(&self, threads: usize) -> Option<f64> {
        let at = THREADS.iter().position(|&t| t == threads)?;
        self.on.get(at).copied()
    }
}

/// A part of the longest chain, s.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Link {
    pub name: String,
    pub chain: f64,
    pub work: f64,
}

/// What was recorded of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    pub whole: Span,
    pub stages: Vec<Span>,
    pub links: Vec<Link>,
}

/// Record a run, in a pool of one thread.
pub fn record(files: &Files, options: &UnwrapOptions, engine: &Engine) -> Result<Plan> {
    let tell = |progress| {
        if let Progress::Stage { stage } = progress {
            tasks::mark(stage.as_str());
        }
    };
    let run = Run::new(tell, Cancel::default(), Budget::default());
    let unwrap =
        || pipeline::unwrap_input(&files.input(), options, &Limits::default(), engine, &run);
    let (made, recorded) = tasks::record(unwrap);
    made?;
    let of = |(name, pieces): (&str, Vec<Schedule>)| Span::of(name, &pieces);
    let links = recorded.schedule().links().into_iter().take(LINKS);
    let link = |l: tasks::Link| Link { name: l.name.to_owned(), chain: l.chain, work: l.work };
    Ok(Plan {
        whole: Span::of("all", &[recorded.schedule()]),
        stages: recorded.stages().into_iter().map(of).collect(),
        links: links.map(link).collect(),
    })
}

impl Span {
    /// Of what is done one after the other.
    fn of(name: &str, pieces: &[Schedule]) -> Self {
        let sum = |of: &dyn Fn(&Schedule<'_>) -> f64| -> f64 { pieces.iter().map(of).sum() };
        Self {
            name: name.to_owned(),
            work: sum(&|s| s.work()),
            span: sum(&|s| s.span()),
            on: THREADS.map(|threads| sum(&|s| s.on(threads))).to_vec(),
        }
    }
}
