//! From parts to an atlas. With `quality = best` by three ways, since more work may lead to charts that are
//! less distorted and fill a page worse: never is the result worse than that of `balanced` in the objective
//! of the charts or in the share of the page that is covered.

use super::charting::{self, Cut};
use super::engine::Engine;
use super::error::Cause;
use super::finish::{self, CertifiedAtlas};
use super::maps::{self, Mapped};
use super::parts::{Found, Solvers};
use crate::charts;
use crate::contract::{GaveUp, JointSeams, Quality, Run, Scarce, Stage, StopAfter, UnwrapOptions};
use crate::flatten::{self, UvMap};
use crate::mesh::Surface;

/// Cut, map, pack and certify. Says what training the seams was worth, where it was tried.
pub fn atlas(
    found: &Found,
    solvers: &Solvers,
    options: &UnwrapOptions,
    engine: &Engine,
    run: &Run,
) -> Result<(CertifiedAtlas, Option<JointSeams>), Cause> {
    let cut = |quality| {
        let options = UnwrapOptions { quality, ..options.clone() };
        charting::cut(found, solvers, &options, engine, run)
    };
    let finish = |cut: Cut, quality| {
        let options = UnwrapOptions { quality, ..options.clone() };
        let mapped = match options.stop_after {
            Some(StopAfter::Charts) => maps::untrained(cut.charts),
            _ => maps::trained(found, solvers, cut.charts, &options, engine, run)?,
        };
        finish::pack_and_certify(found, solvers, &cut.regions, mapped, &options, run)
    };
    let quality = options.quality;
    if quality != Quality::Best || options.stop_after.is_some() {
        let cut = cut(quality)?;
        let joint_seams = cut.joint_seams;
        return Ok((finish(cut, quality)?, joint_seams));
    }
    let usual = cut(Quality::Balanced)?;
    let again = usual.clone();
    let balanced = finish(usual, Quality::Balanced)?;
    if run.is_late(Stage::Charts) {
        run.give_up(Stage::Charts, GaveUp::JointSeams, Scarce::Time);
        return Ok((balanced, None));
    }
    let worth = Worth::of(solvers, &balanced, options);
    // Seams that were trained with the maps, and all charts trained.
    let trained = cut(Quality::Best)?;
    let joint_seams = trained.joint_seams;
    let best = finish(trained, Quality::Best)?;
    if Worth::of(solvers, &best, options).is_no_worse_than(&worth) {
        return Ok((best, joint_seams));
    }
    // The usual seams, and all charts trained; or the usual result.
    let joint_seams = joint_seams.map(|seams| JointSeams { kept: 0, gain: Some(0.0), ..seams });
    let best = finish(again, Quality::Best)?;
    let is_better = Worth::of(solvers, &best, options).is_no_worse_than(&worth);
    Ok((if is_better { best } else { balanced }, joint_seams))
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
    fn of(solvers: &Solvers, atlas: &CertifiedAtlas, options: &UnwrapOptions) -> Self {
        let area = |(m, uv): (&Mapped, &UvMap)| -> f64 {
            let disk = &m.chart.disk;
            (0..disk.triangles.len()).map(|f| disk.uv_area(f, uv)).sum()
        };
        let covered: f64 = atlas.charts.iter().zip(&atlas.uvs).map(area).sum();
        Self {
            objective: objective(&solvers.surface, atlas, options),
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
                let (atlas, seams) =
                    atlas(&found, &solvers, &options, &scenes::engine(), &run).unwrap();
                (Worth::of(&solvers, &atlas, &options), seams)
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
        let (_, seams) = atlas(&found, &solvers, &options, &scenes::engine(), &run).unwrap();
        assert_eq!(seams, None);
        assert!(run.budget.degraded().iter().any(|d| d.gave_up == GaveUp::JointSeams));
    }
}
