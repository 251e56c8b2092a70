//! Packing as a search. An arrangement is placed chart by chart, each where its top comes lowest;
//! what does not fit is left over. From the best arrangement so far, batches of changed ones are
//! tried at a slightly higher density, and the one that leaves least over goes on. What an arrangement
//! is worth shows on coarse pages, too, where a trial costs a tenth: it is found there and settled on
//! the fine ones. Nothing here looks at a clock: the search ends after so many words of cells have been
//! looked at, and a batch is compared in its own order, so that neither the machine nor its threads
//! have a say.

use std::collections::HashMap;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use glam::DVec2;

use super::arrangement::{Arrangement, ORDERS};
use super::effort::Effort;
use super::mask::Mask;
use super::page::Page;
use super::piece::Piece;
use crate::contract::{Canceled, GaveUp, Run, Scarce, Stage};
use crate::device::Seeded;
use crate::tasks;

/// Cells across a square of a chart's share of the page from which on coarse pages tell enough …
const CELLS_A_CHART: f64 = 60.0;

/// … and across such a page, at least.
const COARSEST: u32 = 192;

/// Arrangements tried at once.
const BATCH: u64 = 8;

/// Relative steps by which the density is raised: at first …
const FIRST: f64 = 0.02;

/// … at first where an arrangement was found on coarse pages …
const FIRST_SETTLED: f64 = 0.005;

/// … and no smaller than.
const SMALLEST: f64 = 0.002;

/// Densities over the one expected from coarse pages at which an arrangement is settled: the lowest …
const LOWEST: f64 = 0.99;

/// … and the steps from there, and from the highest that fits, four at once.
const SETTLING: [f64; 2] = [0.0125, 0.0025];

/// Batches without gain after which the step is halved.
const PATIENCE: u32 = 6;

/// What it costs to draw a row of a mask, or to take it on a page, in words looked at.
const DRAWN: u64 = 128;

/// Charts beyond the largest so many are placed as their boxes: their shapes would gain little.
const SHAPES: usize = 256;

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
    [coarsely, finely]: [Effort; 2],
    run: &Run,
) -> Result<Option<Layout>, Canceled> {
    let mut fine = Search::new(pieces, *sheet, finely, run);
    if fine.bytes() > run.budget.spare_bytes() {
        let layout = fine.bracket(&Arrangement::largest_first(pieces, 0), None)?;
        if layout.is_some() {
            run.give_up(Stage::Pack, GaveUp::Search, Scarce::Memory);
        }
        return Ok(layout);
    }
    if let Some(sheet) = sheet.coarser(pieces.len()) {
        let mut coarse = Search::new(pieces, sheet, coarsely, run);
        if let Some(start) = coarse.start()? {
            let (arrangement, layout) = coarse.climb(start, FIRST)?;
            let expected = layout.density * f64::from(fine.sheet.side) / f64::from(sheet.side);
            if let Some(layout) = fine.settle(&arrangement, expected)? {
                return Ok(Some(fine.climb((arrangement, layout), FIRST_SETTLED)?.1));
            }
        }
    }
    // Too many charts for coarse pages, or what was found there does not fit here: all is done here.
    fine.effort = coarsely;
    let Some(start) = fine.start()? else { return Ok(None) };
    Ok(Some(fine.climb(start, FIRST)?.1))
}

impl Sheet {
    /// The same with fewer cells, where so many charts would still be wide enough.
    fn coarser(&self, charts: usize) -> Option<Self> {
        let share = (charts as f64 / f64::from(self.pages)).sqrt();
        let side = ((CELLS_A_CHART * share) as u32).max(COARSEST).next_multiple_of(64);
        let grow = self.grow * f64::from(side) / f64::from(self.side);
        (side < self.side).then_some(Self { side, grow, ..*self })
    }
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
    sheet: Sheet,
    run: &'a Run,
    /// Place of each chart by size.
    rank: Vec<usize>,
    /// When it ends.
    effort: Effort,
    /// Words looked at so far.
    work: u64,
    /// Pages that are not in use, by trial.
    blank: Mutex<Vec<Vec<Page>>>,
}

impl<'a> Search<'a> {
    fn new(pieces: &'a [Piece], sheet: Sheet, effort: Effort, run: &'a Run) -> Self {
        let (rank, blank) = (ranks(pieces), Mutex::default());
        Self { pieces, sheet, run, rank, effort, work: 0, blank }
    }

    /// The best of the arrangements by size, where one fits.
    fn start(&mut self) -> Result<Option<(Arrangement, Layout)>, Canceled> {
        let by_size = Arrangement::largest_first(self.pieces, 0);
        let Some(layout) = self.bracket(&by_size, None)? else { return Ok(None) };
        let mut best = (by_size, layout);
        for which in 1..ORDERS {
            let other = Arrangement::largest_first(self.pieces, which);
            if self.goes_on()
                && let Some(denser) = self.bracket(&other, Some(best.1.density))?
            {
                best = (other, denser);
            }
        }
        Ok(Some(best))
    }

    /// Whether there is work, and time, to spend on a denser arrangement.
    fn goes_on(&self) -> bool {
        self.work < self.effort.work && !self.run.skips(Stage::Pack, GaveUp::Search)
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
            let trial = self.trials(std::slice::from_ref(a), &scaled, 0.0)?.swap_remove(0);
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

    /// The highest density at which an arrangement fits, around the one that is expected; `None` where it
    /// fits well below alone.
    fn settle(&mut self, a: &Arrangement, expected: f64) -> Result<Option<Layout>, Canceled> {
        let mut low = LOWEST * expected;
        let mut fit = None;
        for step in SETTLING {
            let first = i32::from(fit.is_some());
            let densities: Vec<f64> =
                (first..first + 4).map(|k| low + expected * step * f64::from(k)).collect();
            let trial = |&density: &f64| (density, self.trial(a, &self.scaled(density), 0.0));
            let trials: Vec<_> = tasks::map("density", &densities, trial);
            for (density, trial) in trials {
                let Trial { left, spots, work } = trial?;
                self.work += work;
                self.run.count(work as usize);
                if left == 0.0 {
                    fit = Some(Layout { density, spots });
                }
            }
            let Some(Layout { density, .. }) = fit else { break };
            low = density;
        }
        Ok(fit)
    }

    /// Raise the density by changing the arrangement, by `step` at first, until enough work is done.
    fn climb(
        &mut self,
        (mut from, mut best): (Arrangement, Layout),
        mut step: f64,
    ) -> Result<(Arrangement, Layout), Canceled> {
        let mut fits = from.clone();
        let (mut left, mut idle, mut batch) = (f64::INFINITY, 0, 0);
        let mut scaled = self.scaled(best.density * (1.0 + step));
        while idle < self.effort.idle && self.goes_on() {
            // At a new density the arrangement itself is tried too.
            let unchanged = left.is_infinite();
            let next = |k| match k {
                0 if unchanged => from.clone(),
                _ => from.changed(self.pieces, &mut Seeded::new(batch, k)),
            };
            let tried: Vec<Arrangement> = (0..BATCH).map(next).collect();
            let mut trials = self.trials(&tried, &scaled, left)?;
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
                fits = from.clone();
            } else if idle < PATIENCE || step <= SMALLEST {
                continue;
            } else {
                step *= 0.5;
            }
            (left, idle) = (f64::INFINITY, 0);
            scaled = self.scaled(best.density * (1.0 + step));
        }
        Ok((fits, best))
    }

    fn scaled(&self, density: f64) -> Scaled {
        let turns = |p: &Piece| p.turns.iter().map(|_| OnceLock::new()).collect();
        Scaled { density, masks: self.pieces.iter().map(turns).collect() }
    }

    /// Place arrangements, side by side, each until more than `most` is left over.
    fn trials(
        &mut self,
        all: &[Arrangement],
        scaled: &Scaled,
        most: f64,
    ) -> Result<Vec<Trial>, Canceled> {
        let trials = tasks::map("arrangement", all, |a| self.trial(a, scaled, most));
        let trials = trials.into_iter().collect::<Result<Vec<_>, _>>()?;
        let work: u64 = trials.iter().map(|t| t.work).sum();
        self.work += work;
        self.run.count(work as usize);
        self.run.advance(self.work as f64 / self.effort.work as f64);
        Ok(trials)
    }

    /// Place one arrangement, each chart on the first page that has room for it, until more than `most`
    /// is left over.
    fn trial(&self, a: &Arrangement, scaled: &Scaled, most: f64) -> Result<Trial, Canceled> {
        let spots = vec![Spot::default(); self.pieces.len()];
        let mut trial = Trial { left: 0.0, spots, work: 0 };
        let mut pages = self.blank().pop().unwrap_or_default();
        pages.iter_mut().for_each(Page::clear);
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
                if trial.left > most {
                    break;
                }
            }
        }
        self.blank().push(pages);
        Ok(trial)
    }

    fn blank(&self) -> MutexGuard<'_, Vec<Vec<Page>>> {
        self.blank.lock().unwrap_or_else(PoisonError::into_inner)
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
