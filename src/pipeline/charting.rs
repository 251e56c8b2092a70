//! The cut, and `max_charts`: where there are more charts than asked for, the distortion bound is
//! raised step by step. Validity comes first: the aim may be missed, and then a warning says so.

use super::engine::Engine;
use super::error::Cause;
use super::joint;
use super::parts::Solvers;
use crate::charts::{self, Arms, Chart, ChartOptions};
use crate::contract::{
    GaveUp, JointSeams, Quality, Run, Scarce, Stage, UnwrapOptions, WarningCode,
};

/// Times that the bound may be raised.
const ROUNDS: u32 = 5;

/// By how much, each time.
const RAISE: f64 = 3.0;

/// The charts, and what training their seams was worth, where it was tried.
pub struct Cut {
    /// The charts.
    pub charts: Vec<Chart>,
    /// How the two ways of joining compared.
    pub joint_seams: Option<JointSeams>,
}

/// Cut the parts into charts. `Chart::part` is the region's number here.
pub fn cut(
    solvers: &Solvers,
    options: &UnwrapOptions,
    engine: &Engine,
    run: &Run,
) -> Result<Cut, Cause> {
    run.stage(Stage::Charts)?;
    let mut how = ChartOptions::from(options);
    // Seams are trained once: a second training would find the time of the first spent.
    let openness = match options.quality {
        Quality::Best if run.is_late(Stage::Segment) => {
            run.give_up(Stage::Charts, GaveUp::JointSeams, Scarce::Time);
            None
        }
        Quality::Best => Some(joint::openness(solvers, &how, options, engine, run)?),
        _ => None,
    };
    let mut cut = attempt(solvers, &how, openness.as_deref(), run)?;
    let Some(most) = options.max_charts.map(|m| m as usize) else { return Ok(cut) };
    for _ in 0..ROUNDS {
        if cut.charts.len() <= most {
            return Ok(cut);
        }
        if run.is_late(Stage::Charts) {
            run.give_up(Stage::Charts, GaveUp::Joining, Scarce::Time);
            break;
        }
        how.distortion_bound *= RAISE;
        let fewer = attempt(solvers, &how, openness.as_deref(), run)?;
        if fewer.charts.len() < cut.charts.len() {
            cut = fewer;
        }
    }
    if cut.charts.len() > most {
        let message = format!(
            "the object needs {} charts and max_charts is {most}: each disconnected part needs one",
            cut.charts.len()
        );
        run.warn(WarningCode::MaxChartsMissed, message);
    }
    Ok(cut)
}

/// One cut; `openness` is what soft maps have left open, where seams were trained.
fn attempt(
    solvers: &Solvers,
    how: &ChartOptions,
    openness: Option<&[f32]>,
    run: &Run,
) -> Result<Cut, Cause> {
    let (surface, regions) = (&solvers.surface, &solvers.regions.of_face);
    let built = charts::build_jointly(surface, regions, how, openness, run)?;
    let joint_seams = openness.map(|_| {
        let kept = |arms: &&Arms| arms.joint < arms.control;
        let sum = |of: fn(&Arms) -> f64| built.arms.iter().map(of).sum::<f64>();
        let (control, best) = (sum(|a| a.control), sum(|a| a.control.min(a.joint)));
        JointSeams {
            pieces: built.arms.len() as u32,
            kept: built.arms.iter().filter(kept).count() as u32,
            gain: (control > 0.0).then(|| (control - best) / control),
        }
    });
    Ok(Cut { charts: built.charts, joint_seams })
}
