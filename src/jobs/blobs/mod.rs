//! Uploads and artifacts: byte strings with a drawn name. A blob is written under a temporary name,
//! synced and put in place before the row that names it commits; what no row names is swept away.

mod folder;
mod place;

use std::ops::Range;
use std::path::{Path as FilePath, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use bytes::{Bytes, BytesMut};
use futures::StreamExt;
use futures::stream::BoxStream;
use object_store::local::LocalFileSystem;
use object_store::path::Path;
use object_store::{GetOptions, GetRange, MultipartUpload, ObjectStore, ObjectStoreExt};
use sha2::{Digest, Sha256};
use uuid::Uuid;

use self::folder::Folder;
use super::{Keep, QueueError};

/// Bytes gathered before a part is written: the least that S3 takes.
const PART: usize = 5 << 20;

/// Names looked up in one query by the orphan sweep.
const SWEEP_BATCH: usize = 500;

/// What can go wrong with a blob.
#[derive(Debug, thiserror::Error)]
pub enum BlobError {
    /// There is no blob with this name.
    #[error("there is no blob {0}")]
    NotFound(String),
    /// The store is full.
    #[error("no room is left to store this")]
    StorageFull,
    /// Anything else.
    #[error("blob store: {0}")]
    Store(#[source] object_store::Error),
    /// Blobs cannot be kept there.
    #[error("blobs cannot be kept in {place:?}: {why}")]
    Place {
        /// What was said.
        place: String,
        /// Why not.
        why: &'static str,
    },
    /// The directory of a local store cannot be used.
    #[error("blob directory {}: {source}", path.display())]
    Directory {
        /// Which one.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}

impl From<object_store::Error> for BlobError {
    fn from(error: object_store::Error) -> Self {
        if let object_store::Error::NotFound { path, .. } = error {
            return BlobError::NotFound(path);
        }
        if is_full(&error) { BlobError::StorageFull } else { BlobError::Store(error) }
    }
}

/// Whether some cause of this error is a full disk or a spent quota.
fn is_full(error: &(dyn std::error::Error + 'static)) -> bool {
    use std::io::ErrorKind::{QuotaExceeded, StorageFull};
    let mut cause = Some(error);
    while let Some(error) = cause {
        if let Some(io) = error.downcast_ref::<std::io::Error>()
            && matches!(io.kind(), StorageFull | QuotaExceeded)
        {
            return true;
        }
        cause = error.source();
    }
    false
}

/// The bytes of a blob, as they are read.
pub type BlobStream = BoxStream<'static, Result<Bytes, BlobError>>;

/// What a blob is for: the first half of its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlobFolder {
    /// Meshes and labels that clients sent.
    Uploads,
    /// Files that jobs made.
    Artifacts,
}

impl BlobFolder {
    const ALL: [BlobFolder; 2] = [BlobFolder::Uploads, BlobFolder::Artifacts];

    fn as_str(self) -> &'static str {
        match self {
            BlobFolder::Uploads => "uploads",
            BlobFolder::Artifacts => "artifacts",
        }
    }
}

/// A blob that is in place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredBlob {
    /// Its name.
    pub name: String,
    /// Its length.
    pub bytes: u64,
    /// SHA-256 of its content, in 64 lower-case hexadecimal digits.
    pub sha256: String,
}

/// The store. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Blobs {
    store: Arc<dyn ObjectStore>,
    /// Where a store that is local lies.
    local: Option<Folder>,
}

impl Blobs {
    /// The store at this place: `file:///PATH`, or a path as it is.
    pub async fn open(place: &str) -> Result<Self, BlobError> {
        Self::local(&place::directory(place)?).await
    }

    /// A store in a local directory, which is made if need be.
    pub async fn local(root: &FilePath) -> Result<Self, BlobError> {
        let folder = Folder::new(root);
        folder.make().await?;
        // It does not sync by default, and a 202 is a promise that survives a power loss.
        let store = LocalFileSystem::new_with_prefix(root)?.with_fsync(true);
        Ok(Self { store: Arc::new(store), local: Some(folder) })
    }

    /// Begin a blob. It is under a temporary name until [`BlobWriter::finish`], and gone if the
    /// writer is dropped before that.
    pub async fn begin(&self, folder: BlobFolder) -> Result<BlobWriter, BlobError> {
        let name = format!("{}/{}", folder.as_str(), Uuid::now_v7().simple());
        let upload = self.store.put_multipart(&Path::from(name.as_str())).await?;
        let digest = Sha256::new();
        Ok(BlobWriter { upload, name, bytes: 0, digest, part: BytesMut::new() })
    }

    /// Store these bytes.
    pub async fn put(&self, folder: BlobFolder, bytes: Bytes) -> Result<StoredBlob, BlobError> {
        let mut writer = self.begin(folder).await?;
        writer.write(bytes).await?;
        writer.finish().await
    }

    /// The bytes of a blob, or of a range of it that must lie inside.
    pub async fn get(
        &self,
        name: &str,
        range: Option<Range<u64>>,
    ) -> Result<BlobStream, BlobError> {
        let options = GetOptions { range: range.map(GetRange::Bounded), ..Default::default() };
        let found = self.store.get_opts(&Path::from(name), options).await?;
        Ok(found.into_stream().map(|chunk| chunk.map_err(BlobError::from)).boxed())
    }

    /// The whole blob in memory.
    pub async fn read(&self, name: &str) -> Result<Bytes, BlobError> {
        Ok(self.store.get(&Path::from(name)).await?.bytes().await?)
    }

    /// Delete a blob. It is no error if it is gone already.
    pub async fn delete(&self, name: &str) -> Result<(), BlobError> {
        match self.store.delete(&Path::from(name)).await.map_err(BlobError::from) {
            Ok(()) | Err(BlobError::NotFound(_)) => Ok(()),
            Err(error) => Err(error),
        }
    }

    /// Delete every blob that is older than `grace` and that no row of `queue` names, and what
    /// writers that died left behind. Returns how many went. `grace` must be longer than it can
    /// take from the end of an upload to the commit of its row.
    pub async fn sweep_orphans(
        &self,
        queue: &dyn Keep,
        grace: Duration,
    ) -> Result<u64, OrphanError> {
        let now = SystemTime::now();
        let since_epoch = now.duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        let before = since_epoch.saturating_sub(grace).as_secs() as i64;
        let mut old = Vec::new();
        let mut list = self.store.list(None);
        while let Some(found) = list.next().await {
            let found = found.map_err(BlobError::from)?;
            if found.last_modified.timestamp() <= before {
                old.push(found.location.to_string());
            }
        }
        let mut gone = 0;
        for batch in old.chunks(SWEEP_BATCH) {
            let named = queue.named(batch).await?;
            for name in batch.iter().filter(|name| !named.contains(*name)) {
                self.delete(name).await?;
                gone += 1;
            }
        }
        if let Some(folder) = &self.local {
            gone += folder.sweep(now, grace).await?;
        }
        Ok(gone)
    }
}

/// Why an orphan sweep stopped.
#[derive(Debug, thiserror::Error)]
pub enum OrphanError {
    /// The store failed.
    #[error(transparent)]
    Blob(#[from] BlobError),
    /// The queue failed.
    #[error(transparent)]
    Queue(#[from] QueueError),
}

/// A blob that is being written. Dropped before [`BlobWriter::finish`], it leaves nothing behind.
#[derive(Debug)]
pub struct BlobWriter {
    upload: Box<dyn MultipartUpload>,
    name: String,
    bytes: u64,
    digest: Sha256,
    part: BytesMut,
}

impl BlobWriter {
    /// Append bytes.
    pub async fn write(&mut self, bytes: Bytes) -> Result<(), BlobError> {
        self.bytes += bytes.len() as u64;
        self.digest.update(&bytes);
        self.part.extend_from_slice(&bytes);
        if self.part.len() >= PART { self.flush().await } else { Ok(()) }
    }

    /// Bytes written so far.
    pub fn len(&self) -> u64 {
        self.bytes
    }

    /// Whether nothing was written so far.
    pub fn is_empty(&self) -> bool {
        self.bytes == 0
    }

    /// Sync the bytes and put the blob in place.
    pub async fn finish(mut self) -> Result<StoredBlob, BlobError> {
        self.flush().await?;
        self.upload.complete().await?;
        let sha256 = self.digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(StoredBlob { name: self.name, bytes: self.bytes, sha256 })
    }

    async fn flush(&mut self) -> Result<(), BlobError> {
        if !self.part.is_empty() {
            let part = self.part.split().freeze();
            self.upload.put_part(part.into()).await?;
        }
        Ok(())
    }
}
