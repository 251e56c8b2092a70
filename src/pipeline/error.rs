//! Why the pipeline stopped.

use crate::atlas::PackError;
use crate::contract::{Canceled, ErrorCode, JobError, OptionError};
use crate::device::DeviceError;
use crate::mesh::ImportError;
use crate::mesh::export::ExportError;
use crate::parameterization::TrainError;
use crate::preview::PreviewError;
use crate::segmentation::SegmentationError;

/// An error of the pipeline.
#[derive(Debug, thiserror::Error)]
pub enum UnwrapError {
    /// It was asked to stop.
    #[error("canceled")]
    Canceled,
    /// The file cannot be read.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// The labels that came with the request do not fit.
    #[error("labels: {0}")]
    Labels(String),
    /// An option that does not fit this object.
    #[error(transparent)]
    Option(#[from] OptionError),
    /// The parts cannot be found as asked.
    #[error(transparent)]
    Segmentation(SegmentationError),
    /// The device cannot compute.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The result cannot be written.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// The charts cannot be packed.
    #[error(transparent)]
    Pack(PackError),
    /// The networks cannot be trained.
    #[error(transparent)]
    Train(TrainError),
    /// The picture cannot be drawn.
    #[error("{0}")]
    Preview(String),
    /// The job needs more memory than it may use.
    #[error("{0}")]
    OutOfMemory(String),
    /// A promise of the pipeline was not kept.
    #[error("{0}")]
    Internal(String),
}

impl From<Canceled> for UnwrapError {
    fn from(_: Canceled) -> Self {
        Self::Canceled
    }
}

impl From<SegmentationError> for UnwrapError {
    fn from(error: SegmentationError) -> Self {
        match error {
            SegmentationError::Canceled(_) => Self::Canceled,
            error => Self::Segmentation(error),
        }
    }
}

impl From<PackError> for UnwrapError {
    fn from(error: PackError) -> Self {
        match error {
            PackError::Canceled(_) => Self::Canceled,
            error => Self::Pack(error),
        }
    }
}

impl From<TrainError> for UnwrapError {
    fn from(error: TrainError) -> Self {
        match error {
            TrainError::Canceled(_) => Self::Canceled,
            error => Self::Train(error),
        }
    }
}

impl From<PreviewError> for UnwrapError {
    fn from(error: PreviewError) -> Self {
        match error {
            PreviewError::Canceled(_) => Self::Canceled,
            PreviewError::Encoding(error) => Self::Preview(error.to_string()),
        }
    }
}

impl UnwrapError {
    /// What stands in `job.error`; `None` if the job was canceled.
    pub fn job_error(&self) -> Option<JobError> {
        let code = match self {
            Self::Canceled => return None,
            Self::Import(error) => error.code(),
            Self::Labels(_)
            | Self::Option(_)
            | Self::Pack(PackError::PaddingTooLarge { .. } | PackError::Blocks(_)) => {
                ErrorCode::InvalidOption
            }
            Self::Segmentation(error) => error.code(),
            Self::Device(_) | Self::Train(TrainError::Device(_)) => ErrorCode::DeviceLost,
            Self::OutOfMemory(_) => ErrorCode::OutOfMemory,
            Self::Export(_)
            | Self::Pack(_)
            | Self::Train(_)
            | Self::Preview(_)
            | Self::Internal(_) => ErrorCode::Internal,
        };
        Some(JobError::new(code, self.to_string()))
    }
}
