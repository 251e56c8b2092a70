//! `uvsegnet bench progress`: how far the fraction that a job tells lies from the share of its time that
//! has gone, and what a person who reads the time left from it is told wrong.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Instant;

use anyhow::{Context, Result};

use super::files::{Shard, guarded, stem};
use super::options::BenchOptions;
use crate::cli::input::{Beside, Files};
use crate::contract::{Budget, Cancel, Limits, MeshKind, Progress, Run, UnwrapOptions};
use crate::pipeline::{self, Engine};

/// Moments of a job at which it is asked, evenly apart.
const MOMENTS: usize = 200;

/// Arguments of `uvsegnet bench progress`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of meshes, searched to the bottom.
    #[arg(help = format!("Folder of meshes ({}), searched to the bottom", MeshKind::names()))]
    pub dir: PathBuf,
    /// Only the I-th of N shares of the folder.
    #[arg(long, default_value = "0/1", value_name = "I/N")]
    pub shard: Shard,
    #[command(flatten)]
    pub bench: BenchOptions,
}

/// Run it: a line an object, and the medians.
pub fn run(args: Args) -> Result<()> {
    let engine = args.bench.engine()?;
    println!("| object | seconds | off, mean | off, most | time left wrong by, half time |");
    println!("|---|---|---|---|---|");
    let mut all: Vec<Error> = Vec::new();
    for path in args.shard.of(&args.dir)? {
        match guarded(|| watch(&path, &args.bench.options, &engine)) {
            Ok((seconds, error)) => {
                println!("| {} | {seconds:.1} | {error} |", stem(&path));
                all.push(error);
            }
            Err(error) => println!("| {} | {error:#} | | | |", stem(&path)),
        }
    }
    let median = |of: fn(&Error) -> f64| {
        let mut values: Vec<f64> = all.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
    };
    let median =
        Error { mean: median(|e| e.mean), most: median(|e| e.most), left: median(|e| e.left) };
    println!("| median of {} | | {median} |", all.len());
    Ok(())
}

/// How wrong the fraction of one job was, as shares of its time.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Error {
    /// Mean of |fraction − share of the time|.
    mean: f64,
    /// The most.
    most: f64,
    /// |time left as the fraction has it − time left| at half time, over the time of the job: the time left
    /// is the time gone times (1 − fraction)/fraction.
    left: f64,
}

impl std::fmt::Display for Error {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { mean, most, left } = self;
        write!(f, "{:.0} % | {:.0} % | {:.0} %", 100.0 * mean, 100.0 * most, 100.0 * left)
    }
}

impl Error {
    /// Of what was told, (seconds, fraction) each in order of time, and the seconds of the whole job.
    fn of(told: &[(f64, f64)], whole: f64) -> Self {
        let fraction = |at: f64| {
            let told = told.iter().rev().find(|t| t.0 <= at * whole);
            told.map_or(0.0, |t| t.1)
        };
        let off = |at: f64| (fraction(at) - at).abs();
        let moments = || (0..MOMENTS).map(|i| (i as f64 + 0.5) / MOMENTS as f64);
        let half = fraction(0.5).max(f64::EPSILON);
        Self {
            mean: moments().map(off).sum::<f64>() / MOMENTS as f64,
            most: moments().map(off).fold(0.0, f64::max),
            left: (0.5 * (1.0 - half) / half - 0.5).abs(),
        }
    }
}

/// Unwrap an object and listen: its seconds, and how wrong it was.
fn watch(path: &Path, options: &UnwrapOptions, engine: &Engine) -> Result<(f64, Error)> {
    let files = Files::read(path, &Beside::default())?;
    let told = Arc::new(Mutex::new(Vec::new()));
    let (heard, begun) = (told.clone(), Instant::now());
    let listen = move |progress: Progress| {
        if let (Progress::Progress { fraction, .. }, Ok(mut heard)) = (progress, heard.lock()) {
            heard.push((begun.elapsed().as_secs_f64(), fraction));
        }
    };
    let budget = Budget::new(options.budget_s, options.budget_mib);
    let run = Run::new(listen, Cancel::default(), budget);
    pipeline::unwrap_input(&files.input(), options, &Limits::default(), engine, &run)?;
    let whole = begun.elapsed().as_secs_f64();
    let told = told.lock().ok().context("a listener failed")?;
    Ok((whole, Error::of(&told, whole)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fraction_that_goes_with_the_clock_is_right() {
        let told: Vec<_> =
            (0..=1000).map(|i| (f64::from(i) * 0.004, f64::from(i) * 0.001)).collect();
        let error = Error::of(&told, 4.0);
        assert!(error.most < 0.002 && error.left < 0.005, "{error:?}");
    }

    /// A quarter when half is over, and all the rest at the end.
    #[test]
    fn a_fraction_that_lags_is_as_wrong_as_it_lags() {
        let error = Error::of(&[(0.0, 0.25)], 1.0);
        assert!((error.most - 0.75).abs() < 0.01, "{error:?}");
        // Half of the time is left; a quarter done would leave three times what has gone.
        assert!((error.left - 1.0).abs() < 1e-12, "{error:?}");
        assert!((error.mean - 0.3125).abs() < 1e-3, "{error:?}");
    }
}
