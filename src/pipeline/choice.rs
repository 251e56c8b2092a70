//! From parts to an atlas. With `quality = best` by three ways, since more work may lead to charts that are
//! less distorted and fill a page worse: never is the result worse than that of `balanced` in the objective
//! of the charts or in the share of the page that is covered.

use super::charting::{self, Cut};
use super::delivery;
use super::engine::Engine;
use super::error::Cause;
use super::finish::{self, CertifiedAtlas};
use super::maps::{self, Mapped};
use super::parts::{Found, Solvers};
use crate::charts;
use crate::contract::{
    GaveUp, JointSeams, Quality, Run, Scarce, Stage, StopAfter, UnwrapOptions, WarningCode,
};
use crate::flatten::{self, UvMap};
use crate::mesh::Surface;

/// An atlas, and how it was come by.
pub struct Made {
    /// The sides that it is of.
    pub found: Found,
    /// The atlas.
    pub atlas: CertifiedAtlas,
    /// What training the seams was worth, where it was tried.
    pub joint_seams: Option<JointSeams>,
    /// Why its cut has more than `max_charts`, where it has.
    missed: Option<String>,
}

/// Cut, map, pack and certify. Tells where there are more charts than were asked for.
pub fn atlas(
    found: &Found,
    solvers: &Solvers,
    options: &UnwrapOptions,
    engine: &Engine,
    run: &Run,
) -> Result<Made, Cause> {
    let made = best_of(found, solvers, options, engine, run)?;
    let charts = made.atlas.charts.len();
    if let Some(most) = options.max_charts.filter(|&most| charts > most as usize) {
        let divided = "some had to be divided so that their coordinates are valid";
        let reason = made.missed.as_deref().unwrap_or(divided);
        let message = format!("there are {charts} charts and `max_charts` is {most}: {reason}");
        run.warn(WarningCode::MaxChartsMissed, message);
    }
    Ok(made)
}

fn best_of(
    found: &Found,
    solvers: &Solvers,
    options: &UnwrapOptions,
    engine: &Engine,
    run: &Run,
) -> Result<Made, Cause> {
    let cut = |quality| {
        let options = UnwrapOptions { quality, ..options.clone() };
        let cut = charting::cut(found, solvers, &options, engine, run)?;
        let charts = solvers.refined(cut.charts, found, &options, run)?;
        Ok::<_, Cause>(Cut { charts, ..cut })
    };
    let finish = |cut: Cut, quality| {
        let options = UnwrapOptions { quality, ..options.clone() };
        let Cut { charts, regions, joint_seams, missed } = cut;
        let mapped = match options.stop_after {
            Some(StopAfter::Charts) => maps::untrained(charts),
            _ => maps::trained(found, solvers, charts, &options, engine, run)?,
        };
        let (found, mapped) = delivery::deliver(found, mapped, &options, run)?;
        let atlas = finish::pack_and_certify(&found, &regions, mapped, &options, run)?;
        Ok::<_, Cause>(Made { found, atlas, joint_seams, missed })
    };
    let quality = options.quality;
    if quality != Quality::Best || options.stop_after.is_some() {
        return finish(cut(quality)?, quality);
    }
    let usual = cut(Quality::Balanced)?;
    let balanced = finish(usual.clone(), Quality::Balanced)?;
    if run.is_late(Stage::Charts) {
        run.give_up(Stage::Charts, GaveUp::JointSeams, Scarce::Time);
        return Ok(balanced);
    }
    let worth = Worth::of(&balanced, options);
    let is_no_worse = |made: &Made| Worth::of(made, options).is_no_worse_than(&worth);
    // Seams that were trained with the maps, and all charts trained …
    let best = finish(cut(Quality::Best)?, Quality::Best)?;
    if is_no_worse(&best) {
        return Ok(best);
    }
    // … the usual seams, and all charts trained; or the usual result. Trained seams gained nothing then.
    let joint_seams = best.joint_seams.map(|seams| JointSeams {
        kept: 0,
        gain: seams.gain.map(|_| 0.0),
        ..seams
    });
    let again = finish(usual, Quality::Best)?;
    let made = if is_no_worse(&again) { again } else { balanced };
    Ok(Made { joint_seams, ..made })
}

/// The objective of an atlas's charts.
pub fn objective(surface: &Surface, atlas: &CertifiedAtlas, options: &UnwrapOptions) -> f64 {
    let energy = |m: &Mapped| flatten::quality(&m.chart.disk, &m.uv).mean;
    let charts: Vec<_> = atlas.charts.iter().map(|m| (&m.chart, energy(m))).collect();
    charts::objective(surface, &charts, options.distortion_bound)
}

/// What an atlas is judged by.
struct Worth {
    /// The objective of its charts.
    objective: f64,
    /// Share of its pages that charts cover.
    covered: f64,
}

impl Worth {
    fn of(made: &Made, options: &UnwrapOptions) -> Self {
        let Made { found, atlas, .. } = made;
        let area = |(m, uv): (&Mapped, &UvMap)| -> f64 {
            let disk = &m.chart.disk;
            (0..disk.triangles.len()).map(|f| disk.uv_area(f, uv)).sum()
        };
        let covered: f64 = atlas.charts.iter().zip(&atlas.uvs).map(area).sum();
        Self {
            objective: objective(&found.surface, atlas, options),
            covered: covered / f64::from(atlas.pages.max(1)),
        }
    }

    fn is_no_worse_than(&self, other: &Self) -> bool {
        self.objective <= other.objective && self.covered >= other.covered
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::scenes;

    #[test]
    fn the_best_is_never_worse_than_the_balanced() {
        let texts = [
            scenes::CUBE.to_owned(),
            scenes::sphere(8),
            scenes::sheet(8, |x, y| (x + 0.5 * y).sin()),
            scenes::and_a_cube(&scenes::squares(2), 8),
        ];
        for text in texts {
            let run = Run::quiet();
            let (found, solvers) = scenes::found(&text, &scenes::options(), &run);
            let by = |quality| {
                let options = UnwrapOptions { quality, steps: 10, ..scenes::options() };
                let made = atlas(&found, &solvers, &options, &scenes::engine(), &run).unwrap();
                (Worth::of(&made, &options), made.joint_seams)
            };
            let ((best, seams), (balanced, none)) = (by(Quality::Best), by(Quality::Balanced));
            assert!(best.is_no_worse_than(&balanced));
            assert!(seams.is_some() && none.is_none());
        }
    }

    #[test]
    fn without_time_the_best_is_the_balanced() {
        let run = scenes::late(52);
        let (found, solvers) = scenes::found(scenes::CUBE, &scenes::options(), &run);
        let options = UnwrapOptions { quality: Quality::Best, ..scenes::options() };
        let made = atlas(&found, &solvers, &options, &scenes::engine(), &run).unwrap();
        assert_eq!(made.joint_seams, None);
        assert!(run.budget.degraded().iter().any(|d| d.gave_up == GaveUp::JointSeams));
    }

    #[test]
    fn what_is_told_of_the_aim_is_so_of_what_ships() {
        for quality in [Quality::Fast, Quality::Best] {
            let run = Run::quiet();
            let options = UnwrapOptions { quality, max_charts: Some(2), ..scenes::options() };
            let (found, solvers) = scenes::found(&scenes::squares(3), &options, &run);
            let made = atlas(&found, &solvers, &options, &scenes::engine(), &run).unwrap();
            assert_eq!(made.atlas.charts.len(), 3);
            let told = run.warnings();
            let [said] = &told[..] else { panic!("{told:?}") };
            let why =
                "there are 3 charts and `max_charts` is 2: 3 pieces of the mesh share no edge";
            assert!(said.message.starts_with(why), "{said:?}");
        }
        // An aim that is met is not told.
        let run = Run::quiet();
        let options = UnwrapOptions { max_charts: Some(3), ..scenes::options() };
        let (found, solvers) = scenes::found(&scenes::squares(3), &options, &run);
        atlas(&found, &solvers, &options, &scenes::engine(), &run).unwrap();
        assert!(run.warnings().is_empty());
    }
}
