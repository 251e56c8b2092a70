//! Every error code of the service, in one table: its name, its HTTP status, its title and what it
//! means. The same codes stand in `problem+json` answers and in `job.error`.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

macro_rules! error_codes {
    ($($variant:ident $name:literal $status:literal $title:literal $meaning:literal,)*) => {
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

            /// What it means and what can be done about it.
            pub fn meaning(self) -> &'static str {
                match self { $(ErrorCode::$variant => $meaning,)* }
            }
        }
    };
}

error_codes! {
    MalformedRequest "malformed_request" 400 "The request cannot be read"
        "The request cannot be read: an empty upload, a part of the form that is unknown, missing or there twice, options that are no JSON, a query parameter or header with a value that it does not take.",
    NotFound "not_found" 404 "There is no such thing here"
        "No such address, job or artifact.",
    MethodNotAllowed "method_not_allowed" 405 "This address does not take that method"
        "The address is known, but not with this method; the header `Allow` lists those that it takes.",
    JobNotTerminal "job_not_terminal" 409 "The job is still running"
        "The job waits or runs, so it cannot be deleted; cancel it first.",
    ArtifactExpired "artifact_expired" 410 "The artifact has expired"
        "Uploads and artifacts are kept for a time (`expires_at`); this one's is over. Submit the mesh again.",
    UploadTooLarge "upload_too_large" 413 "The upload is over the limit"
        "The upload has more bytes than `limits.upload_bytes` of `/v1/info`.",
    UnsupportedMediaType "unsupported_media_type" 415 "This is not a mesh in a known format"
        "The bytes are not those of a GLB, a glTF or an OBJ file, or not those of the model type that was declared, or the `Content-Type` is one that the address does not take.",
    RangeNotSatisfiable "range_not_satisfiable" 416 "The range lies outside the artifact"
        "The range lies outside the file; the header `Content-Range` tells its length.",
    InvalidMesh "invalid_mesh" 422 "The mesh is broken"
        "The file is in a known format and broken: it ends early, an index or a view points outside, a position is not finite, nodes form a cycle. The message names the node, primitive or accessor. Never tried again.",
    MeshTooLarge "mesh_too_large" 422 "The mesh is over the limit"
        "The mesh is over one of the limits of `/v1/info` (triangles, JSON bytes, node depth).",
    UnsupportedExtension "unsupported_extension" 422 "The mesh needs an extension that is not supported"
        "The glTF file requires an extension that is not supported; export it without, for instance without mesh compression.",
    ExternalUriForbidden "external_uri_forbidden" 422 "The mesh refers to a file outside itself"
        "The file refers to another file. Nothing is ever fetched: embed buffers as GLB or data URIs.",
    InvalidOption "invalid_option" 422 "An option is unknown or has a wrong value"
        "An option is unknown or has a wrong type or value; `errors` names each. In jobs: labels that do not fit the mesh.",
    QueueQuotaExceeded "queue_quota_exceeded" 429 "The queue is full"
        "As many jobs wait as may; try again after `Retry-After` seconds.",
    NotCertified "not_certified" 500 "No valid atlas was found"
        "No atlas could be found whose certificate holds: the message says what does not. A larger `page_size`, a `density` nearer to 1 or a smaller `padding` leave more room.",
    OutOfMemory "out_of_memory" 500 "The job needed more memory than it may use"
        "The job needs more memory, counted from its mesh and options, than `budget_mib`; the message says how much. A worker that the host's killer of memory hogs ended is `worker_crashed`.",
    DeviceLost "device_lost" 500 "The compute device was lost"
        "The compute device failed while the job ran, on every attempt.",
    TimedOut "timed_out" 500 "The job ran out of its time"
        "The job was not done within `budget_s`, and the message says how many seconds would do; or it ran for `limits.job_seconds`, after which a worker ends any job.",
    WorkerCrashed "worker_crashed" 500 "The worker died while it ran the job"
        "The worker died while it ran the job, on every attempt.",
    Internal "internal" 500 "Something went wrong on our side"
        "A mistake of ours; the log tells more under the request's id.",
    Draining "draining" 503 "The service is shutting down"
        "The service is shutting down and takes no new jobs; `Retry-After` says when to try again. Running jobs, their streams and everything else go on until the last worker has left.",
    NoWorker "no_worker" 503 "No worker can compute"
        "No worker is alive that could take a job; `/readyz` says so.",
    StorageFull "storage_full" 507 "There is no room to store the upload"
        "There is no room to store the upload.",
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
