//! What the author said: a node, a primitive, a material or a connected component is a part.

use std::collections::BTreeMap;

use super::{Candidate, PartScores, SegmentationError, Segmenter};
use crate::contract::{Run, SegmentationSource};
use crate::mesh::Surface;
use crate::sampling::PointCloud;

/// A primitive is a thing of its own, most likely.
const PRIMITIVE: f64 = 0.9;

/// A connected component may be: authored furniture often is one board a component, but what was scanned
/// or fused is one component whatever it is made of.
const COMPONENT: f64 = 0.6;

/// The author's structure.
pub struct Authored;

impl Segmenter for Authored {
    fn segment(
        &self,
        surface: &Surface,
        _cloud: &PointCloud,
        _run: &Run,
    ) -> Result<PartScores, SegmentationError> {
        // A component lies within one primitive, and a primitive has one node and one material.
        let mut numbers: BTreeMap<(u32, u32), i32> = BTreeMap::new();
        let mut components: BTreeMap<u32, u32> = BTreeMap::new();
        let mut keys = Vec::new();
        let mut fixed = vec![-1; surface.face_count()];
        let primitive = |h: u32| surface.origins[h as usize / 3].primitive;
        let connected = surface.components(|h| primitive(h) == primitive(surface.twin[h as usize]));
        for (f, origin) in surface.origins.iter().enumerate() {
            let key = (origin.primitive, connected[f]);
            fixed[f] = *numbers.entry(key).or_insert_with(|| {
                keys.push(key);
                *components.entry(key.0).or_default() += 1;
                keys.len() as i32 - 1
            });
        }
        let candidate = |&(primitive, _): &(u32, u32)| {
            let name = surface.names.get(primitive as usize).filter(|n| !n.is_empty());
            let alone = components.get(&primitive) == Some(&1) && components.len() > 1;
            Candidate {
                name: name.cloned().unwrap_or_else(|| "part".into()),
                source: SegmentationSource::Authored,
                confidence: if alone { PRIMITIVE } else { COMPONENT },
                name_confidence: None,
            }
        };
        let candidates = keys.iter().map(candidate).collect();
        Ok(PartScores { candidates, fixed, ..Default::default() })
    }
}
