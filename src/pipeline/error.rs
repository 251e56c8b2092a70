//! Why the pipeline stopped, and in which stage.

use crate::atlas::PackError;
use crate::contract::{Canceled, ErrorCode, JobError, OptionError, Run, Stage};
use crate::device::DeviceError;
use crate::mesh::ImportError;
use crate::mesh::export::ExportError;
use crate::parameterization::MapError;
use crate::preview::PreviewError;
use crate::segmentation::SegmentationError;

/// An error of the pipeline.
#[derive(Debug, thiserror::Error)]
#[error("{cause}")]
pub struct UnwrapError {
    /// The stage in which it arose.
    pub stage: Stage,
    /// What went wrong.
    pub cause: Cause,
}

/// What went wrong.
#[derive(Debug, thiserror::Error)]
pub enum Cause {
    /// It was asked to stop.
    #[error("canceled")]
    Canceled,
    /// The job's time is over.
    #[error("{0}")]
    TimedOut(String),
    /// Options out of their ranges, or that do not fit this object.
    #[error("{}", said(.0))]
    Options(Vec<OptionError>),
    /// The file cannot be read.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// The labels that came with the request do not fit.
    #[error("labels: {0}")]
    Labels(String),
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
    Train(MapError),
    /// The picture cannot be drawn.
    #[error("{0}")]
    Preview(String),
    /// The job needs more memory than it may use.
    #[error("{0}")]
    OutOfMemory(String),
    /// The atlas is not valid, and nothing more can be done about it.
    #[error("{0}")]
    NotCertified(String),
    /// A promise of the pipeline was not kept.
    #[error("{0}")]
    Internal(String),
}

fn said(errors: &[OptionError]) -> String {
    errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

impl From<Canceled> for Cause {
    fn from(_: Canceled) -> Self {
        Self::Canceled
    }
}

impl From<OptionError> for Cause {
    fn from(error: OptionError) -> Self {
        Self::Options(vec![error])
    }
}

impl From<SegmentationError> for Cause {
    fn from(error: SegmentationError) -> Self {
        match error {
            SegmentationError::Canceled(_) => Self::Canceled,
            error => Self::Segmentation(error),
        }
    }
}

impl From<PackError> for Cause {
    fn from(error: PackError) -> Self {
        match error {
            PackError::Canceled(_) => Self::Canceled,
            error => Self::Pack(error),
        }
    }
}

impl From<MapError> for Cause {
    fn from(error: MapError) -> Self {
        match error {
            MapError::Canceled(_) => Self::Canceled,
            error => Self::Train(error),
        }
    }
}

impl From<PreviewError> for Cause {
    fn from(error: PreviewError) -> Self {
        match error {
            PreviewError::Canceled(_) => Self::Canceled,
            PreviewError::Encoding(error) => Self::Preview(error.to_string()),
        }
    }
}

/// By how much a time that would do is rounded up.
const ROOM: f64 = 1.5;

impl Cause {
    /// The error of a run that stopped for this cause. Where its time was over, it says how many seconds
    /// would do, at the pace so far.
    pub(super) fn of(self, run: &Run) -> UnwrapError {
        let stage = run.present_stage();
        let cause = match (self, run.out_of_time()) {
            (Self::Canceled, Some((_, fraction, spent))) => {
                let whole = ROOM * spent / fraction.max(0.01);
                Self::TimedOut(format!(
                    "the job's time (`budget_s`) was over after {spent:.1} s in the stage {}, with {:.0} % of \
                     its work done: about {:.0} s would do",
                    stage.as_str(),
                    100.0 * fraction,
                    whole.ceil(),
                ))
            }
            (cause, _) => cause,
        };
        UnwrapError { stage, cause }
    }
}

impl UnwrapError {
    /// What stands in `job.error`; `None` if the job was canceled.
    pub fn job_error(&self) -> Option<JobError> {
        let code = match &self.cause {
            Cause::Canceled => return None,
            Cause::TimedOut(_) => ErrorCode::TimedOut,
            Cause::Import(error) => error.code(),
            Cause::Labels(_)
            | Cause::Options(_)
            | Cause::Pack(PackError::PaddingTooLarge { .. } | PackError::Blocks(_)) => {
                ErrorCode::InvalidOption
            }
            Cause::Segmentation(error) => error.code(),
            Cause::Device(_) | Cause::Train(MapError::Device(_)) => ErrorCode::DeviceLost,
            Cause::OutOfMemory(_) => ErrorCode::OutOfMemory,
            Cause::NotCertified(_) => ErrorCode::NotCertified,
            Cause::Export(_)
            | Cause::Pack(_)
            | Cause::Train(_)
            | Cause::Preview(_)
            | Cause::Internal(_) => ErrorCode::Internal,
        };
        // A fault of ours is looked for where it arose.
        let message = match code {
            ErrorCode::Internal => format!("in the stage {}: {self}", self.stage.as_str()),
            _ => self.to_string(),
        };
        Some(JobError::new(code, message))
    }
}
