//! Patches merged to charts (docs/method.md, 4.4). Seam is closed a path at a time, first where most is
//! saved for the work it takes. A path is closed if the union stays within the distortion bound, is proved
//! injective, and the objective Φ = ΣA(SD − 1)/ΣA + λ(Σℓc/√ΣA + 0.05 · charts) falls. Two disks joined
//! along one path are a disk, and so is a disk whose border is zipped from a tip. A slit whose two sides
//! lie side by side already is closed to a hole.
//!
//! A path that cannot be closed as a whole is tried again in two halves, parted where the surface is
//! bent most (largest angle defect): two faces of a box meet along one straight edge, the cap of a
//! prism along one of its many.
//!
//! Paths that have no chart in common are solved at the same time and decided in turn. None is solved ahead of its
//! turn: recorded, what was begun so and waited for made the longest chain of tasks longer, at any number of
//! threads (docs/results.md).

use std::collections::BTreeSet;

use super::proposal::Proposal;
use super::queue::{Queue, Waiting};
use crate::charts::limits::ChartLimits;
use crate::charts::patchwork::Patchwork;
use crate::contract::{Canceled, GaveUp, Run, Stage};
use crate::tasks;

/// Faces that all proposals together may flatten, per face of the charts …
const WORK_PER_FACE: usize = 24;

/// … up to so many faces; beyond, a quarter of that …
const WORK_FACES: usize = 20_000;

/// … and those of large unions that do not hold, as most …
const LARGE_PER_FACE: usize = 8;

/// … which have more than this share of the faces.
const LARGE: f64 = 0.125;

/// Paths that are decided together.
const BATCH: usize = 4;

/// Paths put off, for having a chart in common with a batch, before the batch is solved as it is.
const AHEAD: usize = 16;

/// Close paths about the charts in `among` (ascending), and about what becomes of them, until none is left
/// that may be. With an `openness` (0 to 1, one a local half-edge) those that are closed already come first.
pub fn merge(
    work: &mut Patchwork,
    among: &[u32],
    openness: Option<&[f32]>,
    limits: &ChartLimits,
    run: &Run,
) -> Result<(), Canceled> {
    let mut queue = Queue::new(work, among, openness);
    let faces: usize = among.iter().map(|&c| work.faces[c as usize].len()).sum();
    let mut allowance = Allowance::of(faces);
    loop {
        run.cancel.check()?;
        let (batch, later) = next(&mut queue, work, limits, &mut allowance);
        if batch.is_empty() || run.skips(Stage::Charts, GaveUp::Joining) {
            break;
        }
        later.into_iter().for_each(|waiting| queue.put_back(waiting));
        let solved = tasks::map("union", &batch, |(_, proposal)| proposal.solve(work, limits, run));
        for ((Waiting { candidate, .. }, proposal), solved) in batch.into_iter().zip(solved) {
            let size = candidate.size(work);
            if proposal.decide(solved?, work, limits, run)? {
                allowance.held(size);
                queue.joined(work, &candidate);
            } else {
                queue.fail(work, candidate);
            }
        }
    }
    Ok(())
}

/// Faces that may still be flattened.
struct Allowance {
    faces: usize,
    /// A union of more is large.
    large: usize,
    /// Those of large unions that do not hold.
    faces_of_large: usize,
}

impl Allowance {
    /// For charts of so many faces.
    fn of(faces: usize) -> Self {
        let few = faces.min(WORK_FACES);
        Self {
            faces: 20_000 + WORK_PER_FACE * few + WORK_PER_FACE / 4 * faces,
            large: (LARGE * faces as f64) as usize,
            faces_of_large: 20_000 + LARGE_PER_FACE * faces,
        }
    }

    fn of_large(&self, faces: usize) -> usize {
        if faces > self.large { faces } else { 0 }
    }

    /// Take off a union of so many faces, if it lasts for it.
    fn take(&mut self, faces: usize) -> bool {
        let of_large = self.of_large(faces);
        let lasts = faces <= self.faces && of_large <= self.faces_of_large;
        if lasts {
            self.faces -= faces;
            self.faces_of_large -= of_large;
        }
        lasts
    }

    /// The union of so many faces holds.
    fn held(&mut self, faces: usize) {
        self.faces_of_large += self.of_large(faces);
    }
}

/// The next paths that are worth a solve, no two of them with a chart in common, and those between them that were
/// put off. What they take is taken off the allowance.
fn next(
    queue: &mut Queue,
    work: &Patchwork,
    limits: &ChartLimits,
    allowance: &mut Allowance,
) -> (Vec<(Waiting, Proposal)>, Vec<Waiting>) {
    let (mut batch, mut busy, mut later) = (Vec::new(), BTreeSet::new(), Vec::new());
    while batch.len() < BATCH && later.len() < AHEAD {
        let Some(waiting) = queue.pop(work) else { break };
        let [a, b] = [waiting.candidate.a, waiting.candidate.b];
        if busy.contains(&a) || busy.contains(&b) {
            later.push(waiting);
            continue;
        }
        let Some(proposal) = Proposal::prepare(work, &waiting.candidate, limits) else {
            queue.fail(work, waiting.candidate);
            continue;
        };
        if allowance.take(waiting.candidate.size(work)) {
            busy.extend([a, b]);
            batch.push((waiting, proposal));
        }
    }
    (batch, later)
}
