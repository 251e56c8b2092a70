//! Seams that nobody asked for: neither near a part boundary, nor at a crease, nor hidden.

use glam::DVec3;
use rayon::prelude::*;

use super::EdgeTable;
use super::alignment::SampledSeams;
use super::levels::Level;
use crate::contract::{Cancel, Canceled};
use crate::mesh::rays::Rays;
use crate::mesh::{NONE, Surface};
use crate::tasks;

/// A point that sees less of the sky is hidden.
const HIDDEN: f64 = 0.3;
/// Rays a point.
const RAYS: u32 = 32;
/// Most points from which rays are cast; the points between take their neighbour's answer.
const MOST_POINTS: usize = 4000;
/// Expected visits of the ray caster a ray for which that many are affordable.
const USUAL_VISITS: f64 = 300.0;

/// The avoidable share of every edge: 0 where it is not cut.
#[derive(Debug, Clone)]
pub(super) struct Avoidable(Vec<f64>);

/// Cuts of one edge that are looked at. Only a fan of faces about one edge has more; the first stand
/// for the others.
const MOST_CUTS: usize = 64;

/// A point on a cut that is neither near a boundary nor at a crease.
struct Candidate {
    edge: u32,
    share: f64,
    point: DVec3,
    normal: DVec3,
    /// Whether both sides of the surface may be seen: a face without a mate has no inside.
    both_sides: bool,
}

impl Avoidable {
    pub(super) fn new(
        surface: &Surface,
        table: &EdgeTable,
        seams: &SampledSeams,
        rays: &Rays,
        cancel: &Cancel,
    ) -> Result<Self, Canceled> {
        let mut candidates = vec![];
        // Cuts of an edge that part two twins; where the surface ends there is nothing to avoid.
        let mut pairs: Vec<(u32, u32)> = vec![];
        let (mut edge, mut weight) = (NONE, 0.0);
        for (s, _) in seams.samples.iter().zip(&seams.near).filter(|(_, near)| !**near) {
            if s.edge != edge {
                edge = s.edge;
                pairs.clear();
                pairs.extend(
                    table.cut_pairs(edge as usize, surface).filter(|p| !surface.is_crease(p.0)),
                );
                let all = pairs.len();
                pairs.truncate(MOST_CUTS);
                let cuts = (table.cuts[edge as usize] as usize).max(all);
                weight = all as f64 / (cuts * pairs.len()).max(1) as f64;
            }
            candidates.extend(pairs.iter().map(|&(h, t)| {
                let (f, g) = (h as usize / 3, t as usize / 3);
                Candidate {
                    edge,
                    share: s.share * weight,
                    point: s.point,
                    normal: surface.normals[f] + surface.normals[g],
                    both_sides: surface.sheet_mate[f] == NONE && surface.sheet_mate[g] == NONE,
                }
            }));
        }
        let dearer = (rays.expected_visits() / USUAL_VISITS).max(1.0);
        let points = (MOST_POINTS as f64 / dearer).ceil() as usize;
        let stride = candidates.len().div_ceil(points.max(1)).max(1);
        let seen: Vec<bool> = tasks::even("seen seams", candidates.len() / stride, || {
            candidates
                .par_chunks(stride)
                .enumerate()
                .map(|(i, chunk)| {
                    let c = &chunk[chunk.len() / 2];
                    let sees = |normal| {
                        rays.ambient_visibility(c.point, normal, RAYS, i as u64, NONE) >= HIDDEN
                    };
                    !cancel.is_canceled() && (sees(c.normal) || (c.both_sides && sees(-c.normal)))
                })
                .collect()
        });
        cancel.check()?;
        let mut shares = vec![0.0; table.len()];
        for (_, c) in candidates.iter().enumerate().filter(|(i, _)| seen[i / stride]) {
            shares[c.edge as usize] += c.share;
        }
        for share in &mut shares {
            *share = share.min(1.0);
        }
        Ok(Self(shares))
    }

    /// Avoidable seam length / seam length. `None` without seams.
    pub(super) fn of(&self, table: &EdgeTable, level: &Level) -> Option<f64> {
        let (avoidable, seam) = level
            .edges_with_cuts()
            .map(|(e, cuts)| (self.0[e], f64::from(cuts) * table.length[e]))
            .fold((0.0, 0.0), |(a, s), (share, length)| (a + share * length, s + length));
        (seam > 0.0).then(|| avoidable / seam)
    }
}
