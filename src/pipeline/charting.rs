//! The cut, and `max_charts`: where there are more charts than asked for, first the borders give way that
//! only the network or the geometry draws between parts, the least certain first; then the distortion
//! bound is raised step by step. Validity comes first: the aim may be missed, and then a warning says why.

use super::engine::Engine;
use super::error::Cause;
use super::joint;
use super::parts::{Found, Solvers};
use super::regions::{self, Regions};
use super::soft_borders::soft_borders;
use crate::charts::{self, Chart, ChartOptions, Orders};
use crate::contract::{GaveUp, JointSeams, Quality, Run, Scarce, Stage, UnwrapOptions};
use crate::mesh::{DisjointSets, NONE, Surface};

/// Times that the bound may be raised, and that the number of borders which give way is halved.
const ROUNDS: u32 = 5;

/// By how much the bound is raised, each time.
const RAISE: f64 = 3.0;

/// The charts, and what training their seams was worth, where it was tried.
#[derive(Debug, Clone)]
pub struct Cut {
    /// The charts. `Chart::part` is the region's number.
    pub charts: Vec<Chart>,
    /// What they do not cross.
    pub regions: Regions,
    /// How the two ways of joining compared.
    pub joint_seams: Option<JointSeams>,
    /// Why there are more than `max_charts`, where it is so.
    pub missed: Option<String>,
}

/// Cut the parts into charts.
pub fn cut(
    found: &Found,
    solvers: &Solvers,
    options: &UnwrapOptions,
    engine: &Engine,
    run: &Run,
) -> Result<Cut, Cause> {
    run.stage(Stage::Charts)?;
    let how = ChartOptions { pinches: solvers.proxy.is_none(), ..options.into() };
    let segmented = solvers.segmented();
    let regions = regions::divide(found, &segmented, options.atlas)
        .joined(found, &soft_borders(found, &segmented));
    // Seams are trained once: a second training would find the time of the first spent.
    let openness = match options.quality {
        Quality::Best if run.is_late(Stage::Segment) => {
            run.give_up(Stage::Charts, GaveUp::JointSeams, Scarce::Time);
            None
        }
        Quality::Best => {
            Some(joint::openness(solvers, &regions.of_face, &how, options, engine, run)?)
        }
        _ => None,
    };
    let cutter = Cutter { solvers, openness: openness.as_deref(), run };
    let first = cutter.cut(&regions, &how)?;
    match options.max_charts.map(|most| most as usize) {
        Some(most) if first.charts.len() > most => cutter.fewer(found, first, how, most),
        _ => Ok(first),
    }
}

/// What every attempt has in common.
struct Cutter<'a> {
    solvers: &'a Solvers,
    /// What soft maps have left open, where seams were trained.
    openness: Option<&'a [f32]>,
    run: &'a Run,
}

impl Cutter<'_> {
    fn cut(&self, regions: &Regions, how: &ChartOptions) -> Result<Cut, Cause> {
        let surface = &self.solvers.surface;
        let built = charts::build_jointly(surface, &regions.of_face, how, self.openness, self.run)?;
        let joint_seams = self.openness.map(|_| {
            let kept = |orders: &&Orders| orders.joint < orders.baseline;
            let sum = |of: fn(&Orders) -> f64| built.orders.iter().map(of).sum::<f64>();
            let (baseline, best) = (sum(|a| a.baseline), sum(|a| a.baseline.min(a.joint)));
            JointSeams {
                pieces: built.orders.len() as u32,
                kept: built.orders.iter().filter(kept).count() as u32,
                gain: (baseline > 0.0).then(|| (baseline - best) / baseline),
            }
        });
        Ok(Cut { charts: built.charts, regions: regions.clone(), joint_seams, missed: None })
    }

    /// At most `most` charts, or as few as can be.
    fn fewer(
        &self,
        found: &Found,
        first: Cut,
        mut how: ChartOptions,
        most: usize,
    ) -> Result<Cut, Cause> {
        let late = || self.run.skips(Stage::Charts, GaveUp::Joining);
        let joins = regions::giving_way(found);
        let (mut none, mut all) = (0, joins.len());
        let parts = first.regions.clone();
        let mut best = first;
        if all > 0 && !late() {
            let without = self.cut(&parts.joined(found, &joins), &how)?;
            if without.charts.len() <= most {
                // As many borders stay as can: fewer than `none` joins are too few, `all` are enough.
                best = without;
                for _ in 0..ROUNDS {
                    let half = usize::midpoint(none, all);
                    if half == none || late() {
                        break;
                    }
                    let cut = self.cut(&parts.joined(found, &joins[..half]), &how)?;
                    if cut.charts.len() <= most {
                        (all, best) = (half, cut);
                    } else {
                        none = half;
                    }
                }
                return Ok(best);
            }
            if without.charts.len() < best.charts.len() {
                best = without;
            }
        }
        let mut stopped = false;
        for _ in 0..ROUNDS {
            if late() {
                stopped = true;
                break;
            }
            how.distortion_bound *= RAISE;
            let fewer = self.cut(&best.regions, &how)?;
            if fewer.charts.len() < best.charts.len() {
                best = fewer;
            }
            if best.charts.len() <= most {
                return Ok(best);
            }
        }
        let missed = match stopped {
            true => "the job's time was too short to look for fewer".to_owned(),
            false => {
                let least = parts.joined(found, &joins);
                why_no_fewer(&self.solvers.surface, &least, how.distortion_bound, most)
            }
        };
        Ok(Cut { missed: Some(missed), ..best })
    }
}

/// Why there are no fewer charts. `regions`: what is left where all borders that may give way did.
fn why_no_fewer(surface: &Surface, regions: &Regions, bound: f64, most: usize) -> String {
    let pieces = |divided: bool| {
        let of = |f: u32| regions.of_face[f as usize];
        let mut sets = DisjointSets::new(surface.face_count());
        for (h, &t) in (0u32..).zip(&surface.twin).filter(|(_, t)| **t != NONE) {
            let (f, g) = (h / 3, t / 3);
            if of(f) != NONE && of(g) != NONE && (!divided || of(f) == of(g)) {
                sets.join(f, g);
            }
        }
        let faces = 0..surface.face_count() as u32;
        faces.filter(|&f| of(f) != NONE && sets.root(f) == f).count()
    };
    let (apart, divided) = (pieces(false), pieces(true));
    if apart > most {
        format!("{apart} pieces of the mesh share no edge, and each needs a chart of its own")
    } else if divided > most {
        format!(
            "labels, the file's structure, materials or densities divide it into {divided} pieces, and each \
             needs a chart of its own"
        )
    } else {
        format!(
            "it does not open into so few without overlap, or within a `distortion_bound` of {bound:.3}, up to \
             which it was raised"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::{AtlasGrouping, Degradation, PartJoin, SegmentationSource};
    use crate::pipeline::scenes;
    use crate::segmentation::{Part, PartLabels};

    /// The cut of hills that need several charts.
    fn hills(max_charts: Option<u32>) -> Cut {
        let text = scenes::sheet(10, |x, y| (x + 0.5 * y).sin() + (0.7 * y).cos());
        let options = UnwrapOptions { max_charts, ..scenes::options() };
        scenes::cut(&text, &options, &Run::quiet()).2
    }

    #[test]
    fn fewer_charts_are_made_when_asked() {
        let free = hills(None);
        assert!(free.charts.len() >= 4, "{} charts", free.charts.len());
        let most = free.charts.len() / 2;
        let fewer = hills(Some(most as u32));
        assert!(fewer.charts.len() <= most, "{} charts", fewer.charts.len());
        let faces: usize = fewer.charts.iter().map(|c| c.faces.len()).sum();
        assert_eq!(faces, 200);
        // Who asks for no fewer than there are gets the same.
        let as_many = hills(Some(free.charts.len() as u32));
        assert_eq!(as_many.charts, free.charts);
        assert!([free, fewer, as_many].iter().all(|cut| cut.missed.is_none()));
    }

    #[test]
    fn an_aim_that_cannot_be_met_has_its_reason() {
        let options = UnwrapOptions { max_charts: Some(2), ..scenes::options() };
        let (_, _, cut) = scenes::cut(&scenes::squares(3), &options, &Run::quiet());
        assert_eq!(cut.charts.len(), 3);
        let why = "3 pieces of the mesh share no edge, and each needs a chart of its own";
        assert_eq!(cut.missed.as_deref(), Some(why));
    }

    /// The cut of a folded sheet of 8 × 8 cells in four parts, stripes of two cells' width between the folds,
    /// drawn by `source`, less certain from left to right.
    fn striped(source: SegmentationSource, max_charts: u32) -> Cut {
        let fold = |_, y: f64| 0.5 * (y.rem_euclid(4.0) - 2.0).abs();
        let (text, run) = (scenes::sheet(8, fold), Run::quiet());
        let options = UnwrapOptions { max_charts: Some(max_charts), ..scenes::options() };
        let (mut found, mut solvers) = scenes::found(&text, &options, &run);
        let part =
            |id| Part { id, name: id.to_string(), source, confidence: 0.9, name_confidence: None };
        let join = |(a, b, boundary)| PartJoin { a, b, boundary };
        found.parts = PartLabels {
            labels: (0..128).map(|f| f / 2 % 8 / 2).collect(),
            parts: (0..4).map(part).collect(),
            joins: [(2, 3, 0.6), (1, 2, 0.7), (0, 1, 0.8)].map(join).to_vec(),
        };
        found.densities = vec![1.0; 4];
        solvers.part_of = found.parts.labels.clone();
        cut(&found, &solvers, &options, &scenes::engine(), &run).unwrap()
    }

    #[test]
    fn borders_that_only_the_network_draws_give_way_the_least_certain_first() {
        for (most, own) in [(4, [0, 1, 2, 3]), (3, [0, 1, 2, 2]), (2, [0, 1, 1, 1]), (1, [0; 4])] {
            let cut = striped(SegmentationSource::Learned, most);
            assert_eq!(cut.charts.len(), most as usize);
            assert_eq!([0, 4, 8, 12].map(|f| cut.regions.of_face[f]), own);
            assert_eq!(cut.missed, None);
        }
    }

    #[test]
    fn borders_that_were_given_stay_and_are_the_reason() {
        let cut = striped(SegmentationSource::Labels, 2);
        assert_eq!(cut.charts.len(), 4);
        let said = cut.missed.unwrap();
        assert!(said.contains("divide it into 4 pieces"), "{said}");
    }

    #[test]
    fn what_does_not_open_is_told_as_that() {
        // A sphere, and a bound so low that it is missed still when it was raised.
        let options =
            UnwrapOptions { max_charts: Some(1), distortion_bound: 1e-6, ..scenes::options() };
        let (_, _, cut) = scenes::cut(&scenes::sphere(6), &options, &Run::quiet());
        assert!(cut.charts.len() > 1);
        let said = cut.missed.unwrap();
        assert!(said.starts_with("it does not open into so few"), "{said}");
    }

    #[test]
    fn an_aim_that_there_was_no_time_for_has_that_reason() {
        let run = scenes::late(52);
        let options =
            UnwrapOptions { max_charts: Some(1), distortion_bound: 1e-6, ..scenes::options() };
        let (_, _, cut) = scenes::cut(&scenes::sphere(6), &options, &run);
        assert!(cut.missed.unwrap().contains("time was too short"));
    }

    #[test]
    fn without_time_seams_are_not_trained() {
        let run = scenes::late(30);
        let (found, solvers) = scenes::found(scenes::CUBE, &scenes::options(), &run);
        let options = UnwrapOptions { quality: Quality::Best, ..scenes::options() };
        let cut = cut(&found, &solvers, &options, &scenes::engine(), &run).unwrap();
        assert_eq!(cut.joint_seams, None);
        let seams =
            Degradation { stage: Stage::Charts, gave_up: GaveUp::JointSeams, scarce: Scarce::Time };
        assert_eq!(run.budget.degraded(), [seams]);
    }

    #[test]
    fn an_order_that_changes_nothing_gains_nothing() {
        let run = Run::quiet();
        let (found, solvers) = scenes::found(scenes::CUBE, &scenes::options(), &run);
        let how = ChartOptions::from(&scenes::options());
        let regions = regions::divide(&found, &found.segmented(), AtlasGrouping::Scene);
        let attempt = |openness: Option<&[f32]>| {
            Cutter { solvers: &solvers, openness, run: &run }.cut(&regions, &how).unwrap()
        };
        let baseline = attempt(None);
        assert_eq!(baseline.joint_seams, None);
        // All edges alike, and nothing known of any.
        for (open, pieces, gain) in [(0.5, 1, Some(0.0)), (f32::NAN, 0, None)] {
            let openness = vec![open; solvers.surface.twin.len()];
            let cut = attempt(Some(&openness));
            assert_eq!(cut.joint_seams, Some(JointSeams { pieces, kept: 0, gain }));
            assert_eq!(cut.charts, baseline.charts);
        }
    }

    #[test]
    fn seams_are_trained_with_the_best_quality_alone() {
        let run = Run::quiet();
        // A cube, and two squares that leave nothing to choose.
        let text = scenes::and_a_cube(&scenes::squares(2), 8);
        let (found, solvers) = scenes::found(&text, &scenes::options(), &run);
        let with = |quality| {
            let options = UnwrapOptions { quality, steps: 2, ..scenes::options() };
            cut(&found, &solvers, &options, &scenes::engine(), &run).unwrap().joint_seams
        };
        assert_eq!(with(Quality::Balanced), None);
        assert_eq!(with(Quality::Best).map(|seams| seams.pieces), Some(1));
    }
}
