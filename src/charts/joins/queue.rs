//! Paths of seam that wait to be closed; those that save most seam for the faces that must be flattened come
//! first, so that small charts are joined before large ones and the work is not spent on a few.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

use super::candidates::{self, Candidate};
use crate::charts::patchwork::Patchwork;

/// Rank in the queue, and the number of a candidate.
type Place = (u64, Reverse<u32>);

/// A candidate that waits.
pub struct Waiting {
    /// The path.
    pub candidate: Candidate,
    place: Place,
    /// Those of its charts when it was found.
    versions: [u32; 2],
}

/// Candidates.
pub struct Queue<'a> {
    /// How far a soft map has left each half-edge open, where that decides.
    openness: Option<&'a [f32]>,
    heap: BinaryHeap<Place>,
    waiting: Vec<Option<Waiting>>,
    /// How often each chart has changed.
    version: Vec<u32>,
    /// Seams that could not be closed.
    failed: BTreeSet<(u32, u32)>,
    /// Angle defects of the part.
    defects: Vec<f64>,
}

impl<'a> Queue<'a> {
    /// The paths about the charts in `among` (ascending).
    pub fn new(work: &Patchwork, among: &[u32], openness: Option<&'a [f32]>) -> Self {
        let mut queue = Self {
            openness,
            heap: BinaryHeap::new(),
            waiting: Vec::new(),
            version: vec![0; work.faces.len()],
            failed: BTreeSet::new(),
            defects: candidates::angle_defects(work.mesh),
        };
        for &chart in among {
            for candidate in candidates::around(work, chart) {
                if candidate.b >= chart || among.binary_search(&candidate.b).is_err() {
                    queue.push(work, candidate);
                }
            }
        }
        queue
    }

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
        let place = (worth.to_bits(), Reverse(self.waiting.len() as u32));
        let versions = self.versions(&candidate);
        self.heap.push(place);
        self.waiting.push(Some(Waiting { candidate, place, versions }));
    }

    /// Put back what was popped, where it was.
    pub fn put_back(&mut self, waiting: Waiting) {
        self.heap.push(waiting.place);
        let Reverse(number) = waiting.place.1;
        self.waiting[number as usize] = Some(waiting);
    }

    /// A seam that cannot be closed is tried again in its halves.
    pub fn fail(&mut self, work: &Patchwork, candidate: Candidate) {
        self.failed.insert(candidate.key(work));
        self.push(work, candidate);
    }

    /// A path was closed, and its charts are now the first of them.
    pub fn joined(&mut self, work: &Patchwork, candidate: &Candidate) {
        for chart in BTreeSet::from([candidate.a, candidate.b]) {
            self.version[chart as usize] += 1;
        }
        for candidate in candidates::around(work, candidate.a) {
            self.push(work, candidate);
        }
    }

    /// The next seam between charts that have not changed since.
    pub fn pop(&mut self, work: &Patchwork) -> Option<Waiting> {
        while let Some((_, Reverse(number))) = self.heap.pop() {
            let Some(waiting) = self.waiting[number as usize].take() else { continue };
            let same = waiting.versions == self.versions(&waiting.candidate);
            if same && !self.failed.contains(&waiting.candidate.key(work)) {
                return Some(waiting);
            }
        }
        None
    }
}
