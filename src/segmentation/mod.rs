//! Which faces are one part (paper 2.2.1). Every source is a [`Segmenter`] that scores parts; faces
//! get their part by an area-weighted vote and a graph cut, and connected pieces of one label are
//! separate parts.

pub mod agreement;
mod authored;
pub mod borders;
mod dual;
mod error;
pub mod fusion;
mod geometric;
mod given;
mod graph_cut;
mod labels;
mod near_borders;
mod network;
pub mod point_mae;
pub mod regions;
mod scores;
pub mod sheets;
pub mod thickness;
mod votes;

pub use error::SegmentationError;
pub use labels::{Part, PartLabels};
pub use network::{Network, network, use_weights};
pub use scores::{Candidate, PartScores};

use crate::contract::{Run, SegmentationSource};
use crate::device::Device;
use crate::mesh::Surface;
use crate::sampling::PointCloud;
use dual::DualGraph;
use fusion::fuse;
use regions::{Heard, gather};
use sheets::Outside;

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
/// `auto` takes given labels if there are any, and otherwise hears all: the network, the file's
/// structure, the shape; `learned` hears the network alone. Regions are joined as
/// long as the probability that a part ends between them is at most `cut` ([`fusion::CUT`] if nothing
/// else is asked for). `device` is where the network runs.
pub fn segment(
    surface: &Surface,
    cloud: &PointCloud,
    source: SegmentationSource,
    cut: f64,
    device: &Device,
    run: &Run,
) -> Result<PartLabels, SegmentationError> {
    let fused = |heard: Heard| -> Result<PartScores, SegmentationError> {
        let network = network(device)?;
        let seen = Outside::of(surface, cloud);
        let evidence = gather(&seen, Some(&network), run)?;
        Ok(fuse(&seen, &evidence, &network.judge, heard, cut, run)?)
    };
    let scores = match source {
        SegmentationSource::Labels => given::Given.segment(surface, cloud, run)?,
        SegmentationSource::Authored => authored::Authored.segment(surface, cloud, run)?,
        SegmentationSource::Geometric => geometric::Geometric(cut).segment(surface, cloud, run)?,
        SegmentationSource::Learned => fused(Heard::LEARNED)?,
        SegmentationSource::Auto if has_labels(surface) => {
            given::Given.segment(surface, cloud, run)?
        }
        SegmentationSource::Auto => fused(Heard::ALL)?,
    };
    settle(surface, cloud, &scores, run)
}

/// From what a source says to parts: votes, graph cut, connected pieces.
pub fn settle(
    surface: &Surface,
    cloud: &PointCloud,
    scores: &PartScores,
    run: &Run,
) -> Result<PartLabels, SegmentationError> {
    run.cancel.check()?;
    let dual = DualGraph::new(surface);
    let faces = graph_cut::decide(surface, cloud, &dual, scores, run)?;
    Ok(labels::connected_parts(surface, &dual, scores, &faces))
}

/// Whether any face has a label.
fn has_labels(surface: &Surface) -> bool {
    surface.labels.iter().flatten().any(|&l| l >= 0)
}

#[cfg(test)]
mod tests;
