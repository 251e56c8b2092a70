//! A mesh on its way into a blob. Its first bytes tell what it is, whatever its name or type says.

use bytes::Bytes;

use crate::contract::{ErrorCode, MeshKind};
use crate::http::Problem;
use crate::jobs::{BlobFolder, BlobWriter, Blobs};

/// A mesh of which some bytes have come.
pub struct Mesh {
    writer: BlobWriter,
    declared: Option<MeshKind>,
    head: Vec<u8>,
    kind: Option<MeshKind>,
}

impl Mesh {
    /// A mesh of which nothing has come; `declared` is what the client says it is.
    pub async fn begin(blobs: &Blobs, declared: Option<MeshKind>) -> Result<Self, Problem> {
        let writer = blobs.begin(BlobFolder::Uploads).await?;
        Ok(Self { writer, declared, head: Vec::new(), kind: None })
    }

    /// The next bytes. What is no mesh is refused as soon as enough has come to tell.
    pub async fn write(&mut self, chunk: Bytes) -> Result<(), Problem> {
        if self.kind.is_none() {
            let wanted = MeshKind::PREFIX.saturating_sub(self.head.len()).min(chunk.len());
            self.head.extend_from_slice(&chunk[..wanted]);
            if self.head.len() >= MeshKind::PREFIX {
                self.kind = Some(kind_of(&self.head, self.declared)?);
            }
        }
        Ok(self.writer.write(chunk).await?)
    }

    /// All bytes have come. The blob is not in place yet.
    pub fn end(self) -> Result<(BlobWriter, MeshKind), Problem> {
        if self.writer.is_empty() {
            return Err(Problem::malformed(format!(
                "The upload is empty; send a {} file (curl: --data-binary @FILE, or -F file=@FILE)",
                MeshKind::names()
            )));
        }
        let kind = match self.kind {
            Some(kind) => kind,
            None => kind_of(&self.head, self.declared)?,
        };
        Ok((self.writer, kind))
    }
}

fn kind_of(head: &[u8], declared: Option<MeshKind>) -> Result<MeshKind, Problem> {
    let wrong = |detail: String| Problem::new(ErrorCode::UnsupportedMediaType, detail);
    let Some(kind) = MeshKind::detect(head) else {
        let names = MeshKind::names();
        return Err(wrong(format!("The upload's first bytes are not those of a {names} file")));
    };
    match declared {
        Some(declared) if declared != kind => Err(wrong(format!(
            "The upload was declared {}, but its bytes are {}; declare that, or \
             application/octet-stream",
            declared.media_type(),
            kind.media_type()
        ))),
        _ => Ok(kind),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn bytes_decide_over_any_chunking() {
        let folder = tempfile::tempdir().unwrap();
        let blobs = Blobs::local(folder.path()).await.unwrap();
        let text = format!("# {}\nv 0 0 0\n", "x".repeat(MeshKind::PREFIX));
        for size in [1, 7, 4096, 9000] {
            let mut mesh = Mesh::begin(&blobs, None).await.unwrap();
            for chunk in text.as_bytes().chunks(size) {
                mesh.write(Bytes::copy_from_slice(chunk)).await.unwrap();
            }
            let (writer, kind) = mesh.end().unwrap();
            assert_eq!((writer.len(), kind), (text.len() as u64, MeshKind::Obj));
        }
    }

    #[tokio::test]
    async fn what_is_wrong_has_its_code() {
        let folder = tempfile::tempdir().unwrap();
        let blobs = Blobs::local(folder.path()).await.unwrap();
        for (bytes, declared, code) in [
            ("", None, ErrorCode::MalformedRequest),
            ("hello world", None, ErrorCode::UnsupportedMediaType),
            ("v 0 0 0\n", Some(MeshKind::Glb), ErrorCode::UnsupportedMediaType),
        ] {
            let mut mesh = Mesh::begin(&blobs, declared).await.unwrap();
            mesh.write(Bytes::from(bytes)).await.unwrap();
            assert_eq!(mesh.end().err().map(|p| p.code()), Some(code), "{bytes:?}");
        }
    }
}
