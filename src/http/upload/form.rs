//! A mesh in a form (RFC 7578): the part `file` holds it, `options` says what to do, and every other
//! role of an input has a part of its own; each once, in any order.

use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use axum::body::Body;
use axum::extract::multipart::{Field, MultipartError};
use axum::extract::{FromRequest, Multipart, Request};
use bytes::Bytes;
use futures::StreamExt;

use super::mesh::Mesh;
use super::{Received, Upload, essence, kind_of};
use crate::contract::{InputRole, MeshKind, UnwrapOptions};
use crate::http::incoming::{BodyError, counted, too_large};
use crate::http::{AppState, Problem};
use crate::jobs::{BlobFolder, BlobWriter};

/// Bytes that a form may have outside of its parts, in their headers and boundaries. The reader of
/// forms holds those in memory, so they are bounded by themselves.
const FRAMING: u64 = 4 << 20;
/// Characters of a file's name.
const FILE_NAME: usize = 255;
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
    let mut parts = Parts { state, untaken, left: most, inputs: Vec::new(), options: None };
    while let Some(field) = form.next_field().await.map_err(|error| broken(&error, most))? {
        parts.read(field).await?;
    }
    if !parts.has(InputRole::Mesh) {
        let (part, holds) = (InputRole::Mesh.form_part(), InputRole::Mesh.holds());
        return Err(Problem::malformed(format!("The part {part:?} is missing: it {holds}")));
    }
    let options = parts.options.unwrap_or_default();
    Ok(Upload { inputs: parts.inputs, options, tag: String::new() })
}

/// The parts, as they come.
struct Parts<'a> {
    state: &'a AppState,
    /// Bytes that came and that no part has taken.
    untaken: Arc<AtomicU64>,
    /// Bytes that the parts may still have.
    left: u64,
    inputs: Vec<Received>,
    options: Option<UnwrapOptions>,
}

impl Parts<'_> {
    async fn read(&mut self, field: Field<'_>) -> Result<(), Problem> {
        let name = field.name().unwrap_or_default().to_owned();
        let twice = |there: bool| match there {
            true => Err(Problem::malformed(format!("The part {name:?} came twice; send it once"))),
            false => Ok(()),
        };
        if name == "options" {
            twice(self.options.is_some())?;
            self.options = Some(self.options(field).await?);
            return Ok(());
        }
        let role = InputRole::ALL.iter().copied().find(|role| role.form_part() == name);
        let role = role.ok_or_else(|| unknown(&name))?;
        twice(self.has(role))?;
        let file_name = field.file_name().unwrap_or_default().chars().take(FILE_NAME).collect();
        let input = match role {
            InputRole::Mesh => Received::mesh(file_name, self.mesh(field).await?),
            role => {
                let blob = self.beside(role, field).await?;
                Received { role, name: file_name, kind: None, blob }
            }
        };
        self.inputs.push(input);
        Ok(())
    }

    fn has(&self, role: InputRole) -> bool {
        self.inputs.iter().any(|input| input.role == role)
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

    async fn beside(
        &mut self,
        role: InputRole,
        mut field: Field<'_>,
    ) -> Result<BlobWriter, Problem> {
        let mut blob = self.state.blobs.begin(BlobFolder::Uploads).await?;
        while let Some(chunk) = self.chunk(&mut field).await? {
            blob.write(chunk).await?;
        }
        if blob.is_empty() {
            let (part, holds) = (role.form_part(), role.holds());
            return Err(Problem::malformed(format!("The part {part:?} is empty; it {holds}")));
        }
        Ok(blob)
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

fn unknown(name: &str) -> Problem {
    let mut parts: Vec<_> = InputRole::ALL.iter().map(|role| role.form_part()).collect();
    parts.insert(1, "options");
    let (last, others) = parts.split_last().map_or(("", &[][..]), |(last, others)| (*last, others));
    let others: Vec<_> = others.iter().map(|part| format!("{part:?}")).collect();
    let others = others.join(", ");
    Problem::malformed(format!(
        "The part {name:?} is not known; a form has the parts {others} and {last:?}"
    ))
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
