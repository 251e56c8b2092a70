//! Seams moved (docs/method.md, 4.5): within a band about the path between two charts (the collar) the
//! faces are dealt out anew, so that the seam costs least (length times cost), by one minimum cut; it comes
//! to run straight, or along the nearest crease. Faces that change sides are stitched to their new chart's
//! map. A move is kept if both charts stay injective and within the bound and the objective falls.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};
use std::sync::atomic::{AtomicBool, Ordering};

use glam::DVec3;

use crate::charts::joins::candidates;
use crate::charts::joins::proposal::{Motion, lay_out, rigid_motion};
use crate::charts::limits::ChartLimits;
use crate::charts::limits::cost::edge_cost;
use crate::charts::limits::fit::{Fit, refine};
use crate::charts::part_mesh::Piece;
use crate::charts::patchwork::Patchwork;
use crate::contract::{Canceled, GaveUp, Run, Stage};
use crate::mesh::{Flow, NONE};
use crate::tasks;

/// Width of the collar on each side, over the size (√area) of the smaller chart. Halved where it would
/// leave nothing of a chart.
const COLLAR: f64 = 0.3;

/// Times that the collar is halved.
const HALVINGS: u32 = 3;

/// A collar of more faces than this is halved too.
const COLLAR_FACES: usize = 30_000;

/// Share of the path's cost that a move must save to be worth two solves.
const WORTHWHILE: f64 = 0.03;

/// Faces that all moves together may flatten, per face of the part.
const WORK_PER_FACE: usize = 12;

/// Capacity of what must not be cut, over the cost of the path.
const UNCUT: f64 = 1e3;

/// Move the seams between the charts in `among` (ascending), each pair's once. Returns the charts that
/// have changed.
pub fn straighten(
    work: &mut Patchwork,
    among: &[u32],
    limits: &ChartLimits,
    run: &Run,
) -> Result<Vec<u32>, Canceled> {
    let faces: usize = among.iter().map(|&c| work.faces[c as usize].len()).sum();
    let mut allowance = WORK_PER_FACE * faces;
    let (mut pairs, mut changed) = (BTreeSet::new(), BTreeSet::new());
    for &a in among {
        let found = candidates::around(work, a);
        let there = |c: &&candidates::Candidate| c.b > a && among.binary_search(&c.b).is_ok();
        pairs.extend(found.iter().filter(there).map(|c| [a, c.b]));
    }
    while !pairs.is_empty() {
        run.cancel.check()?;
        if run.skips(Stage::Charts, GaveUp::Joining) {
            break;
        }
        // Pairs with no chart in common, so that they can be moved at the same time.
        let (mut batch, mut busy) = (Vec::new(), BTreeSet::new());
        pairs.retain(|&pair| {
            let free = pair.iter().all(|chart| !busy.contains(chart));
            if free {
                busy.extend(pair);
                batch.push(pair);
            }
            !free
        });
        let found = tasks::map("seam", &batch, |&pair| Move::find(work, pair));
        let affordable = |found: &Move| {
            let left = allowance.checked_sub(found.size(work));
            allowance = left.unwrap_or(allowance);
            left.is_some()
        };
        let tried: Vec<Move> = found.into_iter().flatten().filter(affordable).collect();
        let solved = tasks::map("move", &tried, |found| found.solve(work, limits, run));
        for (found, new) in tried.iter().zip(solved) {
            if let Some(new) = new? {
                found.commit(work, &new);
                changed.extend(found.charts);
            }
        }
    }
    Ok(changed.into_iter().collect())
}

/// Which faces of the collar go to which of two charts.
struct Deal {
    /// Face and chart.
    faces: BTreeMap<u32, u32>,
    /// What the seam costs less.
    saved: f64,
}

impl Deal {
    fn owner(&self, work: &Patchwork, f: u32) -> u32 {
        self.faces.get(&f).copied().unwrap_or(work.chart_of[f as usize])
    }
}

/// The cheapest seam within the collar about a seam (both half-edges of each of its edges), if it is worth
/// trying.
fn deal_anew(work: &Patchwork, [a, b]: [u32; 2], seam: &BTreeSet<u32>) -> Option<Deal> {
    let cost = 0.5 * seam.iter().map(|&h| edge_cost(work.mesh, h)).sum::<f64>();
    let mut width = COLLAR * work.area[a as usize].min(work.area[b as usize]).sqrt();
    for _ in 0..=HALVINGS {
        let collar = collar(work, [a, b], seam, width);
        if collar.len() <= COLLAR_FACES
            && let Some(deal) = cut(work, [a, b], seam, &collar, cost)
        {
            return (deal.saved > WORTHWHILE * cost).then_some(deal);
        }
        width *= 0.5;
    }
    None
}

/// The half-edge across, where a face may change hands over the edge: where it is closed, and at the seam.
fn crossing(work: &Patchwork, seam: &BTreeSet<u32>, h: u32) -> Option<u32> {
    let passes = work.glued[h as usize] || seam.contains(&h);
    passes.then(|| work.mesh.twin[h as usize]).filter(|&t| t != NONE)
}

/// Faces of two charts whose centres are no farther from the seam's faces than `width`, over faces.
fn collar(work: &Patchwork, charts: [u32; 2], seam: &BTreeSet<u32>, width: f64) -> BTreeSet<u32> {
    let center = |f: u32| {
        let corners = work.mesh.surface.corners(work.mesh.faces[f as usize] as usize);
        corners.into_iter().sum::<DVec3>() / 3.0
    };
    let mut distance: BTreeMap<u32, f64> = seam.iter().map(|&h| (h / 3, 0.0)).collect();
    let mut heap: BinaryHeap<Reverse<(u64, u32)>> =
        distance.keys().map(|&f| Reverse((0, f))).collect();
    while let Some(Reverse((bits, f))) = heap.pop() {
        let so_far = f64::from_bits(bits);
        if so_far > distance[&f] {
            continue;
        }
        for t in (3 * f..3 * f + 3).filter_map(|h| crossing(work, seam, h)) {
            let g = t / 3;
            let there = so_far + center(f).distance(center(g));
            let nearer = distance.get(&g).is_none_or(|&d| there < d);
            if nearer && there <= width && charts.contains(&work.chart_of[g as usize]) {
                distance.insert(g, there);
                heap.push(Reverse((there.to_bits(), g)));
            }
        }
    }
    distance.into_keys().collect()
}

/// The minimum cut through a collar; `None` where one of the charts has nothing outside of it.
fn cut(
    work: &Patchwork,
    [a, b]: [u32; 2],
    seam: &BTreeSet<u32>,
    collar: &BTreeSet<u32>,
    cost: f64,
) -> Option<Deal> {
    let place: BTreeMap<u32, usize> = collar.iter().enumerate().map(|(i, &f)| (f, i)).collect();
    let (source, sink) = (collar.len(), collar.len() + 1);
    let mut flow = Flow::new(collar.len() + 2);
    let mut tied = [false; 2];
    let mut edges = Vec::new();
    for (&f, &i) in &place {
        let mine = work.chart_of[f as usize];
        let mut is_tied = false;
        for h in 3 * f..3 * f + 3 {
            let Some(t) = crossing(work, seam, h) else { continue };
            match place.get(&(t / 3)) {
                Some(&j) if h < t => {
                    let capacity = edge_cost(work.mesh, h) / cost;
                    flow.edge(i, j, capacity, capacity);
                    edges.push((f, t / 3, capacity));
                }
                Some(_) => {}
                None => is_tied = true,
            }
        }
        if is_tied {
            tied[usize::from(mine == b)] = true;
            if mine == a {
                flow.edge(source, i, UNCUT, 0.0);
            } else {
                flow.edge(i, sink, UNCUT, 0.0);
            }
        }
    }
    if tied != [true; 2] {
        return None;
    }
    let side = flow.source_side(source, sink);
    let faces: BTreeMap<u32, u32> =
        place.iter().map(|(&f, &i)| (f, if side[i] { a } else { b })).collect();
    let now: f64 = edges.iter().filter(|(f, g, _)| faces[f] != faces[g]).map(|e| e.2).sum();
    Some(Deal { faces, saved: (1.0 - now) * cost })
}

/// A seam between two charts and a cheaper one.
struct Move {
    charts: [u32; 2],
    deal: Deal,
    /// Half-edges that are closed or opened.
    toggled: BTreeSet<u32>,
    /// What lays the second chart next to the first.
    motion: Motion,
}

impl Move {
    /// The cheapest seam in place of the longest path between two charts.
    fn find(work: &Patchwork, [a, b]: [u32; 2]) -> Option<Self> {
        let paths = candidates::around(work, a).into_iter().filter(|c| c.b == b && !c.zip);
        let longest = paths.max_by(|c, d| c.cost(work).total_cmp(&d.cost(work)));
        let path = longest.map(|c| c.path).filter(|path| path.len() > 1)?;
        let seam = path.iter().flat_map(|&h| [h, work.mesh.twin[h as usize]]).collect();
        let (motion, _) = rigid_motion(work, &path)?;
        let deal = deal_anew(work, [a, b], &seam)?;
        let owner = |f: u32| deal.owner(work, f);
        let mut toggled = BTreeSet::new();
        for h in deal.faces.keys().flat_map(|&f| 3 * f..3 * f + 3) {
            if let Some(t) = crossing(work, &seam, h) {
                let closed = owner(h / 3) == owner(t / 3);
                if closed != work.glued[h as usize] {
                    toggled.extend([h, t]);
                }
            }
        }
        Some(Self { charts: [a, b], deal, toggled, motion })
    }

    /// Faces that must be flattened.
    fn size(&self, work: &Patchwork) -> usize {
        self.charts.iter().map(|&c| work.faces[c as usize].len()).sum()
    }

    /// Deal the faces out and sew each chart's new ones on: the two charts, if the objective falls.
    fn solve(
        &self,
        work: &Patchwork,
        limits: &ChartLimits,
        run: &Run,
    ) -> Result<Option<[(Piece, Fit); 2]>, Canceled> {
        let [a, b] = self.charts;
        let all = work.faces[a as usize].iter().chain(&work.faces[b as usize]).copied();
        let (mut ours, mut theirs): (Vec<u32>, Vec<u32>) =
            all.partition(|&f| self.deal.owner(work, f) == a);
        ours.sort_unstable();
        theirs.sort_unstable();
        let (rotation, shift) = self.motion;
        let back = (rotation.transpose(), -(rotation.transpose() * shift));
        // The second is not needed where the first has no map.
        let missed = AtomicBool::new(false);
        let first = || {
            let sewn = self.sew(work, ours, b, self.motion, limits, run)?;
            missed.store(sewn.1.is_none(), Ordering::Relaxed);
            Ok(sewn)
        };
        let second = || {
            let needed = !missed.load(Ordering::Relaxed);
            needed.then(|| self.sew(work, theirs, a, back, limits, run)).transpose()
        };
        let (ours, theirs) = tasks::join("sides of a seam", first, second);
        let (ours, theirs) = (ours?, theirs?);
        // What is moved at the same time has no face in common.
        let note = |(piece, found): (Piece, Option<Fit>)| {
            work.known.note(&piece, limits.bound, found).map(|fit| (piece, fit))
        };
        let new = note(ours).zip(theirs).and_then(|(ours, theirs)| Some([ours, note(theirs)?]));
        let spent = |new: &[(Piece, Fit); 2]| -> f64 {
            new.iter().map(|(piece, fit)| fit.energy * piece.disk.area()).sum()
        };
        let before = work.energy[a as usize] + work.energy[b as usize];
        Ok(new.filter(|new| spent(new) < before + limits.worth * self.deal.saved))
    }

    /// Faces of the two charts as one, those of chart `moved` moved to it, and what came of it.
    fn sew(
        &self,
        work: &Patchwork,
        faces: Vec<u32>,
        moved: u32,
        motion: Motion,
        limits: &ChartLimits,
        run: &Run,
    ) -> Result<(Piece, Option<Fit>), Canceled> {
        let glued = |h: u32| work.glued[h as usize] != self.toggled.contains(&h);
        let piece = work.mesh.cut_open_where(faces, glued);
        let found = match work.known.recall(&piece, limits.bound) {
            Some(known) => known,
            None => {
                let joined = lay_out(work, &piece, moved, Some(motion));
                refine(&piece.disk, joined, limits.bound, limits, run)?
            }
        };
        Ok((piece, found))
    }

    /// The two charts become the new ones.
    fn commit(&self, work: &mut Patchwork, new: &[(Piece, Fit); 2]) {
        for &h in &self.toggled {
            work.glued[h as usize] = !work.glued[h as usize];
        }
        for (chart, (piece, fit)) in self.charts.into_iter().zip(new) {
            work.take(chart, piece, fit);
        }
    }
}
