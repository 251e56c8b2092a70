//! One connected component of a part joined to charts (docs/method.md, 4.4 to 4.6): what the joining starts
//! from, rounds of joining charts and moving their seams, and other orders.

use super::joins::merge::merge;
use super::joins::rejoin::rejoin;
use super::limits::ChartLimits;
use super::limits::cost::edge_cost;
use super::limits::extent::{Extent, extent, fits_page};
use super::limits::fit::from_scratch;
use super::moves::compact::CUT_PRICE;
use super::moves::straighten::straighten;
use super::part_mesh::PartMesh;
use super::patches::patches;
use super::patches::sides::Side;
use super::patches::swept::swept;
use super::patchwork::Patchwork;
use crate::contract::{Canceled, GaveUp, Run, Stage};
use crate::device::Seeded;
use crate::flatten;
use crate::mesh::NONE;
use crate::tasks::beside;

/// Orders drawn at random in which a part is joined besides the first …
const RESTARTS: usize = 2;

/// … and faces that charts joined anew may have together, over those of the component …
const REJOINED: f64 = 6.0;

/// … of a surface of so many faces or fewer; one of more gets the fewer of them.
const RESTARTED_FACES: usize = 4_000;

/// One chart whose energy is below so many times what a chart is worth is taken without a look at others.
const PLAIN: f64 = 2.0;

/// Patches below which there is nothing to choose.
pub const LEAST_PATCHES: usize = 3;

/// Rounds of joining charts and moving their seams …
const ROUNDS: usize = 3;

/// … of a component of so many faces or fewer; one of more gets the fewer of them, but one.
const ROUND_FACES: usize = 60_000;

/// How components are joined.
pub struct Joiner<'a> {
    /// Orders to be tried besides the first.
    restarts: u64,
    /// Faces that charts joined anew may have, over those of a component.
    rejoined: f64,
    limits: &'a ChartLimits,
    run: &'a Run,
}

/// Objective Φ·ΣA of one connected component of a part, merged two ways; the lower one is kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orders {
    /// The baseline: by what is saved for the work it takes, or in the best of the orders drawn at random.
    pub baseline: f64,
    /// In the order that the soft map says.
    pub joint: f64,
}

impl<'a> Joiner<'a> {
    /// For components of a surface of so many faces.
    pub fn new(faces: usize, limits: &'a ChartLimits, run: &'a Run) -> Self {
        let restarts = (RESTARTS * RESTARTED_FACES / faces.max(1)).min(RESTARTS) as u64;
        let rejoined = REJOINED * (RESTARTED_FACES as f64 / faces.max(1) as f64).min(1.0);
        Self { restarts, rejoined, limits, run }
    }

    /// In one order alone.
    pub fn once(limits: &'a ChartLimits, run: &'a Run) -> Self {
        Self { restarts: 0, rejoined: 0.0, limits, run }
    }

    /// What the merging of a component starts from, and what it comes to: of the component as one chart, its
    /// patches, and the strips of a tube along a curve the best.
    pub fn first<'m>(
        &self,
        mesh: &'m PartMesh<'m>,
        sides: &[Side],
    ) -> Result<(Patchwork<'m>, Patchwork<'m>), Canceled> {
        let (limits, run) = (self.limits, self.run);
        let least = PLAIN * limits.worth * limits.chart;
        let whole = match whole(mesh, limits, run)? {
            Some(whole) if whole.energy[0] <= least => return Ok((whole.clone(), whole)),
            other => other,
        };
        let begun = |sides: &[Side]| {
            let work = patchwork(mesh, sides, limits, run)?;
            let joined = join(work.clone(), None, limits, run)?;
            Ok((work, joined))
        };
        let strips = || {
            let strips = swept(mesh, limits, run)?;
            (!strips.is_empty()).then(|| begun(&strips)).transpose()
        };
        let early = |is_late: &(dyn Fn() -> bool + Sync)| {
            (sides.is_empty() && !is_late()).then(strips).transpose()
        };
        let (patches, early) = beside("start", || begun(sides), early);
        let (mut best, early) = (patches?, early?);
        let better =
            |other: &Patchwork, than: &Patchwork| balance(other, limits) < balance(than, limits);
        if let Some(whole) = whole.filter(|whole| better(whole, &best.1)) {
            best = (whole.clone(), whole);
        }
        if sides.is_empty() && count(&best.1) >= LEAST_PATCHES {
            let strips = early.map_or_else(strips, Ok)?;
            if let Some(strips) = strips.filter(|strips| better(&strips.1, &best.1)) {
                best = strips;
            }
        }
        Ok(best)
    }

    /// The best of the first result and those in other orders.
    pub fn reordered<'m>(
        &self,
        work: &Patchwork<'m>,
        mut best: Patchwork<'m>,
    ) -> Result<Patchwork<'m>, Canceled> {
        let (mesh, limits, run) = (work.mesh, self.limits, self.run);
        if work.faces.len() >= LEAST_PATCHES {
            for k in 0..self.restarts {
                if run.skips(Stage::Charts, GaveUp::Joining) {
                    break;
                }
                let mut random = Seeded::new(0, k);
                let order: Vec<f32> = mesh.twin.iter().map(|_| random.unit_f64() as f32).collect();
                let other = join(work.clone(), Some(&order), limits, run)?;
                if balance(&other, limits) < balance(&best, limits) {
                    best = other;
                }
            }
            let allowance = (self.rejoined * mesh.len() as f64) as usize;
            let cost = |work: &Patchwork| balance(work, limits);
            best = rejoin(best, &work.chart_of, cost, allowance, limits, run)?;
        }
        Ok(best)
    }

    /// The better of a result and that in the order which a soft map says, and how they compare. `openness`: one a
    /// half-edge of the component.
    pub fn guided<'m>(
        &self,
        work: Patchwork<'m>,
        best: Patchwork<'m>,
        openness: &[f32],
    ) -> Result<(Patchwork<'m>, Orders), Canceled> {
        let (limits, run) = (self.limits, self.run);
        let other = join(work, Some(openness), limits, run)?;
        let (baseline, joint) = (objective(&best, limits), objective(&other, limits));
        let better = if joint < baseline { other } else { best };
        Ok((better, Orders { baseline, joint }))
    }
}

/// What merging starts from: the sides of a tube and patches, each with its map.
pub fn patchwork<'a>(
    mesh: &'a PartMesh<'a>,
    sides: &[Side],
    limits: &ChartLimits,
    run: &Run,
) -> Result<Patchwork<'a>, Canceled> {
    let (patch_of, glued, fits) = patches(mesh, sides, limits, run)?;
    let mut work = Patchwork::new(mesh, patch_of, glued);
    for (chart, (piece, fit)) in (0u32..).zip(&fits) {
        work.place(chart, piece, fit);
    }
    Ok(work)
}

/// A disk as one chart, if that is within the bound and fits a page.
fn whole<'a>(
    mesh: &'a PartMesh<'a>,
    limits: &ChartLimits,
    run: &Run,
) -> Result<Option<Patchwork<'a>>, Canceled> {
    let glued: Vec<bool> = mesh.twin.iter().map(|&t| t != NONE).collect();
    let piece = mesh.cut_open((0..mesh.len() as u32).collect(), &glued);
    if !flatten::is_disk(&piece.disk) {
        return Ok(None);
    }
    let fit = from_scratch(&piece.disk, limits.bound, limits, run)?;
    Ok(fit.filter(|fit| fits_page(&extent(&fit.uv), piece.disk.area(), limits)).map(|fit| {
        let mut work = Patchwork::new(mesh, vec![0; mesh.len()], glued);
        work.place(0, &piece, &fit);
        work
    }))
}

/// Rounds of joining charts and moving their seams.
fn join<'a>(
    mut work: Patchwork<'a>,
    openness: Option<&[f32]>,
    limits: &ChartLimits,
    run: &Run,
) -> Result<Patchwork<'a>, Canceled> {
    let all: Vec<u32> = (0..work.faces.len() as u32).collect();
    let mut changed = all.clone();
    let rounds = (ROUNDS * ROUND_FACES / work.mesh.len().max(1)).clamp(1, ROUNDS);
    for _ in 0..rounds {
        merge(&mut work, &changed, openness, limits, run)?;
        changed = straighten(&mut work, &all, limits, run)?;
        if changed.is_empty() {
            break;
        }
    }
    Ok(work)
}

/// Φ·ΣA of a component: energy, and what its seams and its charts are worth.
fn objective(work: &Patchwork, limits: &ChartLimits) -> f64 {
    let open = |h: &u32| {
        let t = work.mesh.twin[*h as usize];
        t != NONE && *h < t && !work.glued[*h as usize]
    };
    let half_edges = 0..work.mesh.twin.len() as u32;
    let seam: f64 = half_edges.filter(open).map(|h| edge_cost(work.mesh, h)).sum();
    let charts = count(work) as f64;
    work.energy.iter().sum::<f64>() + limits.worth * (seam + limits.chart * charts)
}

/// What whole results are compared by: the objective, what their charts leave empty of the page, at the price
/// at which a chart would be cut for it, and their energy once more, so that what is found by trying often is
/// paid for neither by the one nor by the other.
fn balance(work: &Patchwork, limits: &ChartLimits) -> f64 {
    let empty = |(extent, area): (&Extent, &f64)| (extent.rectangle - area).max(0.0);
    let empty: f64 = work.extent.iter().zip(&work.area).map(empty).sum();
    let energy: f64 = work.energy.iter().sum();
    objective(work, limits) + energy + limits.worth * empty / (CUT_PRICE * limits.size)
}

/// How many charts there are.
fn count(work: &Patchwork) -> usize {
    work.faces.iter().filter(|faces| !faces.is_empty()).count()
}
