//! Joint seams (docs/method.md, 4.6): the network trains a soft map of each connected component of a part,
//! cut at every seam between patches, in which seams may close; what it leaves open says in which order the
//! patches are merged. The best of the other orders is the baseline, and the better of both is kept.

use super::engine::Engine;
use super::error::Cause;
use super::neural::{self, Vertices};
use super::parts::Solvers;
use crate::charts::{self, ChartOptions, OverCutPart};
use crate::contract::{Run, Stage, UnwrapOptions};
use crate::parameterization::losses::{CutEdge, OverCut};
use crate::parameterization::{self, TrainChart, TrainOptions};

/// Vertices of the largest part whose seams are trained: all of them take part in every step.
const MOST_VERTICES: usize = 4096;

/// Most steps of a soft map: it says what to join first and need not be finished.
const MOST_STEPS: u32 = 200;

/// Share of the stage that training is taken for.
const TRAINED: f64 = 0.5;

/// Gap, in radii of the part, at which a seam counts as half open.
const HALF_OPEN: f64 = 0.05;

/// How far a soft map has left each half-edge of the surface open, 0 to 1; NaN where there was nothing to
/// choose, or too much. `regions`: what charts may not cross, of each face.
pub fn openness(
    solvers: &Solvers,
    regions: &[u32],
    cut: &ChartOptions,
    options: &UnwrapOptions,
    engine: &Engine,
    run: &Run,
) -> Result<Vec<f32>, Cause> {
    let surface = &solvers.surface;
    let mut openness = vec![f32::NAN; surface.twin.len()];
    let parts = charts::over_cut(surface, regions, cut, MOST_VERTICES, run)?;
    if parts.is_empty() {
        return Ok(openness);
    }
    let told = Vertices::of(solvers, surface);
    let inputs: Vec<TrainChart> = parts.iter().map(|part| input(part, &told)).collect();
    let options = TrainOptions {
        points: MOST_VERTICES,
        steps: options.steps.min(MOST_STEPS),
        stage: Stage::Charts,
        ..TrainOptions::from(options)
    };
    let mut told = |step: u32, steps: u32, _: &[usize]| {
        // The rest of the stage is the joining.
        run.advance(TRAINED * f64::from(step) / f64::from(steps.max(1)));
    };
    let trained = parameterization::train(&inputs, &options, &engine.device, run, &mut told)?;
    for (part, map) in parts.iter().zip(trained) {
        let unit = HALF_OPEN * radius(part);
        for seam in &part.seams {
            let [[i, j], [k, l]] = seam.sides.map(|side| side.map(|v| map.uv[v as usize]));
            let gap = 0.5 * (i.distance_squared(k) + j.distance_squared(l));
            let open = gap / (gap + unit * unit);
            seam.half_edges.iter().for_each(|&h| openness[h as usize] = open as f32);
        }
    }
    Ok(openness)
}

fn input<'a>(part: &'a OverCutPart, told: &Vertices) -> TrainChart<'a> {
    let edge =
        |seam: &charts::Seam| CutEdge { sides: seam.sides, length: seam.length, cost: seam.cost };
    let edges = part.seams.iter().map(edge).collect();
    let id = part.faces.first().map_or(0, |&f| u64::from(f));
    TrainChart {
        over_cut: Some(OverCut { edges, radius: radius(part) }),
        ..neural::input(&part.disk, &part.vertices, &part.start, told, id)
    }
}

/// Radius of a disk of the part's area: the unit in which gaps are measured.
fn radius(part: &OverCutPart) -> f64 {
    (part.disk.area() / std::f64::consts::PI).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::AtlasGrouping;
    use crate::mesh::NONE;
    use crate::pipeline::{regions, scenes};

    fn open(text: &str, steps: u32) -> (Solvers, Vec<f32>) {
        let run = Run::quiet();
        let (found, solvers) = scenes::found(text, &scenes::options(), &run);
        let regions = regions::divide(&found, &found.segmented(), AtlasGrouping::Scene).of_face;
        let options = UnwrapOptions { steps, points: 64, ..scenes::options() };
        let cut = ChartOptions::from(&options);
        let openness =
            openness(&solvers, &regions, &cut, &options, &scenes::engine(), &run).unwrap();
        (solvers, openness)
    }

    #[test]
    fn the_edges_of_a_box_are_open_or_closed_and_its_sides_are_not_asked() {
        let (solvers, openness) = open(scenes::CUBE, 1);
        let surface = &solvers.surface;
        let mut edges = Vec::new();
        for (h, &t) in (0u32..).zip(&surface.twin) {
            assert_ne!(t, NONE);
            let told = openness[h as usize];
            assert_eq!(
                told.is_nan(),
                !surface.is_crease(h),
                "a choice at every edge, and nowhere else"
            );
            if h < t && !told.is_nan() {
                assert_eq!(told, openness[t as usize], "the same from both sides");
                edges.push(told);
            }
        }
        // After one step the map is still laid out along a tree of the edges: those are closed.
        edges.sort_by(f32::total_cmp);
        assert_eq!(edges.len(), 12);
        assert!(edges[..5].iter().all(|&o| (0.0..0.1).contains(&o)), "{edges:?}");
        assert!(edges[5..].iter().all(|&o| (0.5..1.0).contains(&o)), "{edges:?}");
    }

    #[test]
    fn training_moves_the_seams_and_is_the_same_each_time() {
        let [early, late, again] = [1, 40, 40].map(|steps| open(scenes::CUBE, steps).1);
        let bits = |o: &[f32]| o.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_ne!(bits(&early), bits(&late));
        assert_eq!(bits(&late), bits(&again));
    }

    #[test]
    fn a_sheet_leaves_nothing_to_choose() {
        let (_, openness) = open(&scenes::sheet(3, |_, _| 0.0), 1);
        assert!(openness.len() == 54 && openness.iter().all(|o| o.is_nan()));
    }
}
