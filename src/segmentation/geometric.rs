//! What the geometry says, first version: the regions of each body between its valleys
//! (`agglomerate`). Inside a region the label is certain; near its border the points vote and the
//! graph cut draws the line.

use super::agglomerate::{Region, regions};
use super::authored::Authored;
use super::sheets;
use super::{Candidate, PartScores, SegmentationError, Segmenter};
use crate::contract::{Run, SegmentationSource};
use crate::mesh::{NONE, Surface};
use crate::sampling::PointCloud;

/// A body of fewer faces is one part.
const FACES: usize = 60;

/// A body with more regions is rough, not made of parts.
const PARTS: usize = 64;

/// Faces this many steps from another region are open to the cut.
const RINGS: u8 = 2;

/// Regions between valleys, in every body of the surface.
pub struct Geometric;

impl Segmenter for Geometric {
    fn segment(
        &self,
        surface: &Surface,
        cloud: &PointCloud,
        run: &Run,
    ) -> Result<PartScores, SegmentationError> {
        let mut authored = Authored.segment(surface, cloud, run)?;
        for candidate in &mut authored.candidates {
            // A body without a valley is one part, says the geometry.
            candidate.source = SegmentationSource::Geometric;
            candidate.confidence = 0.5;
        }
        refine(surface, cloud, authored, run)
    }
}

/// Divide the authored parts into their regions.
fn refine(
    surface: &Surface,
    cloud: &PointCloud,
    mut scores: PartScores,
    run: &Run,
) -> Result<PartScores, SegmentationError> {
    let mut faces = vec![Vec::new(); scores.candidates.len()];
    let follows = sheets::inner(surface, &scores.fixed);
    for (f, &label) in scores.fixed.iter().enumerate().filter(|(f, l)| **l >= 0 && !follows[*f]) {
        faces[label as usize].push(f as u32);
    }
    let mut local = vec![NONE; surface.face_count()];
    let mut region = vec![-1; surface.face_count()];
    for (label, faces) in faces.iter().enumerate() {
        run.cancel.check()?;
        if faces.len() < FACES {
            continue;
        }
        let found = regions(surface, faces, &mut local, run)?;
        if !(2..=PARTS).contains(&found.len()) {
            continue;
        }
        let name = scores.candidates[label].name.clone();
        for (i, Region { faces, valley }) in found.iter().enumerate() {
            let candidate = Candidate {
                name: name.clone(),
                source: SegmentationSource::Geometric,
                // A sharp valley all around is as sure as this source gets.
                confidence: 0.8 * valley,
            };
            let number = if i == 0 {
                scores.candidates[label] = candidate;
                label
            } else {
                scores.candidates.push(candidate);
                scores.candidates.len() - 1
            };
            for &f in faces {
                region[f as usize] = number as i32;
                let mate = surface.sheet_mate[f as usize];
                if mate != NONE && follows[mate as usize] {
                    region[mate as usize] = number as i32;
                }
            }
        }
    }
    let open: Vec<bool> =
        near_borders(surface, &region, RINGS, |_| true).into_iter().map(|r| r > 0).collect();
    for (f, &r) in region.iter().enumerate().filter(|(_, r)| **r >= 0) {
        scores.fixed[f] = if open[f] { -1 } else { r };
    }
    // Only open faces vote.
    let vote = |&f: &u32| if open[f as usize] { region[f as usize] } else { -1 };
    scores.votes = cloud.faces.iter().map(vote).collect();
    scores.weights = vec![1.0; cloud.len()];
    Ok(scores)
}

/// How many steps each face is from a border between two regions that may be moved, 1 at the border, 0
/// beyond `rings` steps. `free` is asked for the border's half-edges.
pub(super) fn near_borders(
    surface: &Surface,
    region: &[i32],
    rings: u8,
    free: impl Fn(u32) -> bool,
) -> Vec<u8> {
    let across = |f: u32| {
        let edges = (3 * f..3 * f + 3).filter(|&h| surface.twin[h as usize] != NONE && free(h));
        edges.map(|h| surface.twin[h as usize] / 3)
    };
    let mut ring = vec![0; region.len()];
    let mut front: Vec<u32> = (0..region.len() as u32)
        .filter(|&f| {
            let own = region[f as usize];
            own >= 0 && across(f).any(|g| region[g as usize] >= 0 && region[g as usize] != own)
        })
        .collect();
    front.iter().for_each(|&f| ring[f as usize] = 1);
    for step in 2..=rings {
        let mut next = Vec::new();
        for g in front.iter().flat_map(|&f| across(f)) {
            if region[g as usize] >= 0 && ring[g as usize] == 0 {
                ring[g as usize] = step;
                next.push(g);
            }
        }
        front = next;
    }
    ring
}
