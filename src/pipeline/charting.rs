//! The cut, and `max_charts`: where there are more charts than asked for, the distortion bound is
//! raised step by step. Validity comes first: the aim may be missed, and then a warning says so.

use super::engine::Engine;
use super::error::Cause;
use super::joint;
use super::parts::Solvers;
use crate::charts::{self, Chart, ChartOptions, Orders};
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
        if run.skips(Stage::Charts, GaveUp::Joining) {
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
        let kept = |orders: &&Orders| orders.joint < orders.baseline;
        let sum = |of: fn(&Orders) -> f64| built.orders.iter().map(of).sum::<f64>();
        let (baseline, best) = (sum(|a| a.baseline), sum(|a| a.baseline.min(a.joint)));
        JointSeams {
            pieces: built.orders.len() as u32,
            kept: built.orders.iter().filter(kept).count() as u32,
            gain: (baseline > 0.0).then(|| (baseline - best) / baseline),
        }
    });
    Ok(Cut { charts: built.charts, joint_seams })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::{Degradation, Progress};
    use crate::pipeline::scenes;

    /// Hills that need several charts, and what is told of their cut.
    fn hills(max_charts: Option<u32>, run: &Run) -> Vec<Chart> {
        let text = scenes::sheet(10, |x, y| (x + 0.5 * y).sin() + (0.7 * y).cos());
        let options = UnwrapOptions { max_charts, ..scenes::options() };
        scenes::cut(&text, &options, run).2
    }

    fn warnings(told: &[Progress]) -> Vec<&str> {
        let missed = told.iter().filter_map(|p| match p {
            Progress::Warning(w) if w.code == WarningCode::MaxChartsMissed => Some(&w.message[..]),
            _ => None,
        });
        missed.collect()
    }

    #[test]
    fn fewer_charts_are_made_when_asked() {
        let (run, told) = scenes::watched();
        let free = hills(None, &run);
        assert!(free.len() >= 4, "{} charts", free.len());
        let most = free.len() / 2;
        let fewer = hills(Some(most as u32), &run);
        assert!(fewer.len() <= most, "{} charts", fewer.len());
        let faces: usize = fewer.iter().map(|c| c.faces.len()).sum();
        assert_eq!(faces, 200);
        // Who asks for no fewer than there are gets the same.
        assert_eq!(hills(Some(free.len() as u32), &run), free);
        assert!(warnings(&told.lock().unwrap()).is_empty());
    }

    #[test]
    fn an_aim_that_cannot_be_met_is_told() {
        let (run, told) = scenes::watched();
        let options = UnwrapOptions { max_charts: Some(2), ..scenes::options() };
        let (_, _, charts) = scenes::cut(&scenes::squares(3), &options, &run);
        assert_eq!(charts.len(), 3);
        let told = told.lock().unwrap();
        let [said] = warnings(&told)[..] else { panic!("{told:?}") };
        assert!(said.contains("needs 3 charts") && said.contains("max_charts is 2"), "{said}");
    }

    #[test]
    fn without_time_seams_are_not_trained() {
        let run = scenes::late(30);
        let (_, solvers) = scenes::found(scenes::CUBE, &scenes::options(), &run);
        let options = UnwrapOptions { quality: Quality::Best, ..scenes::options() };
        let cut = cut(&solvers, &options, &scenes::engine(), &run).unwrap();
        assert_eq!(cut.joint_seams, None);
        let seams =
            Degradation { stage: Stage::Charts, gave_up: GaveUp::JointSeams, scarce: Scarce::Time };
        assert_eq!(run.budget.degraded(), [seams]);
    }

    #[test]
    fn an_order_that_changes_nothing_gains_nothing() {
        let run = Run::quiet();
        let (_, solvers) = scenes::found(scenes::CUBE, &scenes::options(), &run);
        let how = ChartOptions::from(&scenes::options());
        let baseline = attempt(&solvers, &how, None, &run).unwrap();
        assert_eq!(baseline.joint_seams, None);
        // All edges alike, and nothing known of any.
        for (open, pieces, gain) in [(0.5, 1, Some(0.0)), (f32::NAN, 0, None)] {
            let openness = vec![open; solvers.surface.twin.len()];
            let cut = attempt(&solvers, &how, Some(&openness), &run).unwrap();
            assert_eq!(cut.joint_seams, Some(JointSeams { pieces, kept: 0, gain }));
            assert_eq!(cut.charts, baseline.charts);
        }
    }

    #[test]
    fn seams_are_trained_with_the_best_quality_alone() {
        let run = Run::quiet();
        // A cube, and two squares that leave nothing to choose.
        let text = scenes::and_a_cube(&scenes::squares(2), 8);
        let (_, solvers) = scenes::found(&text, &scenes::options(), &run);
        let with = |quality| {
            let options = UnwrapOptions { quality, steps: 2, ..scenes::options() };
            cut(&solvers, &options, &scenes::engine(), &run).unwrap().joint_seams
        };
        assert_eq!(with(Quality::Balanced), None);
        assert_eq!(with(Quality::Best).map(|seams| seams.pieces), Some(1));
    }
}
