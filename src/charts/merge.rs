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

use glam::{DMat2, DVec2};

use super::candidates::{self, Candidate};
use super::extent::{self, Extent};
use super::fit::refine;
use super::limits::Limits;
use super::patchwork::{Patchwork, next};
use crate::contract::{Canceled, Run};
use crate::flatten::UvMap;

/// A path whose two sides differ by more than this share of its length (rms, after the best rigid
/// motion) is not worth a solve.
const MISMATCH: f64 = 0.12;

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

/// Close paths until none is left that may be.
pub fn merge(work: &mut Patchwork, limits: &Limits, run: &Run) -> Result<(), Canceled> {
    let charts = work.faces.len();
    let mut queue = Queue {
        heap: BinaryHeap::new(),
        waiting: Vec::new(),
        version: vec![0; charts],
        failed: BTreeSet::new(),
        defects: candidates::angle_defects(work.mesh),
    };
    let faces = work.mesh.len();
    let mut allowance = 20_000 + WORK_PER_FACE * faces.min(WORK_FACES) + WORK_PER_FACE / 8 * faces;
    for chart in 0..charts as u32 {
        for candidate in candidates::around(work, chart) {
            if candidate.b >= chart {
                queue.push(work, candidate);
            }
        }
    }
    while let Some((candidate, seam)) = queue.pop(work) {
        run.cancel.check()?;
        let (a, b) = (candidate.a, candidate.b);
        let closed = match Attempt::prepare(work, &candidate) {
            None => false,
            Some(attempt) => {
                let size = work.faces[a as usize].len() + work.faces[b as usize].len();
                if size > allowance {
                    continue;
                }
                allowance -= size;
                attempt.close(work, &candidate, seam, limits, run)?
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

/// A union that is worth a solve.
struct Attempt {
    /// Rotation and shift that lay the other chart next to this one; none for a zip.
    motion: Option<(DMat2, DVec2)>,
}

impl Attempt {
    fn prepare(work: &Patchwork, candidate: &Candidate) -> Option<Self> {
        if candidate.a != candidate.b {
            return rigid_motion(work, &candidate.path).map(|m| Self { motion: Some(m) });
        }
        // A slit is closed where its sides all but touch: what is round stays open.
        let close = candidate.zip || gap(work, &candidate.path) <= MISMATCH;
        close.then_some(Self { motion: None })
    }

    /// Try to close the path. On success the union is chart `a`.
    fn close(
        self,
        work: &mut Patchwork,
        candidate: &Candidate,
        seam: f64,
        limits: &Limits,
        run: &Run,
    ) -> Result<bool, Canceled> {
        let (a, b) = (candidate.a, candidate.b);
        let mut path = candidate.path.clone();
        if let Some(motion) = self.motion {
            path.extend(touching(work, candidate, motion, limits.clearance));
        }
        work.set_glued(&path, true);
        let mut faces = work.faces[a as usize].clone();
        let mut spent = work.energy[a as usize];
        let mut saved = seam;
        if a != b {
            faces.extend_from_slice(&work.faces[b as usize]);
            faces.sort_unstable();
            spent += work.energy[b as usize];
            saved += limits.chart;
        }
        let piece = work.mesh.cut_open(faces, &work.glued);
        // Warm map: every vertex at the mean of its corners, `b` moved next to `a`.
        let mut sum = vec![(DVec2::ZERO, 0.0); piece.disk.positions.len()];
        for (&f, triangle) in piece.faces.iter().zip(&piece.disk.triangles) {
            let theirs = self.motion.filter(|_| work.chart_of[f as usize] == b);
            for (k, &v) in triangle.iter().enumerate() {
                let at = work.uv[3 * f as usize + k];
                let at = theirs.map_or(at, |(rotation, shift)| rotation * at + shift);
                let entry = &mut sum[v as usize];
                *entry = (entry.0 + at, entry.1 + 1.0);
            }
        }
        let warm: UvMap = sum.into_iter().map(|(total, count)| total / count).collect();
        let area = piece.disk.area();
        if a != b && !is_compact(work, candidate, &extent::extent(&warm), area, limits) {
            work.set_glued(&path, false);
            return Ok(false);
        }
        let allowed = ((spent + limits.worth * saved) / area).min(limits.bound);
        let Some(fit) = refine(&piece.disk, warm, allowed, limits.clearance, run)? else {
            work.set_glued(&path, false);
            return Ok(false);
        };
        if a != b {
            work.absorb(a, b);
        }
        work.place(a, &piece, &fit);
        Ok(true)
    }
}

/// Whether a page can be filled with such unions: not too long, and the rectangle around it filled
/// well, or no worse than those of the two charts.
fn is_compact(
    work: &Patchwork,
    candidate: &Candidate,
    union: &Extent,
    area: f64,
    limits: &Limits,
) -> bool {
    let [a, b] = [candidate.a, candidate.b].map(|c| work.extent[c as usize]);
    let waste = |c: u32| work.extent[c as usize].rectangle - work.area[c as usize];
    let wasted = waste(candidate.a) + waste(candidate.b);
    union.length <= a.length.max(b.length).max(limits.length)
        && union.rectangle - area <= wasted.max(limits.waste * area)
}

/// Other edges between two charts whose two sides come to lie on each other with the same motion.
fn touching(
    work: &Patchwork,
    candidate: &Candidate,
    (rotation, shift): (DMat2, DVec2),
    clearance: f64,
) -> Vec<u32> {
    let meets = |near: u32, far: u32| {
        let far = rotation * work.uv[far as usize] + shift;
        far.distance(work.uv[near as usize]) < clearance
    };
    let half_edges = work.faces[candidate.a as usize].iter().flat_map(|&f| 3 * f..3 * f + 3);
    half_edges
        .filter(|h| !work.glued[*h as usize] && !candidate.path.contains(h))
        .filter(|&h| work.across(h) == Some(candidate.b))
        .filter(|&h| {
            let t = work.mesh.twin[h as usize];
            meets(h, next(t)) && meets(next(h), t)
        })
        .collect()
}

/// Distance (rms) between the two sides of a path, as a share of its length.
fn gap(work: &Patchwork, path: &[u32]) -> f64 {
    let (mut sum, mut length) = (0.0, 0.0);
    for &h in path {
        let t = work.mesh.twin[h as usize];
        sum += work.uv[h as usize].distance_squared(work.uv[next(t) as usize]);
        sum += work.uv[next(h) as usize].distance_squared(work.uv[t as usize]);
        length += work.mesh.length(h);
    }
    (sum / (2.0 * path.len() as f64)).sqrt() / length
}

/// The rotation and shift that lay the far side of a path best onto its near side, unless they
/// differ too much to be worth a solve.
fn rigid_motion(work: &Patchwork, path: &[u32]) -> Option<(DMat2, DVec2)> {
    let mut pairs = Vec::with_capacity(2 * path.len());
    let mut length = 0.0;
    for &h in path {
        let t = work.mesh.twin[h as usize];
        let (h, t) = (h as usize, t as usize);
        pairs.push((work.uv[h], work.uv[next(t as u32) as usize]));
        pairs.push((work.uv[next(h as u32) as usize], work.uv[t]));
        length += work.mesh.length(h as u32);
    }
    let n = pairs.len() as f64;
    let near = pairs.iter().map(|p| p.0).sum::<DVec2>() / n;
    let far = pairs.iter().map(|p| p.1).sum::<DVec2>() / n;
    let (mut dot, mut perp) = (0.0, 0.0);
    for (p, q) in &pairs {
        dot += (q - far).dot(p - near);
        perp += (q - far).perp_dot(p - near);
    }
    let rotation = DMat2::from_angle(perp.atan2(dot));
    let shift = near - rotation * far;
    let error: f64 = pairs.iter().map(|(p, q)| (rotation * *q + shift - *p).length_squared()).sum();
    ((error / n).sqrt() <= MISMATCH * length).then_some((rotation, shift))
}
