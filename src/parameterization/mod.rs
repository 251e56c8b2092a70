//! The neural maps (paper 2.2 and 2.3): for each chart a forward mapper, surface → UV, and an inverse
//! mapper, UV → surface, trained together. All charts of a job share one padded batch; a chart's
//! result does not depend on the others.
//!
//! A chart's map is its start map plus what the forward mapper adds, so step 0 *is* the start map.
//! Losses are measured on real triangles, in closed form ([`losses`]); only the reconstruction loss
//! goes through the networks.

mod adam;
mod balance;
mod batch;
mod chamfer;
mod chart;
mod frame;
pub mod losses;
mod mapper;
mod measure;
mod reconstruction;
mod sample;
#[cfg(test)]
mod scenes;
mod step;
#[cfg(test)]
mod tests;
mod train;

use glam::{DVec2, DVec3};

pub use train::{bytes, train};

use crate::contract::{Canceled, LossForm, Stage, UnwrapOptions};
use crate::flatten::{Disk, UvMap};
use losses::{CylinderTarget, OverCut};

/// A chart to be trained. All arrays have one entry a vertex of the disk.
#[derive(Debug, Clone)]
pub struct TrainChart<'a> {
    /// The chart, cut open.
    pub disk: &'a Disk,
    /// Its start map, at scale about 1. Flips are allowed.
    pub start: &'a [DVec2],
    /// Unit normals.
    pub normals: Vec<DVec3>,
    /// ρ: the share of neighbours with another label (paper, Eq. 5), 0 to 1.
    pub rho: Vec<f64>,
    /// I: whether ρ > 0.3 (paper, Eq. 6), 0 or 1.
    pub boundary: Vec<f64>,
    /// Edge sensitivity, 0 to 1.
    pub crease: Vec<f64>,
    /// The unrolled shape, where the chart was taken for a cylinder or cone.
    pub cylinder: Option<CylinderTarget>,
    /// Candidate seams, where the chart is an over-cut mesh.
    pub over_cut: Option<OverCut>,
    /// A number that stays the same from run to run: it decides the chart's random numbers.
    pub id: u64,
}

/// How to train.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrainOptions {
    /// Width of the hidden layers.
    pub width: usize,
    /// Most steps of a chart.
    pub steps: u32,
    /// Most vertices that a chart is trained on at a time.
    pub points: usize,
    /// Seed of the initial weights and of the samples.
    pub seed: u64,
    /// Which losses.
    pub form: LossForm,
    /// The stage that it is a part of: when that is late, training stops with what it has.
    pub stage: Stage,
}

impl From<&UnwrapOptions> for TrainOptions {
    fn from(options: &UnwrapOptions) -> Self {
        Self {
            width: options.width as usize,
            steps: options.steps,
            points: options.points as usize,
            seed: options.seed.0,
            form: options.losses,
            stage: Stage::Train,
        }
    }
}

/// What training made of a chart.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainedChart {
    /// The best map seen, for every vertex of the disk: scale 1, no flips. The start map, as it was
    /// given, where [`improved`](Self::improved) is false. Where seams were to close
    /// ([`TrainChart::over_cut`]) the last map without flips counts as the best.
    pub uv: UvMap,
    /// Whether some map of the network has no flips and less energy than the start map.
    pub improved: bool,
    /// Steps the chart took part in.
    pub steps: u32,
    /// Sum of the weighted losses at every tenth step.
    pub history: Vec<f32>,
    /// Area-weighted mean symmetric Dirichlet energy of `uv` at scale 1 (1 is isometric); infinite
    /// where it is a start map with flips.
    pub energy: f64,
    /// Chamfer distance of F_inv(F_uv(P)) to P, in units of the chart's radius; `None` where there
    /// was no step.
    pub chamfer: Option<f64>,
    /// Whether there was nothing more to gain before the steps ran out.
    pub converged: bool,
}

/// Why training stopped without a result.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MapError {
    /// It was asked to.
    #[error(transparent)]
    Canceled(#[from] Canceled),
    /// A chart's arrays do not fit its disk.
    #[error("chart {chart}: {array} has {found} entries for {vertices} vertices")]
    Mismatch {
        /// Index of the chart.
        chart: usize,
        /// Which array.
        array: &'static str,
        /// Its length.
        found: usize,
        /// Vertices of the disk.
        vertices: usize,
    },
    /// The device failed.
    #[error("the device failed while it trained: {0}")]
    Device(String),
}
