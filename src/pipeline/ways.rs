//! What each way to a chart's map reaches on the charts of an object: what decides where training pays. Charts
//! are cut as ever and each is trained, whether or not a job would.

use super::charting::{self, Cut};
use super::engine::Engine;
use super::error::{Cause, UnwrapError};
use super::{maps, parts};
use crate::contract::{NeuralGain, Quality, Run, UnwrapOptions};
use crate::mesh::Scene;

/// The ways of one chart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ways {
    /// Area of the chart, world units squared.
    pub area: f64,
    /// What each way reached.
    pub gain: NeuralGain,
}

/// The ways of every chart that bends.
pub fn ways(
    scene: &Scene,
    options: &UnwrapOptions,
    engine: &Engine,
    run: &Run,
) -> Result<Vec<Ways>, UnwrapError> {
    let whole = || {
        let usual = UnwrapOptions { quality: Quality::Balanced, ..options.clone() };
        let (found, solvers) = parts::find(scene, &usual, engine, run)?;
        let Cut { charts, .. } = charting::cut(&found, &solvers, &usual, engine, run)?;
        let charts = solvers.refined(charts, &found, &usual, run)?;
        let best = UnwrapOptions { quality: Quality::Best, ..options.clone() };
        let mapped = maps::trained(&found, &solvers, charts, &best, engine, run)?;
        let of = |m: &maps::Mapped| Some(Ways { area: m.chart.disk.area(), gain: m.gain? });
        Ok(mapped.iter().filter_map(of).collect())
    };
    whole().map_err(|cause: Cause| cause.of(run))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::scenes;

    #[test]
    fn every_chart_that_bends_goes_each_way() {
        let scene = scenes::scene(&scenes::sphere(8));
        let options = UnwrapOptions { steps: 5, ..scenes::options() };
        let ways = ways(&scene, &options, &scenes::engine(), &Run::quiet()).unwrap();
        assert!(!ways.is_empty());
        for Ways { area, gain } in ways {
            assert!(area > 0.0 && gain.net.is_some());
            assert!(gain.start_polish.unwrap() <= gain.start.unwrap());
            // Too small for a proxy.
            assert_eq!((gain.prolonged, gain.prolonged_polish), (None, None));
        }
    }
}
