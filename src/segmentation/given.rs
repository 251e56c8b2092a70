//! Labels that came with the request: what is given is kept, faces with −1 are filled in.

use std::collections::BTreeMap;

use super::{Candidate, PartScores, SegmentationError, Segmenter};
use crate::contract::{Run, SegmentationSource};
use crate::mesh::{NONE, Surface};
use crate::sampling::PointCloud;

/// The given labels.
pub struct Given;

impl Segmenter for Given {
    fn segment(
        &self,
        surface: &Surface,
        _cloud: &PointCloud,
        _run: &Run,
    ) -> Result<PartScores, SegmentationError> {
        let given = surface.labels.as_ref().ok_or(SegmentationError::NoLabels)?;
        if given.len() != surface.face_count() {
            let (labels, faces) = (given.len(), surface.face_count());
            return Err(SegmentationError::WrongCount { labels, faces });
        }
        if given.iter().all(|&l| l < 0) {
            return Err(SegmentationError::NoneKnown);
        }
        let mut numbers: BTreeMap<i32, i32> = BTreeMap::new();
        for &label in given.iter().filter(|l| **l >= 0) {
            let next = numbers.len() as i32;
            numbers.entry(label).or_insert(next);
        }
        let mut candidates = vec![None; numbers.len()];
        for (&label, &number) in &numbers {
            candidates[number as usize] = Some(Candidate {
                name: format!("label_{label}"),
                source: SegmentationSource::Labels,
                confidence: 1.0,
                name_confidence: None,
            });
        }
        let candidates = candidates.into_iter().flatten().collect();
        let number = |f: usize| numbers.get(&given[f]).copied();
        // A face of unknown label takes that of its mate.
        let behind = |f: usize| {
            let mate = surface.sheet_mate[f];
            if mate == NONE { None } else { number(mate as usize) }
        };
        let fixed = (0..given.len()).map(|f| number(f).or_else(|| behind(f)).unwrap_or(-1));
        Ok(PartScores { candidates, fixed: fixed.collect(), ..Default::default() })
    }
}
