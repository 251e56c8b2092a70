//! Why the parts cannot be found as asked.

use super::point_mae::WeightsError;
use crate::contract::{Canceled, ErrorCode};

/// An error of the segmentation.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SegmentationError {
    /// It was asked to stop.
    #[error(transparent)]
    Canceled(#[from] Canceled),
    /// `segmentation = labels` without labels.
    #[error(
        "`segmentation` is labels and there are none: give `labels` beside the mesh (one integer a line, line i \
         for face i), or a vertex attribute _PART in it, or choose another source"
    )]
    NoLabels,
    /// Labels for another mesh.
    #[error("there are {labels} labels and the mesh has {faces} faces: give one label a face")]
    WrongCount {
        /// Labels given.
        labels: usize,
        /// Faces of the mesh.
        faces: usize,
    },
    /// Labels that say nothing.
    #[error("every label is -1 (unknown): label at least one face, or choose another source")]
    NoneKnown,
    /// Weights that cannot be used.
    #[error(transparent)]
    Weights(#[from] WeightsError),
    /// Weights without heads.
    #[error(
        "the weights {0} are pre-trained only: train them further with `uvsegnet train finetune` and \
         `uvsegnet train joins`"
    )]
    Untrained(String),
}

impl SegmentationError {
    /// The code of this error in the service's table.
    pub fn code(&self) -> ErrorCode {
        match self {
            // The worker's weights are no option of a job.
            Self::Canceled(_) | Self::Weights(_) | Self::Untrained(_) => ErrorCode::Internal,
            Self::NoLabels | Self::WrongCount { .. } | Self::NoneKnown => ErrorCode::InvalidOption,
        }
    }
}
