//! What the geometry says, without any weights: regions agglomerated by the rule (`regions::rule`), which
//! weighs contact, concave and convex edges (minima rule), shape diameter, how well planes, cylinders and
//! cones fit, how the boxes about both overlap, and size.

use super::fusion::fuse;
use super::regions::{Heard, Rule, gather};
use super::{PartScores, Seen, SegmentationError, Segmenter};
use crate::contract::Run;
use crate::mesh::Surface;
use crate::sampling::PointCloud;

/// Parts by the rule, joined up to this probability that a part ends between them.
pub struct Geometric(pub f64);

impl Segmenter for Geometric {
    fn segment(
        &self,
        surface: &Surface,
        cloud: &PointCloud,
        run: &Run,
    ) -> Result<PartScores, SegmentationError> {
        let seen = Seen { surface, cloud };
        let evidence = gather(seen, None, run)?;
        Ok(fuse(seen, &evidence, &Rule, Heard::SHAPE, self.0, run)?)
    }
}
