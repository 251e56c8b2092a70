//! The files that a job made. Their bytes never change, so the SHA-256 is a strong entity tag, and
//! a broken download goes on where it broke off.

use std::sync::LazyLock;

use axum::Json;
use axum::body::Body;
use axum::extract::{Path, State};
use axum::http::{HeaderMap, HeaderValue, Method, Response, StatusCode, header};
use axum::response::IntoResponse;

use crate::contract::{ArtifactKind, ErrorCode};
use crate::http::conditional::{ETag, Range};
use crate::http::docs::{FileBytes, refusals};
use crate::http::{AppState, ArtifactBody, ArtifactList, Problem};
use crate::jobs::{BlobError, Job, JobId, StoredArtifact};

/// A picture or a model never runs a script in the name of this service.
const SANDBOX: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; sandbox";

refusals! { ListRefused: MalformedRequest NotFound Internal }

/// List what a job made
///
/// Empty until the job is over. A job that failed has its log if a worker has run it. After expiry the
/// list stays and the files are gone.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/artifacts", tag = "artifacts", operation_id = "list_artifacts",
    params(("id" = JobId, Path, description = "The job")),
    responses((status = 200, description = "The files", body = ArtifactList), ListRefused),
)]
pub async fn list(
    State(state): State<AppState>,
    Path(id): Path<String>,
) -> Result<Json<ArtifactList>, Problem> {
    let job = state.job(&id).await?;
    let data = job.artifacts.iter().map(|artifact| ArtifactBody::of(&job, artifact)).collect();
    Ok(Json(ArtifactList { data }))
}

/// Every file that a job can make, in words.
static NAMES: LazyLock<String> = LazyLock::new(|| {
    let file = |kind: &ArtifactKind| format!("`{}` ({})", kind.name(), kind.when().as_str());
    format!(
        "The file's name: {}",
        ArtifactKind::ALL.iter().map(file).collect::<Vec<_>>().join(", ")
    )
});

refusals! { FetchRefused: MalformedRequest NotFound ArtifactExpired RangeNotSatisfiable Internal }

/// Get a file
///
/// Its name is one of the table in the description of the parameter.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/artifacts/{name}", tag = "artifacts", operation_id = "get_artifact",
    params(
        ("id" = JobId, Path, description = "The job"),
        ("name" = String, Path, description = NAMES.as_str(), example = "model.glb"),
        ("Range" = Option<String>, Header, nullable = false, description = "One range of bytes, as in `bytes=0-1023`"),
        ("If-Range" = Option<String>, Header, nullable = false, description = "The ETag that the range is of"),
        ("If-None-Match" = Option<String>, Header, nullable = false, description = "The ETag that the client has"),
    ),
    responses(
        (status = 200, description = "The file, under its own media type",
            // `docs::add_artifacts` puts the media types of the table here.
            body = inline(FileBytes), content_type = "application/octet-stream", headers(
                ("ETag" = String, description = "SHA-256 of the file, in quotes"),
                ("Accept-Ranges" = String, description = "`bytes`"))),
        (status = 206, description = "The range", body = inline(FileBytes),
            content_type = "application/octet-stream",
            headers(("Content-Range" = String, description = "Where the bytes are in the file"))),
        (status = 304, description = "The client has the file"),
        FetchRefused,
    ),
)]
pub async fn fetch(
    State(state): State<AppState>,
    method: Method,
    Path((id, name)): Path<(String, String)>,
    headers: HeaderMap,
) -> Result<Response<Body>, Problem> {
    let job = state.job(&id).await?;
    let Some(artifact) = job.artifacts.iter().find(|artifact| artifact.name == name) else {
        return Err(unknown(&job, &name));
    };
    if job.expired {
        return Err(expired(&name));
    }
    let etag = ETag::of_sha256(&artifact.sha256);
    if etag.is_known(&headers) {
        return describe(Response::builder(), StatusCode::NOT_MODIFIED, &etag, artifact)
            .body(Body::empty())
            .map_err(Problem::internal);
    }
    // A range is for GET alone.
    let range = match method == Method::GET && etag.allows_range(&headers) {
        true => Range::of(&headers, artifact.bytes),
        false => Range::Whole,
    };
    let (status, range) = match range {
        Range::Whole => (StatusCode::OK, 0..artifact.bytes),
        Range::Part(range) => (StatusCode::PARTIAL_CONTENT, range),
        Range::Outside => return Err(outside(artifact)),
    };
    let mut response = describe(Response::builder(), status, &etag, artifact)
        .header(header::CONTENT_LENGTH, range.end - range.start);
    if status == StatusCode::PARTIAL_CONTENT {
        let place = format!("bytes {}-{}/{}", range.start, range.end - 1, artifact.bytes);
        response = response.header(header::CONTENT_RANGE, place);
    }
    let body = match method == Method::HEAD || range.is_empty() {
        true => Body::empty(),
        false => {
            let part = (status == StatusCode::PARTIAL_CONTENT).then_some(range);
            match state.blobs.get(&artifact.blob, part).await {
                Ok(bytes) => Body::from_stream(bytes),
                // It expired, or the job was deleted, since the row was read.
                Err(BlobError::NotFound(_)) => {
                    return match state.job(&id).await? {
                        job if job.expired => Err(expired(&name)),
                        _ => Err(Problem::internal(format_args!("{} is gone", artifact.blob))),
                    };
                }
                Err(error) => return Err(error.into()),
            }
        }
    };
    Ok(response.body(body).map_err(Problem::internal)?.into_response())
}

fn describe(
    response: axum::http::response::Builder,
    status: StatusCode,
    etag: &ETag,
    artifact: &StoredArtifact,
) -> axum::http::response::Builder {
    response
        .status(status)
        .header(header::ETAG, etag.value())
        .header(header::ACCEPT_RANGES, "bytes")
        .header(header::CACHE_CONTROL, "private, no-cache")
        .header(header::CONTENT_SECURITY_POLICY, SANDBOX)
        .header(header::CONTENT_DISPOSITION, format!("inline; filename=\"{}\"", artifact.name))
        .header(header::CONTENT_TYPE, &artifact.media_type)
}

fn unknown(job: &Job, name: &str) -> Problem {
    let names: Vec<_> = job.artifacts.iter().map(|artifact| artifact.name.as_str()).collect();
    let there = match names.is_empty() {
        true => format!("the job is {} and has no artifacts", job.state.as_str()),
        false => format!("there are {}", names.join(", ")),
    };
    Problem::new(ErrorCode::NotFound, format!("The artifact {name:?} is not there; {there}"))
}

fn expired(name: &str) -> Problem {
    let detail = format!("{name} was kept for its time and is gone; submit the mesh again");
    Problem::new(ErrorCode::ArtifactExpired, detail)
}

fn outside(artifact: &StoredArtifact) -> Problem {
    let detail = format!("Range: {} has {} bytes", artifact.name, artifact.bytes);
    let length = HeaderValue::from_str(&format!("bytes */{}", artifact.bytes));
    let problem = Problem::new(ErrorCode::RangeNotSatisfiable, detail);
    match length {
        Ok(length) => problem.with_header(header::CONTENT_RANGE, length),
        Err(_) => problem,
    }
}
