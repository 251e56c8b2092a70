//! A proposal to close a path of seam: the cheap questions first (do the two sides fit, is the union
//! compact, do the charts run into each other), the solve last.

use std::collections::BTreeSet;

use glam::{DMat2, DVec2};

use super::candidates::Candidate;
use super::collision::collide;
use crate::charts::limits::ChartLimits;
use crate::charts::limits::extent::{self, Extent};
use crate::charts::limits::fit::{Fit, Joined, refine};
use crate::charts::part_mesh::Piece;
use crate::charts::patchwork::{Patchwork, next};
use crate::contract::{Canceled, Run};
use crate::tasks;

/// A path whose two sides differ by more than this share of its length (rms, after the best rigid
/// motion) is not worth a solve.
const MISMATCH: f64 = 0.12;

/// Nor is one whose mean squared misfit is more than this many times the energy (times area) that
/// closing it may cost. Of the unions that were accepted without this limit none had more than 1.8.
const TEAR: f64 = 3.0;

/// Depth to which charts may run into each other and still be worth a solve, over the length of the
/// smaller …
const DEPTH: f64 = 0.03;

/// … and over the misfit (rms).
const DEPTH_MISFIT: f64 = 3.0;

/// Rotation and shift.
pub type Motion = (DMat2, DVec2);

/// A union that is worth a solve.
pub struct Proposal {
    /// The path.
    pub candidate: Candidate,
    /// What lays the other chart next to this one; none for a zip.
    motion: Option<Motion>,
    /// Energy (times area) that the union may have.
    allowed: f64,
}

/// What closing a path would come to.
pub struct Solved {
    /// Half-edges that are closed.
    path: Vec<u32>,
    /// The union.
    piece: Piece,
    /// Its map, if it has one within the bound; `None` where that was known already.
    found: Option<Option<Fit>>,
}

impl Proposal {
    /// `None` where it is plain without a solve that the path cannot be closed.
    pub fn prepare(work: &Patchwork, candidate: &Candidate, limits: &ChartLimits) -> Option<Self> {
        let seam = candidate.cost(work);
        let [a, b] = [candidate.a, candidate.b].map(|c| c as usize);
        if a == b {
            // A slit is closed where its sides all but touch: what is round stays open.
            let close = candidate.zip || gap(work, &candidate.path) <= MISMATCH;
            let allowed = work.energy[a] + limits.worth * seam;
            let allowed = allowed.min(limits.bound * work.area[a]);
            let candidate = candidate.clone();
            return close.then_some(Self { candidate, motion: None, allowed });
        }
        let (motion, misfit) = rigid_motion(work, &candidate.path)?;
        let (area, spent) = (work.area[a] + work.area[b], work.energy[a] + work.energy[b]);
        let saved = limits.worth * (seam + limits.chart);
        let allowed = (spent + saved).min(limits.bound * area);
        if misfit > TEAR * (allowed - spent) {
            return None;
        }
        let near: Vec<Vec<DVec2>> = work.outline(candidate.a).collect();
        let moved = |ring: Vec<DVec2>| ring.into_iter().map(|p| motion.0 * p + motion.1).collect();
        let far: Vec<Vec<DVec2>> = work.outline(candidate.b).map(moved).collect();
        let corners: Vec<DVec2> = near.iter().chain(&far).flatten().copied().collect();
        if !is_compact(work, candidate, &extent::extent(&corners), area, limits) {
            return None;
        }
        let shorter = work.extent[a].length.min(work.extent[b].length);
        let depth = DEPTH * shorter + DEPTH_MISFIT * misfit.sqrt();
        let apart = !collide(&near, &far, depth);
        let candidate = candidate.clone();
        apart.then_some(Self { candidate, motion: Some(motion), allowed })
    }

    /// What closing the path comes to. Changes nothing.
    pub fn solve(
        &self,
        work: &Patchwork,
        limits: &ChartLimits,
        run: &Run,
    ) -> Result<Solved, Canceled> {
        let (a, b) = (self.candidate.a, self.candidate.b);
        let mut path = self.candidate.path.clone();
        if let Some(motion) = self.motion {
            path.extend(touching(work, &self.candidate, motion, limits.clearance));
        }
        let twin = |&h: &u32| work.mesh.twin[h as usize];
        let closed: BTreeSet<u32> = path.iter().map(|h| twin(h).min(*h)).collect();
        let mut faces = work.faces[a as usize].clone();
        if a != b {
            faces.extend_from_slice(&work.faces[b as usize]);
            faces.sort_unstable();
        }
        let glued = |h: u32| work.glued[h as usize] || closed.contains(&h);
        let piece = tasks::link("open", || work.mesh.cut_open_where(faces, glued));
        let known = work.known.recall(&piece, self.bound(&piece)).is_some();
        let found = (!known).then(|| self.flatten(work, &piece, limits, run)).transpose()?;
        Ok(Solved { path, piece, found })
    }

    /// Mean energy that the union may have, minus 1.
    fn bound(&self, piece: &Piece) -> f64 {
        self.allowed / piece.disk.area()
    }

    fn flatten(
        &self,
        work: &Patchwork,
        piece: &Piece,
        limits: &ChartLimits,
        run: &Run,
    ) -> Result<Option<Fit>, Canceled> {
        let joined = lay_out(work, piece, self.candidate.b, self.motion);
        refine(&piece.disk, joined, self.bound(piece), limits, run)
    }

    /// Close the path, if that holds: the union becomes chart `a` of the candidate. Whether it was closed.
    pub fn decide(
        &self,
        solved: Solved,
        work: &mut Patchwork,
        limits: &ChartLimits,
        run: &Run,
    ) -> Result<bool, Canceled> {
        let Solved { path, piece, found } = solved;
        let bound = self.bound(&piece);
        // What others of the batch have noted by now comes before what was found beside them.
        let found = match (work.known.recall(&piece, bound), found) {
            (Some(known), _) => known,
            (None, Some(found)) => work.known.note(&piece, bound, found),
            (None, None) => {
                work.known.note(&piece, bound, self.flatten(work, &piece, limits, run)?)
            }
        };
        let Some(fit) = &found else { return Ok(false) };
        work.set_glued(&path, true);
        if self.candidate.a != self.candidate.b {
            work.absorb(self.candidate.a, self.candidate.b);
        }
        work.place(self.candidate.a, &piece, fit);
        Ok(true)
    }
}

/// The maps of the charts that a piece is made of, those of chart `moved` moved.
pub fn lay_out(work: &Patchwork, piece: &Piece, moved: u32, motion: Option<Motion>) -> Joined {
    let mut sum = vec![(DVec2::ZERO, 0.0); piece.disk.positions.len()];
    let mut frames = Vec::with_capacity(piece.faces.len());
    for ((&f, triangle), rest) in
        piece.faces.iter().zip(&piece.disk.triangles).zip(&piece.disk.rest)
    {
        let theirs = motion.filter(|_| work.chart_of[f as usize] == moved);
        let corners = [0, 1, 2].map(|k| {
            let at = work.uv[3 * f as usize + k];
            theirs.map_or(at, |(rotation, shift)| rotation * at + shift)
        });
        for (&v, at) in triangle.iter().zip(corners) {
            let entry = &mut sum[v as usize];
            *entry = (entry.0 + at, entry.1 + 1.0);
        }
        let [a, b, c] = corners;
        frames.push(DMat2::from_cols(b - a, c - a) * *rest);
    }
    Joined { uv: sum.into_iter().map(|(total, count)| total / count).collect(), frames }
}

/// Whether a page can be filled with such unions: not too long, and the rectangle around it filled
/// well, or no worse than those of the two charts.
fn is_compact(
    work: &Patchwork,
    candidate: &Candidate,
    union: &Extent,
    area: f64,
    limits: &ChartLimits,
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
    let path: BTreeSet<u32> = candidate.path.iter().copied().collect();
    let border = work.rims[candidate.a as usize].iter().flatten().copied();
    border
        .filter(|&h| work.across(h) == Some(candidate.b) && !path.contains(&h))
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

/// The rotation and shift that lay the far side of a path best onto its near side, and how far
/// (squared, mean) they are apart then; `None` where they differ too much to be worth a solve.
pub fn rigid_motion(work: &Patchwork, path: &[u32]) -> Option<(Motion, f64)> {
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
    let error = |(p, q): &(DVec2, DVec2)| (rotation * *q + shift - *p).length_squared();
    let misfit = pairs.iter().map(error).sum::<f64>() / n;
    (misfit.sqrt() <= MISMATCH * length).then_some(((rotation, shift), misfit))
}
