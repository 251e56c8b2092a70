//! Jobs: submit, look at, list, cancel, delete.

use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Path, Query, Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;

use crate::contract::ErrorCode;
use crate::http::conditional::ETag;
use crate::http::docs::{FileBytes, JobForm, refusals};
use crate::http::upload::{Received, Upload};
use crate::http::{AppState, JobBody, JobList, Problem, prefer, wait};
use crate::jobs::{
    BlobError, Blobs, CancelOutcome, Deleted, Job, JobId, JobState, ListFilter, NewJob, StoredBlob,
    StoredInput,
};

/// Seconds after which a client may look at a job again.
const RETRY_AFTER: &str = "1";
/// Most jobs in a page.
const PAGE: u32 = 100;

refusals! { SubmitRefused: MalformedRequest UploadTooLarge UnsupportedMediaType InvalidOption QueueQuotaExceeded Internal Draining StorageFull }

/// Have a mesh unwrapped
///
/// Either a form, or the mesh itself as body with the options in the query (`?padding=4&quality=best`;
/// every property of `UnwrapOptions` is a query parameter). The kind of mesh is decided by its bytes.
/// A mesh that is broken inside is accepted, and its job fails with `invalid_mesh`.
#[utoipa::path(
    post, path = "/v1/jobs", tag = "jobs", operation_id = "submit_job",
    params(
        ("tag" = Option<String>, Query, max_length = 128, pattern = r"^[^\x00-\x1f\x7f-\x9f]*$",
            description = "A word to find the job again, at most 128 characters, none of them a control"),
        ("Prefer" = Option<String>, Header, nullable = false, description = "`wait=N`: answer when the job is over, or after N seconds (at most 60)"),
    ),
    request_body(content(
        (JobForm = "multipart/form-data"),
        // Beside it, the media type of every format: `docs::add_formats`.
        (inline(FileBytes) = "application/octet-stream"),
    )),
    responses(
        (status = 202, description = "The job is queued, and will be done whatever happens to the service", body = JobBody, headers(
            ("Location" = String, description = "Where the job is"),
            ("Retry-After" = u32, description = "Seconds after which to look again"))),
        (status = 200, description = "The job is over within the wait", body = JobBody,
            headers(("Location" = String, description = "Where the job is"))),
        SubmitRefused,
    ),
)]
pub async fn submit(State(state): State<AppState>, request: Request) -> Result<Response, Problem> {
    state.takes_new_work()?;
    let patience = prefer::wait(request.headers());
    let upload = Upload::receive(&state, request).await?;
    // In a task of its own: a client that goes away now must not leave a blob without a row.
    let queue = tokio::spawn(enqueue(state.clone(), upload));
    let mut job = queue.await.map_err(Problem::internal)??;
    if !patience.is_zero() {
        let over = |job: &Job| job.state.is_terminal();
        job = wait::until(&state, job.id, patience, over).await?.unwrap_or(job);
    }
    let location = (header::LOCATION, JobBody::url(job.id));
    let over = job.state.is_terminal();
    let body = Json(JobBody::from(job));
    Ok(match over {
        true => (StatusCode::OK, [location], body).into_response(),
        false => {
            let retry = (header::RETRY_AFTER, RETRY_AFTER.to_owned());
            (StatusCode::ACCEPTED, [location, retry], body).into_response()
        }
    })
}

/// Put the blobs in place, then the row that names them; take the blobs away if that fails.
async fn enqueue(state: AppState, upload: Upload) -> Result<Job, Problem> {
    let mut placed = Vec::new();
    for Received { role, name, kind, blob } in upload.inputs {
        match blob.finish().await {
            Ok(StoredBlob { name: blob, bytes, sha256 }) => {
                placed.push(StoredInput { role, name, kind, sha256, bytes, blob });
            }
            Err(error) => {
                discard(&state.blobs, placed.into_iter().map(|input| input.blob)).await;
                return Err(error.into());
            }
        }
    }
    let blobs: Vec<_> = placed.iter().map(|input| input.blob.clone()).collect();
    let job = NewJob {
        id: JobId::new(),
        inputs: placed.into_iter().collect(),
        options: upload.options,
        tag: upload.tag,
        priority: 0,
    };
    match state.queue.submit(job, state.limits.queued_jobs).await {
        Ok(job) => Ok(job),
        Err(error) => {
            discard(&state.blobs, blobs).await;
            Err(error.into())
        }
    }
}

/// Delete blobs that no row names. What cannot be deleted now is swept later.
async fn discard(blobs: &Blobs, names: impl IntoIterator<Item = String>) {
    for name in names {
        if let Err(error @ (BlobError::Store(_) | BlobError::StorageFull)) =
            blobs.delete(&name).await
        {
            tracing::warn!(name, %error, "a blob that no row names stays until the sweep");
        }
    }
}

/// Which jobs to list.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ListQuery {
    /// Only jobs in this state.
    state: Option<JobState>,
    /// Only jobs with this tag.
    tag: Option<String>,
    /// At most this many.
    limit: Option<u32>,
    /// The `next_cursor` of the page before.
    cursor: Option<String>,
}

refusals! { ListRefused: MalformedRequest Internal }

/// List jobs, newest first
#[utoipa::path(
    get, path = "/v1/jobs", tag = "jobs", operation_id = "list_jobs",
    params(
        ("state" = Option<JobState>, Query, description = "Only jobs in this state"),
        ("tag" = Option<String>, Query, description = "Only jobs with this tag"),
        ("limit" = Option<u32>, Query, minimum = 1, maximum = 100, description = "At most this many; 20 if not given"),
        ("cursor" = Option<String>, Query, pattern = "^job_[0-9a-f]{32}$", description = "The `next_cursor` of the page before"),
    ),
    responses((status = 200, description = "A page of jobs", body = JobList), ListRefused),
)]
pub async fn list(
    State(state): State<AppState>,
    query: Result<Query<ListQuery>, QueryRejection>,
) -> Result<Json<JobList>, Problem> {
    let Query(query) = query?;
    if let Some(limit) = query.limit
        && !(1..=PAGE).contains(&limit)
    {
        return Err(Problem::malformed(format!("limit: must be from 1 to {PAGE}, not {limit}")));
    }
    let filter = ListFilter {
        state: query.state,
        tag: query.tag,
        limit: query.limit.unwrap_or(0),
        cursor: query.cursor,
    };
    let page = state.queue.list(&filter).await?;
    let data = page.jobs.into_iter().map(JobBody::from).collect();
    Ok(Json(JobList { data, next_cursor: page.next_cursor }))
}

refusals! { ShowRefused: MalformedRequest NotFound Internal }

/// Look at a job
///
/// With `Prefer: wait=N` the answer is held back until the job is over; with `If-None-Match` as well,
/// until it is another than the client has (a long poll).
#[utoipa::path(
    get, path = "/v1/jobs/{id}", tag = "jobs", operation_id = "get_job",
    params(
        ("id" = JobId, Path, description = "The job"),
        ("If-None-Match" = Option<String>, Header, nullable = false, description = "The ETag that the client has"),
        ("Prefer" = Option<String>, Header, nullable = false, description = "`wait=N`: at most N seconds (at most 60)"),
    ),
    responses(
        (status = 200, description = "The job", body = JobBody,
            headers(("ETag" = String, description = "Changes with every change of the job"))),
        (status = 304, description = "The job is as the client has it"),
        ShowRefused,
    ),
)]
pub async fn show(
    State(state): State<AppState>,
    Path(id): Path<String>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let mut job = state.job(&id).await?;
    let patience = prefer::wait(&headers);
    if !patience.is_zero() {
        let polled = headers.contains_key(header::IF_NONE_MATCH);
        let enough = |job: &Job| match polled {
            true => !Shown::of(job.clone()).etag.is_known(&headers),
            false => job.state.is_terminal(),
        };
        let gone = || Problem::not_found(format_args!("The job {id:?}"));
        job = wait::until(&state, job.id, patience, enough).await?.ok_or_else(gone)?;
    }
    let shown = Shown::of(job);
    let head = [
        (header::ETAG, shown.etag.value()),
        (header::CACHE_CONTROL, HeaderValue::from_static("private, no-cache")),
    ];
    if shown.etag.is_known(&headers) {
        return Ok((StatusCode::NOT_MODIFIED, head).into_response());
    }
    let json = (header::CONTENT_TYPE, HeaderValue::from_static("application/json"));
    Ok((head, [json], shown.json).into_response())
}

/// A job as it is sent, and the tag of these bytes.
struct Shown {
    json: Vec<u8>,
    etag: ETag,
}

impl Shown {
    fn of(job: Job) -> Self {
        let json = serde_json::to_vec(&JobBody::from(job)).unwrap_or_default();
        let etag = ETag::of(&json);
        Self { json, etag }
    }
}

refusals! { CancelRefused: MalformedRequest NotFound Internal }

/// Cancel a job
///
/// Idempotent. A job that waits is canceled at once, one that runs within two seconds.
#[utoipa::path(
    post, path = "/v1/jobs/{id}/cancel", tag = "jobs", operation_id = "cancel_job",
    params(("id" = JobId, Path, description = "The job")),
    responses(
        (status = 202, description = "The job runs and was told to stop", body = JobBody),
        (status = 200, description = "The job is over", body = JobBody),
        CancelRefused,
    ),
)]
pub async fn cancel(
    State(state): State<AppState>,
    Path(id): Path<String>,
) -> Result<(StatusCode, Json<JobBody>), Problem> {
    let job = state.job(&id).await?;
    match state.queue.request_cancel(job.id).await? {
        CancelOutcome::NotFound => Err(Problem::not_found(format_args!("The job {id:?}"))),
        CancelOutcome::Requested(job) => Ok((StatusCode::ACCEPTED, Json(job.into()))),
        CancelOutcome::Over(job) => Ok((StatusCode::OK, Json(job.into()))),
    }
}

refusals! { DeleteRefused: MalformedRequest NotFound JobNotTerminal Internal }

/// Delete a job that is over, with its upload, its artifacts and its events
#[utoipa::path(
    delete, path = "/v1/jobs/{id}", tag = "jobs", operation_id = "delete_job",
    params(("id" = JobId, Path, description = "The job")),
    responses((status = 204, description = "It is gone"), DeleteRefused),
)]
pub async fn delete(
    State(state): State<AppState>,
    Path(id): Path<String>,
) -> Result<StatusCode, Problem> {
    let job = state.job(&id).await?;
    match state.queue.delete(job.id).await? {
        Deleted::NotFound => Err(Problem::not_found(format_args!("The job {id:?}"))),
        Deleted::NotTerminal => Err(Problem::new(
            ErrorCode::JobNotTerminal,
            format!("The job is not over; cancel it first: POST {}/cancel", JobBody::url(job.id)),
        )),
        Deleted::Deleted { blobs } => {
            discard(&state.blobs, blobs).await;
            Ok(StatusCode::NO_CONTENT)
        }
    }
}
