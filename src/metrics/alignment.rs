//! Seams against part boundaries: the share of seam that runs near a boundary, the share of boundary
//! that is seam, and what both allow. Near is 1 % of the diagonal.

use glam::DVec3;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;

use super::EdgeTable;
use super::levels::Level;
use crate::contract::{BoundaryAlignment, Cancel, Canceled};
use crate::mesh::Surface;
use crate::tasks;

/// A seam within this share of the diagonal of a part boundary follows it.
const NEAR: f64 = 0.01;
/// Most samples on one edge.
const MOST: f64 = 400.0;

/// A point on an edge.
#[derive(Debug, Clone, Copy)]
pub(super) struct EdgeSample {
    pub edge: u32,
    pub point: DVec3,
    /// The share of its edge that it stands for.
    pub share: f64,
}

/// Points in the middle of equal stretches, no longer than `step`, of the edges that `wanted` picks.
pub(super) fn sample_edges(
    surface: &Surface,
    table: &EdgeTable,
    step: f64,
    wanted: impl Fn(usize) -> bool,
) -> Vec<EdgeSample> {
    let mut samples = vec![];
    for e in (0..table.len()).filter(|&e| wanted(e)) {
        let count = (table.length[e] / step).ceil().clamp(1.0, MOST);
        let [a, b] = table.ends[e].map(|v| surface.positions[v as usize]);
        samples.extend((0..count as u32).map(|i| EdgeSample {
            edge: e as u32,
            point: a.lerp(b, (f64::from(i) + 0.5) / count),
            share: 1.0 / count,
        }));
    }
    samples
}

/// The seams of the atlas, sampled, and which samples are near a part boundary.
#[derive(Debug, Clone, Default)]
pub(super) struct SampledSeams {
    pub samples: Vec<EdgeSample>,
    /// As `samples`.
    pub near: Vec<bool>,
    /// The share of each edge that is near a part boundary; 0 off the seams.
    near_share: Vec<f64>,
    /// Whether there is a part boundary at all.
    boundaries: bool,
}

impl SampledSeams {
    pub(super) fn new(
        surface: &Surface,
        table: &EdgeTable,
        cancel: &Cancel,
    ) -> Result<Self, Canceled> {
        let near = NEAR * surface.diagonal;
        let samples = sample_edges(surface, table, near / 2.0, |e| table.cuts[e] > 0);
        let boundary: Vec<[f64; 3]> =
            sample_edges(surface, table, near / 2.0, |e| table.boundary[e])
                .iter()
                .map(|s| s.point.to_array())
                .collect();
        cancel.check()?;
        let mut seams = Self {
            near: vec![false; samples.len()],
            near_share: vec![0.0; table.len()],
            boundaries: !boundary.is_empty(),
            samples,
        };
        // A tree that cannot be built (no point, or too many) leaves nothing near anything.
        let Ok(tree) = ImmutableKdTree::<f64, 3>::new_from_slice(&boundary) else {
            return Ok(seams);
        };
        if seams.boundaries {
            seams.near = tasks::even("near borders", seams.samples.len(), || {
                seams
                    .samples
                    .par_iter()
                    .map(|s| {
                        let point = s.point.to_array();
                        let found =
                            tree.query(&point).nearest_one::<SquaredEuclidean<f64>>().execute();
                        found.distance <= near * near
                    })
                    .collect()
            });
        }
        for (s, near) in seams.samples.iter().zip(&seams.near) {
            seams.near_share[s.edge as usize] += if *near { s.share } else { 0.0 };
        }
        Ok(seams)
    }

    /// Seam length near a part boundary / seam length, each seam edge once. `None` without seams, or
    /// without boundaries anywhere.
    pub(super) fn precision(&self, table: &EdgeTable, level: &Level) -> Option<f64> {
        let (near, seam) = level
            .edges_with_cuts()
            .filter(|(_, cuts)| *cuts > 0)
            .map(|(e, _)| (table.length[e] * self.near_share[e], table.length[e]))
            .fold((0.0, 0.0), |(n, s), (x, y)| (n + x, s + y));
        (self.boundaries && seam > 0.0).then(|| (near / seam).min(1.0))
    }
}

/// Lengths of seam, of part boundary, and of what is both; each edge once, world units.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Lengths {
    pub seam: f64,
    pub boundary: f64,
    pub both: f64,
}

impl Lengths {
    pub(super) fn of(table: &EdgeTable, level: &Level) -> Self {
        level.edges_with_cuts().fold(Self::default(), |mut sum, (e, cuts)| {
            let length = table.length[e];
            sum.seam += if cuts > 0 { length } else { 0.0 };
            sum.boundary += if table.boundary[e] { length } else { 0.0 };
            sum.both += if cuts > 0 && table.boundary[e] { length } else { 0.0 };
            sum
        })
    }

    /// |S∩B|/|S∪B| (the paper's boundary compactness, reconstructed). `None` without boundary.
    pub(super) fn overlap(self) -> Option<f64> {
        (self.boundary > 0.0).then(|| self.both / (self.seam + self.boundary - self.both))
    }

    /// The whole figure, given its precision. `None` without seam or without boundary.
    pub(super) fn alignment(
        self,
        precision: f64,
        contact: impl FnOnce() -> f64,
    ) -> Option<BoundaryAlignment> {
        if self.seam.min(self.boundary) <= 0.0 {
            return None;
        }
        let recall = self.both / self.boundary;
        let sum = precision + recall;
        Some(BoundaryAlignment {
            precision,
            recall,
            f1: if sum > 0.0 { 2.0 * precision * recall / sum } else { 0.0 },
            ceiling: (self.boundary / self.seam).min(1.0),
            contact_length: contact(),
        })
    }
}
