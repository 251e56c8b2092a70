//! Charts that leave much of the page empty, of many branches or bent round, are divided where that
//! fills it better and the cut is short. Maps stay as they are.

use std::f64::consts::PI;

use glam::DVec2;

use crate::charts::limits::ChartLimits;
use crate::charts::limits::extent::sound_map;
use crate::charts::patchwork::Patchwork;
use crate::contract::{Canceled, Run};
use crate::tasks;

/// Directions over half a turn in which a cut, and a rectangle's side, may run: an even number, so that
/// each has one across it.
const DIRECTIONS: usize = 12;

/// Cuts tried in each direction.
const CUTS: usize = 15;

/// A chart's rectangle may leave this much of the page empty, over ΣA.
const EMPTY: f64 = 0.05;

/// What a cut must save of that, over ΣA …
const SAVED: f64 = 0.02;

/// … and for its length over √ΣA.
pub const CUT_PRICE: f64 = 0.15;

/// Most pieces of one cut.
const PIECES: usize = 4;

/// Most cuts of one chart.
const DEPTH: usize = 8;

/// Divide the charts. Returns those that have changed.
pub fn compact(
    work: &mut Patchwork,
    limits: &ChartLimits,
    run: &Run,
) -> Result<Vec<u32>, Canceled> {
    let mut changed = Vec::new();
    if !(0..work.faces.len() as u32).any(|chart| is_wasteful(work, chart, limits)) {
        return Ok(changed);
    }
    // Maps stay as they are: where faces lie is worked out once.
    let along = places(work);
    for chart in 0..work.faces.len() as u32 {
        let mut waiting = vec![chart];
        let mut cuts = 0;
        while let Some(chart) = waiting.pop().filter(|_| cuts < DEPTH) {
            run.cancel.check()?;
            if let Some(pieces) = best_cut(work, chart, &along, limits) {
                waiting.extend(work.divide(chart, pieces));
                changed.extend(waiting.iter().copied());
                cuts += 1;
            }
        }
    }
    changed.sort_unstable();
    changed.dedup();
    Ok(changed)
}

/// Where each face lies along each direction.
type Along = [f64; DIRECTIONS];

/// The centres of all faces.
fn places(work: &Patchwork) -> Vec<Along> {
    let directions: [DVec2; DIRECTIONS] =
        std::array::from_fn(|k| DVec2::from_angle(PI * k as f64 / DIRECTIONS as f64));
    let place = |corners: &[DVec2]| {
        let center = corners.iter().sum::<DVec2>() / 3.0;
        directions.map(|direction| center.dot(direction))
    };
    work.uv.chunks_exact(3).map(place).collect()
}

fn is_wasteful(work: &Patchwork, chart: u32, limits: &ChartLimits) -> bool {
    let empty = work.extent[chart as usize].rectangle - work.area[chart as usize];
    empty >= EMPTY * limits.size * limits.size
}

/// The cut that pays best, as the pieces that it leaves.
fn best_cut(
    work: &Patchwork,
    chart: u32,
    along: &[Along],
    limits: &ChartLimits,
) -> Option<Vec<Vec<u32>>> {
    if !is_wasteful(work, chart, limits) {
        return None;
    }
    let (page, area) = (limits.size * limits.size, work.area[chart as usize]);
    let faces = &work.faces[chart as usize];
    let (spans, whole) = (spans(faces, along), rectangle(faces, along));
    let best_along = |k: usize| {
        let mut best: Option<(f64, Vec<Vec<u32>>)> = None;
        let [low, high] = spans[k];
        for cut in 1..=CUTS {
            let at = low + (high - low) * cut as f64 / (CUTS + 1) as f64;
            let beyond = |h: u32| along[h as usize / 3][k] > at;
            let same =
                |h: u32| work.glued[h as usize] && beyond(h) == beyond(work.mesh.twin[h as usize]);
            let length: f64 = faces
                .iter()
                .flat_map(|&f| 3 * f..3 * f + 3)
                .filter(|&h| work.glued[h as usize] && beyond(h) && !same(h))
                .map(|h| work.mesh.length(h))
                .sum();
            let price = SAVED * page + CUT_PRICE * limits.size * length;
            if whole - area < price {
                continue;
            }
            let pieces = work.mesh.components(faces, same);
            let left: f64 = pieces.iter().map(|piece| rectangle(piece, along)).sum();
            let gain = whole - left - price;
            if pieces.len() <= PIECES
                && gain > best.as_ref().map_or(0.0, |b| b.0)
                && pieces.iter().all(|piece| sound_map(work, piece, same, limits).is_some())
            {
                best = Some((gain, pieces));
            }
        }
        best
    };
    let found = tasks::map("cut along", 0..DIRECTIONS, best_along);
    let best =
        found.into_iter().flatten().reduce(|best, next| if next.0 > best.0 { next } else { best });
    best.map(|(_, pieces)| pieces)
}

/// From where to where the faces' centres reach along each direction.
fn spans(faces: &[u32], along: &[Along]) -> [[f64; 2]; DIRECTIONS] {
    let mut spans = [[f64::INFINITY, f64::NEG_INFINITY]; DIRECTIONS];
    for &f in faces {
        for (span, x) in spans.iter_mut().zip(along[f as usize]) {
            *span = [span[0].min(x), span[1].max(x)];
        }
    }
    spans
}

/// Area of the smallest rectangle around the faces' centres, of those along the directions.
fn rectangle(faces: &[u32], along: &[Along]) -> f64 {
    let spans = spans(faces, along);
    let length = |k: usize| spans[k % DIRECTIONS][1] - spans[k % DIRECTIONS][0];
    (0..DIRECTIONS / 2)
        .map(|k| length(k) * length(k + DIRECTIONS / 2))
        .fold(f64::INFINITY, f64::min)
}
