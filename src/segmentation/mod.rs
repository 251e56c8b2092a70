//! Which faces are one part (paper 2.2.1). Every source is a [`Segmenter`] that scores parts; faces
//! get their part by an area-weighted vote and a graph cut, and connected pieces of one label are
//! separate parts.

mod agglomerate;
pub mod agreement;
mod authored;
mod dual;
mod error;
pub mod fusion;
mod geometric;
mod given;
mod graph_cut;
mod labels;
pub mod point_mae;
pub mod regions;
mod scores;
mod sheets;
pub mod thickness;
mod votes;

pub use error::SegmentationError;
pub use labels::{Part, PartLabels};
pub use scores::{Candidate, PartScores};

use crate::contract::{Run, SegmentationSource};
use crate::mesh::Surface;
use crate::sampling::PointCloud;
use dual::DualGraph;

/// A source of parts.
pub trait Segmenter {
    /// Score the parts of a surface; `cloud` is its dense cloud.
    fn segment(
        &self,
        surface: &Surface,
        cloud: &PointCloud,
        run: &Run,
    ) -> Result<PartScores, SegmentationError>;
}

/// The parts of a surface: one a face.
///
/// `auto` takes given labels if there are any; otherwise what the author said (nodes, primitives,
/// materials, connected components), and inside a large closed body of one piece what its geometry
/// says. The learned source is not in this version.
pub fn segment(
    surface: &Surface,
    cloud: &PointCloud,
    source: SegmentationSource,
    run: &Run,
) -> Result<PartLabels, SegmentationError> {
    let segmenter: Box<dyn Segmenter> = match source {
        SegmentationSource::Labels => Box::new(given::Given),
        SegmentationSource::Authored => Box::new(authored::Authored),
        SegmentationSource::Geometric => Box::new(geometric::Geometric),
        SegmentationSource::Learned => return Err(SegmentationError::NotInThisVersion),
        SegmentationSource::Auto if has_labels(surface) => Box::new(given::Given),
        SegmentationSource::Auto => Box::new(geometric::Bodies),
    };
    let scores = segmenter.segment(surface, cloud, run)?;
    run.cancel.check()?;
    let dual = DualGraph::new(surface);
    let faces = graph_cut::decide(surface, cloud, &dual, &scores, run)?;
    Ok(labels::connected_parts(surface, &dual, &scores, &faces))
}

/// Whether any face has a label.
fn has_labels(surface: &Surface) -> bool {
    surface.labels.iter().flatten().any(|&l| l >= 0)
}

#[cfg(test)]
mod tests;
