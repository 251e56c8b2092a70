//! The cut, and `max_charts`: where there are more charts than asked for, the distortion bound is
//! raised step by step. Validity comes first: the aim may be missed, and then a warning says so.

use super::clock::Clock;
use super::error::UnwrapError;
use super::joint;
use super::parts::Found;
use crate::charts::{self, Arms, Chart, ChartOptions};
use crate::contract::{JointSeams, Quality, Run, Stage, UnwrapOptions};
use crate::device::Device;

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
pub fn charts(
    found: &Found,
    options: &UnwrapOptions,
    device: &Device,
    run: &Run,
    clock: &mut Clock,
) -> Result<Cut, UnwrapError> {
    clock.stage(Stage::Charts, run)?;
    let mut bound = options.distortion_bound;
    // Seams are trained once: a second training would find the time of the first spent.
    let openness = match options.quality {
        Quality::Best => {
            let how = ChartOptions { distortion_bound: bound };
            Some(joint::openness(found, &how, options, device, run)?)
        }
        _ => None,
    };
    let mut cut = attempt(found, bound, openness.as_deref(), run)?;
    let Some(most) = options.max_charts.map(|m| m as usize) else { return Ok(cut) };
    for _ in 0..ROUNDS {
        if cut.charts.len() <= most {
            return Ok(cut);
        }
        bound *= RAISE;
        let fewer = attempt(found, bound, openness.as_deref(), run)?;
        if fewer.charts.len() < cut.charts.len() {
            cut = fewer;
        }
    }
    if cut.charts.len() > most {
        let message = format!(
            "the object needs {} charts and max_charts is {most}: each disconnected part needs one",
            cut.charts.len()
        );
        run.warn("max_charts_missed", message);
    }
    Ok(cut)
}

/// One cut; `openness` is what soft maps have left open, where seams were trained.
fn attempt(
    found: &Found,
    bound: f64,
    openness: Option<&[f32]>,
    run: &Run,
) -> Result<Cut, UnwrapError> {
    let how = ChartOptions { distortion_bound: bound };
    let built = charts::build_jointly(&found.surface, &found.region_of, &how, openness, run)?;
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
