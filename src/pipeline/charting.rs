//! The cut, and `max_charts`: where there are more charts than asked for, the distortion bound is
//! raised step by step. Validity comes first: the aim may be missed, and then a warning says so.

use super::clock::Clock;
use super::error::UnwrapError;
use super::parts::Found;
use crate::charts::{self, Chart, ChartOptions};
use crate::contract::{Run, Stage, UnwrapOptions};

/// Times that the bound may be raised.
const ROUNDS: u32 = 5;

/// By how much, each time.
const RAISE: f64 = 3.0;

/// Cut the parts into charts. `Chart::part` is the region's number here.
pub fn charts(
    found: &Found,
    options: &UnwrapOptions,
    run: &Run,
    clock: &mut Clock,
) -> Result<Vec<Chart>, UnwrapError> {
    clock.stage(Stage::Charts, run)?;
    let mut bound = options.distortion_bound;
    let mut charts = cut(found, bound, run)?;
    let Some(most) = options.max_charts.map(|m| m as usize) else { return Ok(charts) };
    for _ in 0..ROUNDS {
        if charts.len() <= most {
            return Ok(charts);
        }
        bound *= RAISE;
        let fewer = cut(found, bound, run)?;
        if fewer.len() < charts.len() {
            charts = fewer;
        }
    }
    if charts.len() > most {
        let message = format!(
            "the object needs {} charts and max_charts is {most}: each disconnected part needs one",
            charts.len()
        );
        run.warn("max_charts_missed", message);
    }
    Ok(charts)
}

fn cut(found: &Found, bound: f64, run: &Run) -> Result<Vec<Chart>, UnwrapError> {
    let options = ChartOptions { distortion_bound: bound };
    Ok(charts::build(&found.surface, &found.region_of, &options, run)?)
}
