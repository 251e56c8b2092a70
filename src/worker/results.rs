//! The files of an attempt: put in place as blobs before the row that names them commits.

use bytes::Bytes;
use futures::future::join_all;

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

/// Store files side by side, each of which waits for its disk; nothing stays behind if one of them cannot be. In
/// this order.
pub async fn store_all(
    blobs: &Blobs,
    files: impl IntoIterator<Item = (ArtifactKind, Bytes)>,
) -> Result<Vec<StoredArtifact>, BlobError> {
    let all = files.into_iter().map(|(kind, bytes)| store(blobs, kind, bytes));
    let (mut stored, mut failed) = (Vec::new(), None);
    for ended in join_all(all).await {
        match ended {
            Ok(artifact) => stored.push(artifact),
            Err(error) => failed = failed.or(Some(error)),
        }
    }
    match failed {
        None => Ok(stored),
        Some(error) => {
            discard(blobs, &stored).await;
            Err(error)
        }
    }
}

/// Delete files that no row will name. What cannot be deleted is left to the orphan sweep.
pub async fn discard(blobs: &Blobs, artifacts: &[StoredArtifact]) {
    for artifact in artifacts {
        if let Err(error) = blobs.delete(&artifact.blob).await {
            tracing::warn!(blob = artifact.blob, %error, "cannot delete a file of an attempt");
        }
    }
}
