//! Which faces are one part (paper 2.2.1). Every source is a [`Segmenter`] that scores parts; faces
//! get their part by an area-weighted vote and a graph cut, and connected components of one label
//! are separate parts.

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
pub mod naming;
mod near_borders;
mod network;
pub mod point_mae;
pub mod regions;
mod scores;
pub mod thickness;
mod votes;
mod weights;

pub use error::SegmentationError;
pub use labels::{Part, PartLabels};
pub use network::Network;
pub use scores::{Candidate, PartScores};
pub use weights::Weights;

use crate::contract::{Run, SegmentationSource, UnwrapOptions};
use crate::device::Device;
use crate::mesh::Surface;
use crate::sampling::PointCloud;
use dual::DualGraph;
use fusion::fuse;
use regions::{Heard, gather};

use crate::tasks;

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

/// A surface and its dense cloud.
#[derive(Clone, Copy)]
pub struct Seen<'a> {
    /// The surface.
    pub surface: &'a Surface,
    /// The cloud.
    pub cloud: &'a PointCloud,
}

/// What the segmentation is told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SegmentOptions {
    /// Where parts come from.
    pub source: SegmentationSource,
    /// Regions are joined as long as the probability that a part ends between them is at most this
    /// ([`fusion::CUT`] if nothing else is asked for).
    pub cut: f64,
}

impl From<&UnwrapOptions> for SegmentOptions {
    fn from(options: &UnwrapOptions) -> Self {
        Self { source: options.segmentation, cut: options.part_boundary }
    }
}

impl SegmentOptions {
    /// Whether the network is asked for the parts of such a surface.
    pub fn hears_network(&self, surface: &Surface) -> bool {
        match self.source {
            SegmentationSource::Learned => true,
            SegmentationSource::Auto => !has_labels(surface),
            _ => false,
        }
    }
}

/// The parts of a surface: one a face.
///
/// `auto` takes given labels if there are any, and otherwise hears all: the network, the file's
/// structure, the shape; `learned` hears the network alone. `weights` are the network's and `device` is
/// where it runs.
pub fn segment(
    surface: &Surface,
    cloud: &PointCloud,
    options: &SegmentOptions,
    weights: &Weights,
    device: &Device,
    run: &Run,
) -> Result<PartLabels, SegmentationError> {
    let &SegmentOptions { source, cut } = options;
    let fused = |heard: Heard| -> Result<PartScores, SegmentationError> {
        let network = tasks::link("weights", || weights.network(device))?;
        let seen = Seen { surface, cloud };
        let evidence = gather(seen, Some(&network), run)?;
        Ok(fuse(seen, &evidence, &network.classifier, heard, cut, run)?)
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

/// From what a source says to parts: votes, graph cut, connected components.
pub fn settle(
    surface: &Surface,
    cloud: &PointCloud,
    scores: &PartScores,
    run: &Run,
) -> Result<PartLabels, SegmentationError> {
    run.cancel.check()?;
    let dual = DualGraph::new(surface);
    let faces = tasks::link("graph cut", || graph_cut::decide(surface, cloud, &dual, scores, run))?;
    Ok(labels::connected_parts(&dual, scores, &faces))
}

/// Whether any face has a label.
fn has_labels(surface: &Surface) -> bool {
    surface.labels.iter().flatten().any(|&l| l >= 0)
}

#[cfg(test)]
mod tests;
