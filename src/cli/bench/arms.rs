//! `uvsegnet bench quality --arms`: every way to the maps of each object's charts, one JSON line a chart, and
//! which way is best, as means over the area.

use std::fs::File;
use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result};
use serde_json::json;

use super::files::{guarded, stem};
use crate::cli::input::{Beside, Files};
use crate::contract::{Limits, NeuralGain, Run, UnwrapOptions};
use crate::mesh;
use crate::pipeline::{self, Engine, Ways};

/// A way must win by this much.
const MARGIN: f64 = 1e-6;

/// A way: its name and its energy.
type Way = (&'static str, fn(&NeuralGain) -> Option<f64>);

const WAYS: [Way; 6] = [
    ("carried over", |g| g.prolonged),
    ("carried over, polished", |g| g.prolonged_polish),
    ("network", |g| g.net),
    ("network, polished", |g| g.net_polish),
    ("classical", |g| g.start),
    ("classical, polished", |g| g.start_polish),
];

/// Run it.
pub fn run(
    objects: impl Iterator<Item = PathBuf>,
    limit: Option<usize>,
    options: &UnwrapOptions,
    engine: &Engine,
    mut lines: File,
) -> Result<()> {
    let mut all: Vec<Ways> = Vec::new();
    println!("| object | charts | network ahead | classical ahead | most gained by the network |");
    println!("|---|---|---|---|---|");
    for path in objects.take(limit.unwrap_or(usize::MAX)) {
        let name = stem(&path);
        let made = guarded(|| {
            let files = Files::read(&path, &Beside::default())?;
            let input = files.input();
            let scene = mesh::import(input.mesh(), input.kind(), &Limits::default())?;
            Ok(pipeline::ways(&scene, options, engine, &Run::quiet())?)
        });
        match made {
            Ok(arms) => {
                for arm in &arms {
                    let line = json!({ "object": name, "area": arm.area, "ways": arm.gain });
                    writeln!(lines, "{line}").context("cannot write a line")?;
                }
                println!("| {name} | {}", row(&arms));
                all.extend(arms);
            }
            Err(error) => println!("| {name} | {error:#} | | | |"),
        }
    }
    println!("| all | {}", row(&all));
    println!("\nMean SD − 1 over the area of the charts that went this way, and how many did:\n");
    for (dense, which) in [(true, "with a proxy"), (false, "without")] {
        let own: Vec<&Ways> = all.iter().filter(|a| a.gain.prolonged.is_some() == dense).collect();
        for (name, way) in WAYS {
            let went: Vec<(f64, f64)> = own
                .iter()
                .filter_map(|a| Some((a.area, way(&a.gain).filter(|e| e.is_finite())?)))
                .collect();
            let area: f64 = went.iter().map(|w| w.0).sum();
            let mean = went.iter().map(|w| w.0 * (w.1 - 1.0)).sum::<f64>() / area;
            println!("{which}, {name}: {mean:.5} ({} of {})", went.len(), own.len());
        }
    }
    Ok(())
}

/// The best that a chart reaches without a network.
fn control(gain: &NeuralGain) -> f64 {
    [gain.prolonged_polish, gain.prolonged, gain.start_polish]
        .into_iter()
        .flatten()
        .fold(f64::INFINITY, f64::min)
}

fn row(arms: &[Ways]) -> String {
    let by_network = |a: &Ways| a.gain.net_polish.map(|net| control(&a.gain) - net);
    let ahead = arms.iter().filter(|a| by_network(a).is_some_and(|by| by > MARGIN)).count();
    let classical = arms
        .iter()
        .filter(|a| {
            let carried = a.gain.prolonged_polish;
            carried.zip(a.gain.start_polish).is_some_and(|(c, start)| start + MARGIN < c)
        })
        .count();
    let most = arms.iter().filter_map(by_network).fold(f64::NEG_INFINITY, f64::max);
    format!("{} | {ahead} | {classical} | {most:.2e} |", arms.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_are_compared_with_the_best_without_a_network() {
        let gain = |prolonged_polish, start_polish, net_polish| NeuralGain {
            prolonged_polish,
            start_polish,
            net_polish,
            ..Default::default()
        };
        let arms = [
            gain(Some(1.02), Some(1.03), Some(1.01)),
            gain(Some(1.02), Some(1.01), Some(1.015)),
            gain(None, Some(1.01), None),
        ];
        let arms = arms.map(|gain| Ways { area: 1.0, gain });
        assert_eq!(row(&arms), "3 | 1 | 1 | 1.00e-2 |");
    }
}
