//! The votes of the points, gathered on their faces: area-weighted means, never an argmax at
//! vertices.

use super::scores::PartScores;
use crate::mesh::Surface;
use crate::sampling::PointCloud;

/// Share of each face's votes that a label has, in compressed rows, times the face's area over the
/// mean area.
pub struct Votes {
    starts: Vec<u32>,
    shares: Vec<(i32, f64)>,
}

impl Votes {
    /// Count the votes.
    pub fn count(surface: &Surface, cloud: &PointCloud, scores: &PartScores) -> Self {
        let mut cast: Vec<(u32, i32, f64)> = scores
            .votes
            .iter()
            .zip(&scores.weights)
            .zip(&cloud.faces)
            .filter(|((label, _), _)| **label >= 0)
            .map(|((&label, &weight), &face)| (face, label, f64::from(weight)))
            .collect();
        cast.sort_by_key(|a| (a.0, a.1));
        let mut starts = vec![0u32; surface.face_count() + 1];
        let mut shares: Vec<(i32, f64)> = Vec::new();
        let mean = surface.area() / surface.face_count().max(1) as f64;
        for of_face in cast.chunk_by(|a, b| a.0 == b.0) {
            let face = of_face[0].0 as usize;
            // Points of one face stand for equal areas; the face's area is divided among them.
            let each = surface.areas[face] / mean / of_face.len() as f64;
            for of_label in of_face.chunk_by(|a, b| a.1 == b.1) {
                let weight: f64 = of_label.iter().map(|v| v.2).sum();
                shares.push((of_label[0].1, each * weight));
                starts[face + 1] += 1;
            }
        }
        for f in 0..surface.face_count() {
            starts[f + 1] += starts[f];
        }
        Self { starts, shares }
    }

    fn of(&self, face: usize) -> &[(i32, f64)] {
        &self.shares[self.starts[face] as usize..self.starts[face + 1] as usize]
    }

    /// The label with the most votes, −1 for a face without any.
    pub fn winner(&self, face: usize) -> i32 {
        let best = self.of(face).iter().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
        best.map_or(-1, |b| b.0)
    }

    /// What it costs to give a face a label: the votes for all others.
    pub fn cost(&self, face: usize, label: i32) -> f64 {
        self.of(face).iter().filter(|v| v.0 != label).map(|v| v.1).sum()
    }
}
