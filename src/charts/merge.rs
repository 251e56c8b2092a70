//! Patches joined to charts: the weld of the joint seams (pipeline 5a.3). Seam is closed a
//! path at a time, first where most is saved for the work it takes. A path is closed if the union stays within the distortion bound,
//! is proved injective, and the objective J = ΣA·SD/ΣA + λ Σℓc/√ΣA falls. Two disks joined along one
//! path are a disk, and so is a disk whose border is zipped from a tip. A slit whose two sides lie side
//! by side already is closed to a hole.
//!
//! A path that cannot be closed as a whole is tried again in two halves, parted where the surface is
//! bent most (largest angle defect): two faces of a box meet along one straight edge, the cap of a
//! prism along one of its many.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

use super::attempt::Attempt;
use super::candidates::{self, Candidate};
use super::limits::Limits;
use super::patchwork::Patchwork;
use crate::contract::{Canceled, Run};

/// Faces that all attempts together may flatten, per face of the part …
const WORK_PER_FACE: usize = 48;

/// … up to so many faces; beyond, an eighth of that.
const WORK_FACES: usize = 20_000;

/// Candidates; those that save most seam for the faces that must be flattened come first, so that small
/// charts are joined before large ones and the work is not spent on a few.
struct Queue {
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

impl Queue {
    fn versions(&self, candidate: &Candidate) -> [u32; 2] {
        [candidate.a, candidate.b].map(|c| self.version[c as usize])
    }

    /// Queue a candidate; one that failed before, in its halves.
    fn push(&mut self, work: &Patchwork, candidate: Candidate) {
        if self.failed.contains(&candidate.key(work)) {
            for half in candidate.halves(work, &self.defects) {
                self.push(work, half);
            }
            return;
        }
        let seam = candidate.cost(work);
        let other =
            if candidate.a == candidate.b { 0 } else { work.faces[candidate.b as usize].len() };
        let size = work.faces[candidate.a as usize].len() + other;
        self.heap
            .push(((seam / (size as f64).sqrt()).to_bits(), Reverse(self.waiting.len() as u32)));
        let versions = self.versions(&candidate);
        self.waiting.push(Some((candidate, versions)));
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
/// that may be.
pub fn merge(
    work: &mut Patchwork,
    among: &[u32],
    limits: &Limits,
    run: &Run,
) -> Result<(), Canceled> {
    let charts = work.faces.len();
    let mut queue = Queue {
        heap: BinaryHeap::new(),
        waiting: Vec::new(),
        version: vec![0; charts],
        failed: BTreeSet::new(),
        defects: candidates::angle_defects(work.mesh),
    };
    let faces: usize = among.iter().map(|&c| work.faces[c as usize].len()).sum();
    let mut allowance = 20_000 + WORK_PER_FACE * faces.min(WORK_FACES) + WORK_PER_FACE / 8 * faces;
    for &chart in among {
        for candidate in candidates::around(work, chart) {
            if candidate.b >= chart || among.binary_search(&candidate.b).is_err() {
                queue.push(work, candidate);
            }
        }
    }
    while let Some((candidate, seam)) = queue.pop(work) {
        run.cancel.check()?;
        let (a, b) = (candidate.a, candidate.b);
        let closed = match Attempt::prepare(work, &candidate, seam, limits) {
            None => false,
            Some(attempt) => {
                let size = work.faces[a as usize].len() + work.faces[b as usize].len();
                if size > allowance {
                    continue;
                }
                allowance -= size;
                attempt.close(work, limits, run)?
            }
        };
        if !closed {
            queue.failed.insert(candidate.key(work));
            queue.push(work, candidate);
            continue;
        }
        queue.version[a as usize] += 1;
        if a != b {
            queue.version[b as usize] += 1;
        }
        for candidate in candidates::around(work, a) {
            queue.push(work, candidate);
        }
    }
    Ok(())
}
