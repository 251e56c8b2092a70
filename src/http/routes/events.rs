//! What happens to jobs, as streams of server-sent events and as lists.

use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Path, Query, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;

use crate::http::docs::{StreamEvent, refusals};
use crate::http::{AppState, EventBody, EventList, Problem, sse};
use crate::jobs::JobId;

/// Events in one list.
const LIST: u32 = 1000;

/// From where on.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct After {
    /// Only events with a greater id.
    after: Option<u64>,
}

refusals! { Refused: MalformedRequest NotFound Internal }

/// Follow a job
///
/// The first event is `snapshot` (the whole job); then come `stage`, `progress` (at most two a
/// second), `part_completed`, `warning` and `retrying`; the last is `succeeded`, `failed` or
/// `canceled`, and the stream ends. A client that comes back with `Last-Event-ID` (or `?after=`)
/// gets no snapshot, only what it has not seen. With `Accept: application/json` the same events come
/// as a list, at most 1000 at a time.
#[utoipa::path(
    get, path = "/v1/jobs/{id}/events", tag = "events", operation_id = "job_events",
    params(
        ("id" = JobId, Path, description = "The job"),
        ("after" = Option<u64>, Query, maximum = 999999999999999999u64, description = "Only events with a greater id"),
        ("Last-Event-ID" = Option<String>, Header, nullable = false, pattern = "^[0-9]{1,18}$", description = "The id of the last event seen"),
        ("Accept" = Option<String>, Header, nullable = false,
            description = "`text/event-stream` (default) or `application/json`"),
    ),
    responses(
        (status = 200, description = "The events", content(
            (StreamEvent = "text/event-stream"),
            (EventList = "application/json"),
        )),
        (status = 204, description = "The job is over and every event was seen: do not come back"),
        Refused,
    ),
)]
pub async fn of_job(
    State(state): State<AppState>,
    Path(id): Path<String>,
    query: Result<Query<After>, QueryRejection>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let Query(query) = query?;
    let seen = sse::seen(&headers, query.after)?;
    let job = state.job(&id).await?;
    if wants_list(&headers) {
        let after = seen.unwrap_or(0);
        let events = state.queue.events_after(job.id, after, LIST).await?;
        let data: Vec<_> = events.into_iter().map(EventBody::from).collect();
        let next_after = data.last().map_or(after, |event| event.id);
        return Ok(Json(EventList { data, next_after }).into_response());
    }
    Ok(match seen {
        None => sse::from_snapshot(&state, job),
        Some(seq) if job.state.is_terminal() && seq >= job.last_seq => {
            StatusCode::NO_CONTENT.into_response()
        }
        Some(seq) => sse::from_seq(&state, job.id, seq),
    })
}

refusals! { AllRefused: MalformedRequest Internal }

/// Follow all jobs
///
/// Every event of every job from now on (or from behind `Last-Event-ID`), with `job_id` in the data.
/// The ids are those of this stream, not of the jobs' own.
#[utoipa::path(
    get, path = "/v1/events", tag = "events", operation_id = "events",
    params(
        ("after" = Option<u64>, Query, maximum = 999999999999999999u64, description = "Only events with a greater id"),
        ("Last-Event-ID" = Option<String>, Header, nullable = false, pattern = "^[0-9]{1,18}$", description = "The id of the last event seen"),
    ),
    responses(
        (status = 200, description = "The events", content((StreamEvent = "text/event-stream"))),
        AllRefused,
    ),
)]
pub async fn of_all(
    State(state): State<AppState>,
    query: Result<Query<After>, QueryRejection>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let Query(query) = query?;
    let seen = match sse::seen(&headers, query.after)? {
        Some(seen) => seen as i64,
        None => state.queue.last_event_id().await?,
    };
    Ok(sse::of_all_jobs(&state, seen))
}

/// Whether the client asks for JSON, and not for a stream.
fn wants_list(headers: &HeaderMap) -> bool {
    let accept = headers.get(header::ACCEPT).and_then(|v| v.to_str().ok()).unwrap_or_default();
    accept.contains("application/json") && !accept.contains("text/event-stream")
}
