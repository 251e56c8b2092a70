//! Why a file cannot be read. Each message says what is wrong, where, and how to mend it.

use crate::contract::ErrorCode;

/// A file that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ImportError {
    /// The file is broken.
    #[error("{0}")]
    Invalid(String),
    /// The file, or what it declares, is over a limit.
    #[error("{0}")]
    TooLarge(String),
    /// The file needs an extension that is not supported.
    #[error("{0}")]
    Extension(String),
    /// The file refers to another file.
    #[error("{0}")]
    ExternalUri(String),
}

impl ImportError {
    /// The code of the table that fits this error.
    pub fn code(&self) -> ErrorCode {
        match self {
            Self::Invalid(_) => ErrorCode::InvalidMesh,
            Self::TooLarge(_) => ErrorCode::MeshTooLarge,
            Self::Extension(_) => ErrorCode::UnsupportedExtension,
            Self::ExternalUri(_) => ErrorCode::ExternalUriForbidden,
        }
    }

    /// A broken file.
    pub(in crate::mesh) fn invalid(message: impl Into<String>) -> Self {
        Self::Invalid(message.into())
    }
}
