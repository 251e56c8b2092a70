//! What the service accepts. Configurable, and told to clients by `/v1/info`.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Upper bounds on an upload and on the mesh inside it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Limits {
    /// Bytes of one upload.
    pub upload_bytes: u64,
    /// Triangles of one mesh file, over all its primitives.
    pub triangles: u64,
    /// Bytes of the JSON chunk of a glTF file.
    pub json_bytes: u64,
    /// Depth of the node hierarchy.
    pub node_depth: u32,
    /// Seconds a job may run: a job's `budget_s` is cut to it.
    pub job_seconds: u64,
    /// MiB a job may use: a job's `budget_mib` is cut to it.
    pub job_mib: u64,
    /// Jobs that may wait in the queue.
    pub queued_jobs: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            upload_bytes: 256 << 20,
            triangles: 2_000_000,
            json_bytes: 16 << 20,
            node_depth: 64,
            job_seconds: 600,
            job_mib: 6144,
            queued_jobs: 100,
        }
    }
}
