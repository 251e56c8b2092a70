//! The files of an attempt: put in place as blobs before the row that names them commits.

use bytes::Bytes;

use crate::contract::ArtifactKind;
use crate::jobs::{BlobError, BlobFolder, Blobs, StoredArtifact};

/// Store one file.
async fn store(
    blobs: &Blobs,
    kind: ArtifactKind,
    bytes: Bytes,
) -> Result<StoredArtifact, BlobError> {
    let stored = blobs.put(BlobFolder::Artifacts, bytes).await?;
    Ok(StoredArtifact {
        name: kind.name().into(),
        media_type: kind.media_type().into(),
        bytes: stored.bytes,
        sha256: stored.sha256,
        blob: stored.name,
    })
}

/// Store files in this order; nothing stays behind if one of them cannot be.
pub async fn store_all(
    blobs: &Blobs,
    files: impl IntoIterator<Item = (ArtifactKind, Bytes)>,
) -> Result<Vec<StoredArtifact>, BlobError> {
    let mut stored = Vec::new();
    for (kind, bytes) in files {
        match store(blobs, kind, bytes).await {
            Ok(artifact) => stored.push(artifact),
            Err(error) => {
                discard(blobs, &stored).await;
                return Err(error);
            }
        }
    }
    Ok(stored)
}

/// Delete files that no row will name. What cannot be deleted is left to the orphan sweep.
pub async fn discard(blobs: &Blobs, artifacts: &[StoredArtifact]) {
    for artifact in artifacts {
        if let Err(error) = blobs.delete(&artifact.blob).await {
            tracing::warn!(blob = artifact.blob, %error, "cannot delete a file of an attempt");
        }
    }
}
