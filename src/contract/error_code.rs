//! Every error code of the service, in one table: its name, its HTTP status and its title. The same
//! codes stand in `problem+json` answers and in `job.error`.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

macro_rules! error_codes {
    ($($variant:ident $name:literal $status:literal $title:literal,)*) => {
        /// A machine-readable error code.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum ErrorCode {
            $(#[doc = $title] $variant,)*
        }

        impl ErrorCode {
            /// Every code, in the table's order.
            pub const ALL: &'static [ErrorCode] = &[$(ErrorCode::$variant),*];

            /// The code as it is written in JSON.
            pub fn as_str(self) -> &'static str {
                match self { $(ErrorCode::$variant => $name,)* }
            }

            /// The HTTP status of an answer with this code.
            pub fn status(self) -> u16 {
                match self { $(ErrorCode::$variant => $status,)* }
            }

            /// A short sentence that is the same for every occurrence.
            pub fn title(self) -> &'static str {
                match self { $(ErrorCode::$variant => $title,)* }
            }
        }
    };
}

error_codes! {
    MalformedRequest "malformed_request" 400 "The request cannot be read",
    NotFound "not_found" 404 "There is no such thing here",
    MethodNotAllowed "method_not_allowed" 405 "This address does not take that method",
    JobNotTerminal "job_not_terminal" 409 "The job is still running",
    ArtifactExpired "artifact_expired" 410 "The artifact has expired",
    UploadTooLarge "upload_too_large" 413 "The upload is over the limit",
    UnsupportedMediaType "unsupported_media_type" 415 "This is not a mesh in a known format",
    RangeNotSatisfiable "range_not_satisfiable" 416 "The range lies outside the artifact",
    InvalidMesh "invalid_mesh" 422 "The mesh is broken",
    MeshTooLarge "mesh_too_large" 422 "The mesh is over the limit",
    UnsupportedExtension "unsupported_extension" 422 "The mesh needs an extension that is not supported",
    ExternalUriForbidden "external_uri_forbidden" 422 "The mesh refers to a file outside itself",
    InvalidOption "invalid_option" 422 "An option is unknown or has a wrong value",
    QueueQuotaExceeded "queue_quota_exceeded" 429 "The queue is full",
    OutOfMemory "out_of_memory" 500 "The job needed more memory than it may use",
    DeviceLost "device_lost" 500 "The compute device was lost",
    TimedOut "timed_out" 500 "The job ran out of its time",
    WorkerCrashed "worker_crashed" 500 "The worker died while it ran the job",
    Internal "internal" 500 "Something went wrong on our side",
    Draining "draining" 503 "The service is shutting down",
    NoWorker "no_worker" 503 "No worker can compute",
    StorageFull "storage_full" 507 "There is no room to store the upload",
}

/// Why a job failed: stands in `job.error`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema, thiserror::Error)]
#[error("{}: {message}", code.as_str())]
pub struct JobError {
    /// The code from the table.
    pub code: ErrorCode,
    /// What is wrong, where it is, and how to mend it.
    pub message: String,
}

impl JobError {
    /// A code and its message.
    pub fn new(code: ErrorCode, message: impl Into<String>) -> Self {
        Self { code, message: message.into() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_name_is_the_table_name() {
        for code in ErrorCode::ALL {
            let json = serde_json::to_value(code).unwrap();
            assert_eq!(json, code.as_str());
            assert!((400..600).contains(&code.status()));
        }
    }
}
