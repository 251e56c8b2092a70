//! Patches merged to charts (docs/method.md, 4.4). Seam is closed a path at a time, first where most is
//! saved for the work it takes. A path is closed if the union stays within the distortion bound, is proved
//! injective, and the objective Φ = ΣA(SD − 1)/ΣA + λ(Σℓc/√ΣA + 0.05 · charts) falls. Two disks joined
//! along one path are a disk, and so is a disk whose border is zipped from a tip. A slit whose two sides
//! lie side by side already is closed to a hole.
//!
//! A path that cannot be closed as a whole is tried again in two halves, parted where the surface is
//! bent most (largest angle defect): two faces of a box meet along one straight edge, the cap of a
//! prism along one of its many.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

use rayon::prelude::*;

use super::candidates::{self, Candidate};
use super::proposal::Proposal;
use crate::charts::limits::ChartLimits;
use crate::charts::patchwork::Patchwork;
use crate::contract::{Canceled, GaveUp, Run, Stage};

/// Faces that all proposals together may flatten, per face of the part …
const WORK_PER_FACE: usize = 24;

/// … up to so many faces; beyond, a quarter of that.
const WORK_FACES: usize = 20_000;

/// Attempts that are solved at the same time.
const BATCH: usize = 4;

/// Candidates put off, for having a chart in common with a batch, before the batch is solved as it is.
const AHEAD: usize = 16;

/// Candidates; those that save most seam for the faces that must be flattened come first, so that small
/// charts are joined before large ones and the work is not spent on a few.
struct Queue<'a> {
    /// How far a soft map has left each half-edge open, where that decides.
    openness: Option<&'a [f32]>,
    heap: BinaryHeap<(u64, Reverse<u32>)>,
    /// Each with the versions of its charts when it was found.
    waiting: Vec<Option<(Candidate, [u32; 2])>>,
    /// How often each chart has changed.
    version: Vec<u32>,
    /// Seams that could not be closed.
    failed: BTreeSet<(u32, u32)>,
    /// Angle defects of the part.
    defects: Vec<f64>,
}

impl Queue<'_> {
    fn versions(&self, candidate: &Candidate) -> [u32; 2] {
        [candidate.a, candidate.b].map(|c| self.version[c as usize])
    }

    /// How far a soft map has closed a path, 0 to 1; 1 where there is none.
    fn closed(&self, path: &[u32]) -> f64 {
        let Some(openness) = self.openness else { return 1.0 };
        let known = path.iter().map(|&h| f64::from(openness[h as usize])).filter(|o| !o.is_nan());
        let (sum, count) = known.fold((0.0, 0u32), |(s, n), o| (s + o, n + 1));
        if count > 0 { 1.0 - sum / f64::from(count) } else { 1.0 }
    }

    /// Queue a candidate; one that failed before, in its halves.
    fn push(&mut self, work: &Patchwork, candidate: Candidate) {
        if self.failed.contains(&candidate.key(work)) {
            for half in candidate.halves(work, &self.defects) {
                self.push(work, half);
            }
            return;
        }
        let seam = candidate.cost(work) * self.closed(&candidate.path);
        let worth = seam / (candidate.size(work) as f64).sqrt();
        self.heap.push((worth.to_bits(), Reverse(self.waiting.len() as u32)));
        let versions = self.versions(&candidate);
        self.waiting.push(Some((candidate, versions)));
    }

    /// A seam that cannot be closed is tried again in its halves.
    fn fail(&mut self, work: &Patchwork, candidate: Candidate) {
        self.failed.insert(candidate.key(work));
        self.push(work, candidate);
    }

    /// The next proposals that are worth a solve, no two of them with a chart in common, so that they can
    /// be solved at the same time; what they take is taken off the allowance.
    fn batch(
        &mut self,
        work: &Patchwork,
        limits: &ChartLimits,
        allowance: &mut usize,
    ) -> Vec<Proposal> {
        let (mut batch, mut busy, mut later) = (Vec::new(), BTreeSet::new(), Vec::new());
        while batch.len() < BATCH && later.len() < AHEAD {
            let Some((candidate, seam)) = self.pop(work) else { break };
            if busy.contains(&candidate.a) || busy.contains(&candidate.b) {
                later.push(candidate);
                continue;
            }
            let Some(proposal) = Proposal::prepare(work, &candidate, seam, limits) else {
                self.fail(work, candidate);
                continue;
            };
            if let Some(left) = allowance.checked_sub(proposal.candidate.size(work)) {
                *allowance = left;
                busy.extend([candidate.a, candidate.b]);
                batch.push(proposal);
            }
        }
        later.into_iter().for_each(|candidate| self.push(work, candidate));
        batch
    }

    /// The next seam between charts that have not changed since, and its cost.
    fn pop(&mut self, work: &Patchwork) -> Option<(Candidate, f64)> {
        while let Some((_, Reverse(id))) = self.heap.pop() {
            let Some((candidate, versions)) = self.waiting[id as usize].take() else { continue };
            if versions == self.versions(&candidate) && !self.failed.contains(&candidate.key(work))
            {
                let seam = candidate.cost(work);
                return Some((candidate, seam));
            }
        }
        None
    }
}

/// Close paths about the charts in `among` (ascending), and about what becomes of them, until none is left
/// that may be. With an `openness` (0 to 1, one a local half-edge) those that are closed already come first.
pub fn merge(
    work: &mut Patchwork,
    among: &[u32],
    openness: Option<&[f32]>,
    limits: &ChartLimits,
    run: &Run,
) -> Result<(), Canceled> {
    let charts = work.faces.len();
    let mut queue = Queue {
        openness,
        heap: BinaryHeap::new(),
        waiting: Vec::new(),
        version: vec![0; charts],
        failed: BTreeSet::new(),
        defects: candidates::angle_defects(work.mesh),
    };
    let faces: usize = among.iter().map(|&c| work.faces[c as usize].len()).sum();
    let mut allowance = 20_000 + WORK_PER_FACE * faces.min(WORK_FACES) + WORK_PER_FACE / 4 * faces;
    for &chart in among {
        for candidate in candidates::around(work, chart) {
            if candidate.b >= chart || among.binary_search(&candidate.b).is_err() {
                queue.push(work, candidate);
            }
        }
    }
    loop {
        run.cancel.check()?;
        let batch = queue.batch(work, limits, &mut allowance);
        if batch.is_empty() || run.skips(Stage::Charts, GaveUp::Joining) {
            break;
        }
        let solved: Result<Vec<_>, Canceled> =
            batch.par_iter().map(|proposal| proposal.solve(work, limits, run)).collect();
        for (Proposal { candidate, .. }, union) in batch.into_iter().zip(solved?) {
            let Some(union) = union else {
                queue.fail(work, candidate);
                continue;
            };
            union.commit(work, &candidate);
            queue.version[candidate.a as usize] += 1;
            if candidate.a != candidate.b {
                queue.version[candidate.b as usize] += 1;
            }
            for candidate in candidates::around(work, candidate.a) {
                queue.push(work, candidate);
            }
        }
    }
    Ok(())
}
