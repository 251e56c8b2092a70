//! A mesh in a form (RFC 7578): the parts `file`, `options` and `labels`, each once, in any order.

use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use axum::body::Body;
use axum::extract::multipart::{Field, MultipartError};
use axum::extract::{FromRequest, Multipart, Request};
use bytes::Bytes;
use futures::StreamExt;

use super::mesh::Mesh;
use super::{Upload, essence, kind_of};
use crate::contract::{MeshKind, UnwrapOptions};
use crate::http::incoming::{BodyError, counted, too_large};
use crate::http::{AppState, Problem};
use crate::jobs::{BlobFolder, BlobWriter};

/// Bytes that a form may have outside of its parts, in their headers and boundaries. The reader of
/// forms holds those in memory, so they are bounded by themselves.
const FRAMING: u64 = 4 << 20;
/// Bytes of the `options` part.
const OPTIONS: usize = 1 << 20;

/// Read a form to its end.
pub async fn receive(state: &AppState, request: Request) -> Result<Upload, Problem> {
    let most = state.limits.upload_bytes;
    let untaken = Arc::new(AtomicU64::new(0));
    let (head, body) = request.into_parts();
    let chunks =
        counted(&head.headers, body, most.saturating_add(FRAMING)).map_err(|_| too_large(most))?;
    let come = untaken.clone();
    let chunks = chunks.map(move |chunk| {
        let chunk = chunk?;
        let length = chunk.len() as u64;
        let held = come.fetch_add(length, Ordering::Relaxed) + length;
        if held > FRAMING { Err(BodyError::Unframed(FRAMING)) } else { Ok(chunk) }
    });
    let request = Request::from_parts(head, Body::from_stream(chunks));
    let mut form = Multipart::from_request(request, &())
        .await
        .map_err(|error| Problem::malformed(error.body_text()))?;
    let mut parts = Parts { state, untaken, left: most, mesh: None, labels: None, options: None };
    while let Some(field) = form.next_field().await.map_err(|error| broken(&error, most))? {
        parts.read(field).await?;
    }
    let Some((mesh, kind)) = parts.mesh else {
        return Err(Problem::malformed("The part \"file\" is missing: it holds the mesh"));
    };
    let options = parts.options.unwrap_or_default();
    Ok(Upload { mesh, kind, labels: parts.labels, options, tag: String::new() })
}

/// The parts, as they come.
struct Parts<'a> {
    state: &'a AppState,
    /// Bytes that came and that no part has taken.
    untaken: Arc<AtomicU64>,
    /// Bytes that the parts may still have.
    left: u64,
    mesh: Option<(BlobWriter, MeshKind)>,
    labels: Option<BlobWriter>,
    options: Option<UnwrapOptions>,
}

impl Parts<'_> {
    async fn read(&mut self, field: Field<'_>) -> Result<(), Problem> {
        let name = field.name().unwrap_or_default().to_owned();
        let twice = |there: bool| match there {
            true => Err(Problem::malformed(format!("The part {name:?} came twice; send it once"))),
            false => Ok(()),
        };
        match name.as_str() {
            "file" => {
                twice(self.mesh.is_some())?;
                self.mesh = Some(self.mesh(field).await?);
            }
            "labels" => {
                twice(self.labels.is_some())?;
                self.labels = Some(self.labels(field).await?);
            }
            "options" => {
                twice(self.options.is_some())?;
                self.options = Some(self.options(field).await?);
            }
            _ => {
                return Err(Problem::malformed(format!(
                    "The part {name:?} is not known; a form has the parts \"file\", \"options\" and \
                     \"labels\""
                )));
            }
        }
        Ok(())
    }

    async fn mesh(&mut self, mut field: Field<'_>) -> Result<(BlobWriter, MeshKind), Problem> {
        // Browsers and curl guess the type of a file by its name: only a model's is taken at its word.
        let media_type = essence(field.content_type().unwrap_or_default());
        let declared =
            media_type.starts_with("model/").then(|| kind_of(&media_type)).transpose()?;
        let mut mesh = Mesh::begin(&self.state.blobs, declared).await?;
        while let Some(chunk) = self.chunk(&mut field).await? {
            mesh.write(chunk).await?;
        }
        mesh.end()
    }

    async fn labels(&mut self, mut field: Field<'_>) -> Result<BlobWriter, Problem> {
        let mut labels = self.state.blobs.begin(BlobFolder::Uploads).await?;
        while let Some(chunk) = self.chunk(&mut field).await? {
            labels.write(chunk).await?;
        }
        if labels.is_empty() {
            let detail = "The part \"labels\" is empty; it has one integer a line, one line a face";
            return Err(Problem::malformed(detail));
        }
        Ok(labels)
    }

    async fn options(&mut self, mut field: Field<'_>) -> Result<UnwrapOptions, Problem> {
        let mut text = Vec::new();
        while let Some(chunk) = self.chunk(&mut field).await? {
            text.extend_from_slice(&chunk);
            if text.len() > OPTIONS {
                return Err(Problem::malformed("The part \"options\" is over 1 MiB"));
            }
        }
        parse_options(&text)
    }

    async fn chunk(&mut self, field: &mut Field<'_>) -> Result<Option<Bytes>, Problem> {
        let most = self.state.limits.upload_bytes;
        let chunk = field.chunk().await.map_err(|error| broken(&error, most))?;
        let length = chunk.as_ref().map_or(0, |chunk| chunk.len() as u64);
        self.untaken.fetch_sub(length, Ordering::Relaxed);
        self.left = self.left.checked_sub(length).ok_or_else(|| too_large(most))?;
        Ok(chunk)
    }
}

fn parse_options(text: &[u8]) -> Result<UnwrapOptions, Problem> {
    let value: serde_json::Value = serde_json::from_slice(text).map_err(|error| {
        Problem::malformed(format!("The part \"options\" is not JSON: {error}"))
    })?;
    UnwrapOptions::from_json(&value).map_err(Problem::invalid_options)
}

/// A form that could not be read: our own reason if one stands behind the error, else its text.
fn broken(error: &MultipartError, most: u64) -> Problem {
    let mut cause: Option<&(dyn Error + 'static)> = Some(error);
    while let Some(error) = cause {
        match error.downcast_ref::<BodyError>() {
            Some(BodyError::TooLarge(_)) => return too_large(most),
            Some(ours) => return ours.clone().into(),
            None => cause = error.source(),
        }
    }
    Problem::malformed(format!("The form cannot be read: {}", error.body_text()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::ErrorCode;

    #[test]
    fn options_are_json_and_right() {
        assert_eq!(parse_options(b"{\"padding\": 4}").unwrap().padding, 4);
        let code = |text: &[u8]| parse_options(text).unwrap_err().code();
        assert_eq!(code(b"{"), ErrorCode::MalformedRequest);
        assert_eq!(code(b"[]"), ErrorCode::InvalidOption);
        assert_eq!(code(b"{\"padding\": \"wide\"}"), ErrorCode::InvalidOption);
    }
}
