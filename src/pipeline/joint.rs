//! Joint seams (pipeline 5a): the network trains a soft map of each over-cut part, in which seams may
//! close; what it leaves open says in which order the patches are joined. The combinatorial order is the
//! control, and the better of both is kept.

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
/// choose, or too much.
pub fn openness(
    solvers: &Solvers,
    cut: &ChartOptions,
    options: &UnwrapOptions,
    engine: &Engine,
    run: &Run,
) -> Result<Vec<f32>, Cause> {
    let surface = &solvers.surface;
    let mut openness = vec![f32::NAN; surface.twin.len()];
    let parts = charts::over_cut(surface, &solvers.regions.of_face, cut, MOST_VERTICES, run)?;
    if parts.is_empty() {
        return Ok(openness);
    }
    let told = Vertices::of(solvers);
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
