//! Packing as a search. An arrangement is placed chart by chart, each where its top comes lowest;
//! what does not fit is left over. From the best arrangement so far, batches of changed ones are
//! tried at a slightly higher density, and the one that leaves least over goes on. Nothing here
//! looks at a clock: the search ends after so many rows of cells have been looked at, and a batch is
//! compared in its own order, so that neither the machine nor its threads have a say.

use std::collections::HashMap;
use std::sync::OnceLock;

use glam::DVec2;
use rayon::prelude::*;

use super::arrangement::{Arrangement, ORDERS};
use super::mask::{Mask, Outline};
use super::page::Page;
use crate::contract::{Canceled, GaveUp, Run, Scarce, Stage};
use crate::device::Seeded;

/// Rows looked at after which nothing further is begun: about a second of one core.
const WORK: u64 = 24_000_000;

/// Arrangements tried at once.
const BATCH: u64 = 8;

/// Relative steps by which the density is raised: at first, and no smaller than.
const STEPS: [f64; 2] = [0.02, 0.002];

/// Batches without gain after which the step is halved.
const PATIENCE: u32 = 6;

/// Batches without gain at the smallest step after which the search ends.
const END: u32 = 60;

/// What it costs to draw a row of a mask, or to take it on a page, in rows looked at.
const DRAWN: u64 = 8;

/// Charts beyond the largest so many are placed as their boxes: their shapes would gain little.
const SHAPES: usize = 256;

/// A chart to be placed.
#[derive(Debug, Clone)]
pub(super) struct Piece {
    /// Its border, in its own units.
    pub outline: Outline,
    /// Density relative to the other charts.
    pub weight: f64,
    /// Turns (unit vectors) that it may be laid down with, besides quarter turns; never empty.
    pub turns: Vec<DVec2>,
    /// Its area at weight 1; a needle counts as a thin box.
    pub area: f64,
}

impl Piece {
    /// A chart by its outline.
    pub fn new(outline: Outline, weight: f64, turns: Vec<DVec2>) -> Self {
        let mut piece = Self { area: outline.area(), outline, weight, turns };
        piece.area = piece.area.max(1e-6 * (piece.extent() / weight).max_element().powi(2));
        piece
    }

    /// Width and height of its box along its first turn, weighted.
    pub fn extent(&self) -> DVec2 {
        let [low, high] = self.outline.extent(self.turns[0]);
        (high - low) * self.weight
    }
}

/// The pages that are packed onto.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sheet {
    /// Most pages.
    pub pages: u32,
    /// Cells across a page.
    pub side: u32,
    /// Half of the gutter, in cells.
    pub grow: f64,
    /// Quarter turns that may be made: 1 (none) or 4.
    pub quarters: usize,
}

/// Where a chart came to lie.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Spot {
    /// Its page, from 0.
    pub page: u32,
    /// The whole turn, as a unit vector.
    pub turn: DVec2,
    /// Where the chart's own origin lies, cells.
    pub origin: DVec2,
}

/// All charts placed.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layout {
    /// Cells per unit, at weight 1.
    pub density: f64,
    /// One spot a chart.
    pub spots: Vec<Spot>,
}

/// Place all charts at the highest density that is found; `None` where they fit at none.
pub(super) fn search(
    pieces: &[Piece],
    sheet: &Sheet,
    run: &Run,
) -> Result<Option<Layout>, Canceled> {
    let mut search = Search { pieces, sheet, run, rank: ranks(pieces), work: 0 };
    let by_size = Arrangement::largest_first(pieces, 0);
    let Some(mut best) = search.bracket(&by_size, None)? else { return Ok(None) };
    if search.bytes() > run.budget.spare_bytes() {
        run.give_up(Stage::Pack, GaveUp::Search, Scarce::Memory);
        return Ok(Some(best));
    }
    let mut arrangement = by_size;
    for which in 1..ORDERS {
        let other = Arrangement::largest_first(pieces, which);
        if search.goes_on()
            && let Some(denser) = search.bracket(&other, Some(best.density))?
        {
            (best, arrangement) = (denser, other);
        }
    }
    Ok(Some(search.climb(arrangement, best)?))
}

/// Place of each chart in the order of sizes.
fn ranks(pieces: &[Piece]) -> Vec<usize> {
    let mut rank = vec![0; pieces.len()];
    let order = Arrangement::largest_first(pieces, 0).order;
    order.iter().enumerate().for_each(|(r, &i)| rank[i as usize] = r);
    rank
}

/// The unit vector of `q` quarter turns.
fn quarter(q: usize) -> DVec2 {
    [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y][q % 4]
}

/// One arrangement placed at one density.
struct Trial {
    /// Area of the charts that found no place.
    left: f64,
    spots: Vec<Spot>,
    work: u64,
}

/// The charts at one density: for each turn of each chart the masks of its quarter turns, made when
/// first asked for.
struct Scaled {
    density: f64,
    masks: Vec<Vec<OnceLock<Vec<Mask>>>>,
}

struct Search<'a> {
    pieces: &'a [Piece],
    sheet: &'a Sheet,
    run: &'a Run,
    /// Place of each chart by size.
    rank: Vec<usize>,
    /// Rows looked at so far.
    work: u64,
}

impl Search<'_> {
    /// Whether there is work, and time, to spend on a denser arrangement.
    fn goes_on(&self) -> bool {
        self.work < WORK && !self.run.skips(Stage::Pack, GaveUp::Search)
    }

    /// Bytes of a batch of arrangements with all their pages.
    fn bytes(&self) -> u64 {
        BATCH * u64::from(self.sheet.pages) * Page::bytes(self.sheet.side)
    }

    /// A density at which the arrangement fits, within a hundredth of one at which it does not;
    /// `None` where there is none, or none above `floor`.
    fn bracket(&mut self, a: &Arrangement, floor: Option<f64>) -> Result<Option<Layout>, Canceled> {
        let side = f64::from(self.sheet.side);
        let area: f64 = self.pieces.iter().map(|p| p.area * p.weight.powi(2)).sum();
        let longest = self.pieces.iter().map(|p| p.extent().max_element()).fold(0.0, f64::max);
        // No chart is longer than the diagonal, nor all of them larger than the pages.
        let full = side * (f64::from(self.sheet.pages) / area).sqrt();
        let mut over = full.min(1.5 * side / longest);
        let mut density = floor.map_or(0.7 * over, |floor| 1.01 * floor);
        let (mut fit, mut pace) = (None::<Layout>, 1.1);
        loop {
            let scaled = self.scaled(density);
            let trial = self.trials(std::slice::from_ref(a), &scaled)?.swap_remove(0);
            if trial.left == 0.0 {
                fit = Some(Layout { density, spots: trial.spots });
            } else {
                over = density;
            }
            density = match &fit {
                Some(fit) if over <= 1.01 * fit.density => break,
                Some(fit) => (fit.density * over).sqrt(),
                None if floor.is_some() => break,
                // Every chart is well within a cell.
                None if density * longest < 1e-3 => break,
                None => density / pace,
            };
            pace *= 1.1;
        }
        Ok(fit)
    }

    /// Raise the density by changing the arrangement, until enough work is done.
    fn climb(&mut self, mut from: Arrangement, mut best: Layout) -> Result<Layout, Canceled> {
        let (mut step, mut left, mut idle, mut batch) = (STEPS[0], f64::INFINITY, 0, 0);
        let mut scaled = self.scaled(best.density * (1.0 + step));
        while idle < END && self.goes_on() {
            // At a new density the arrangement itself is tried too.
            let unchanged = left.is_infinite();
            let next = |k| match k {
                0 if unchanged => from.clone(),
                _ => from.changed(self.pieces, &mut Seeded::new(batch, k)),
            };
            let tried: Vec<Arrangement> = (0..BATCH).map(next).collect();
            let mut trials = self.trials(&tried, &scaled)?;
            batch += 1;
            let lefts = trials.iter().map(|t| t.left).enumerate();
            let (chosen, least) = lefts.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default();
            idle = if least < left { 0 } else { idle + 1 };
            if least <= left {
                (from, left) = (tried[chosen].clone(), least);
            }
            if least == 0.0 {
                let spots = trials.swap_remove(chosen).spots;
                best = Layout { density: scaled.density, spots };
            } else if idle < PATIENCE || step <= STEPS[1] {
                continue;
            } else {
                step *= 0.5;
            }
            (left, idle) = (f64::INFINITY, 0);
            scaled = self.scaled(best.density * (1.0 + step));
        }
        Ok(best)
    }

    fn scaled(&self, density: f64) -> Scaled {
        let turns = |p: &Piece| p.turns.iter().map(|_| OnceLock::new()).collect();
        Scaled { density, masks: self.pieces.iter().map(turns).collect() }
    }

    /// Place arrangements, side by side.
    fn trials(&mut self, all: &[Arrangement], scaled: &Scaled) -> Result<Vec<Trial>, Canceled> {
        let trials: Vec<Result<Trial, Canceled>> =
            all.par_iter().map(|a| self.trial(a, scaled)).collect();
        let trials = trials.into_iter().collect::<Result<Vec<_>, _>>()?;
        self.work += trials.iter().map(|t| t.work).sum::<u64>();
        self.run.advance(self.work as f64 / WORK as f64);
        Ok(trials)
    }

    /// Place one arrangement: each chart on the first page that has room for it.
    fn trial(&self, a: &Arrangement, scaled: &Scaled) -> Result<Trial, Canceled> {
        let spots = vec![Spot::default(); self.pieces.len()];
        let mut trial = Trial { left: 0.0, spots, work: 0 };
        let mut pages: Vec<Page> = Vec::new();
        // Where equal boxes were put last: the next fits nowhere below.
        let mut above: HashMap<(usize, u32, u32), u32> = HashMap::new();
        for &i in &a.order {
            self.run.cancel.check()?;
            let (piece, turn) = (&self.pieces[i as usize], usize::from(a.turn[i as usize]));
            let solid = self.rank[i as usize] >= SHAPES;
            let masks = scaled.masks[i as usize][turn].get_or_init(|| {
                let masks = self.masks(piece, piece.turns[turn], scaled.density, solid);
                // Which of a batch's trials this falls to is chance; their sum is not.
                trial.work += masks.iter().map(|m| DRAWN * u64::from(m.height)).sum::<u64>();
                masks
            });
            let mut placed = false;
            for at in 0..self.sheet.pages as usize {
                if at == pages.len() {
                    pages.push(Page::new(self.sheet.side));
                }
                let mut best: Option<(u32, u32, usize)> = None;
                for (q, mask) in masks.iter().enumerate() {
                    let end = best.map_or(u32::MAX, |(_, y, q)| y + masks[q].height - 1);
                    let below = above.entry((at, mask.width, mask.height)).or_default();
                    let from = if solid { *below } else { 0 };
                    match pages[at].find(mask, from, end, &mut trial.work) {
                        Some((x, y)) => best = Some((x, y, q)),
                        None if best.is_none() && solid => *below = self.sheet.side,
                        None => {}
                    }
                }
                if let Some((x, y, q)) = best {
                    let mask = &masks[q];
                    if solid {
                        above.insert((at, mask.width, mask.height), y);
                    }
                    pages[at].insert(mask, x, y);
                    trial.work += DRAWN * u64::from(mask.height);
                    trial.spots[i as usize] = Spot {
                        page: at as u32,
                        turn: quarter(q).rotate(piece.turns[turn]),
                        origin: DVec2::new(f64::from(x), f64::from(y)) + mask.origin,
                    };
                    placed = true;
                    break;
                }
            }
            if !placed {
                trial.left += piece.area * piece.weight.powi(2);
            }
        }
        Ok(trial)
    }

    /// The masks of the quarter turns of a chart that is turned by `turn`.
    fn masks(&self, piece: &Piece, turn: DVec2, density: f64, solid: bool) -> Vec<Mask> {
        let mask = |q| {
            let (turn, scale) = (quarter(q).rotate(turn), density * piece.weight);
            Mask::new(&piece.outline, turn, scale, self.sheet.grow, solid)
        };
        // A box is the same upside down.
        let quarters = if solid { self.sheet.quarters.min(2) } else { self.sheet.quarters };
        (0..quarters).map(mask).collect()
    }
}
