//! Server-sent events (<https://html.spec.whatwg.org/multipage/server-sent-events.html>): streams
//! that read the rows of `job_events` behind the reader's last id, so that nothing is lost or
//! repeated whichever server a reader comes back to.

use std::collections::VecDeque;
use std::convert::Infallible;
use std::time::Duration;

use axum::http::{HeaderMap, HeaderName, HeaderValue, header};
use axum::response::sse::{Event as Frame, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use futures::stream::{Stream, StreamExt, iter, unfold};
use serde::Serialize;

use super::{AppState, EventDataBody, JobBody, Problem};
use crate::jobs::{Changes, Event, Job, JobId, QueueError};

/// How long a reader waits before it comes back.
const RETRY: Duration = Duration::from_secs(2);
/// A comment keeps the connection open when nothing happens for this long.
const KEEP_ALIVE: Duration = Duration::from_secs(15);
/// Rows read at once.
const BATCH: u32 = 256;

/// The greatest id that is taken from a reader: eighteen digits, so that every store can hold it.
const LAST: u64 = 999_999_999_999_999_999;

/// The id that the reader saw last: by the header that a browser sends when it comes back, else by the
/// query's `after`.
pub fn seen(headers: &HeaderMap, after: Option<u64>) -> Result<Option<u64>, Problem> {
    const NAME: HeaderName = HeaderName::from_static("last-event-id");
    let wrong = |name: &str, value: &dyn std::fmt::Debug| {
        Problem::malformed(format!(
            "{name}: expected the number that came as id of the last event, not {value:?}"
        ))
    };
    if let Some(after) = after.filter(|after| *after > LAST) {
        return Err(wrong("after", &after));
    }
    let Some(value) = headers.get(NAME) else { return Ok(after) };
    let digits = value.to_str().ok().filter(|text| text.bytes().all(|b| b.is_ascii_digit()));
    let id = digits.and_then(|text| text.parse().ok()).filter(|id| *id <= LAST);
    id.map(Some).ok_or_else(|| wrong("Last-Event-ID", value))
}

/// The stream of a job from its whole present state on: a `snapshot`, then every later event.
pub fn from_snapshot(state: &AppState, job: Job) -> Response {
    let (id, seq, over) = (job.id, job.last_seq, job.state.is_terminal());
    let snapshot = framed(seq, "snapshot", &JobBody::from(job)).retry(RETRY);
    let tail = Tail::new(state, Source::Job { id, over }, seq as i64);
    respond(iter([snapshot]).chain(tail.frames()))
}

/// The stream of a job from behind `seq` on.
pub fn from_seq(state: &AppState, id: JobId, seq: u64) -> Response {
    let opening = Frame::default().retry(RETRY);
    let tail = Tail::new(state, Source::Job { id, over: false }, seq as i64);
    respond(iter([opening]).chain(tail.frames()))
}

/// The stream of all jobs from behind `event_id` on.
pub fn of_all_jobs(state: &AppState, event_id: i64) -> Response {
    // An id without data: the reader keeps it, and can come back before the first event.
    let opening = Frame::default().retry(RETRY).id(event_id.to_string());
    let tail = Tail::new(state, Source::All, event_id);
    respond(iter([opening]).chain(tail.frames()))
}

fn respond(frames: impl Stream<Item = Frame> + Send + 'static) -> Response {
    let stream = Sse::new(frames.map(Ok::<_, Infallible>))
        .keep_alive(KeepAlive::new().interval(KEEP_ALIVE).text("still here"));
    let no_cache = HeaderValue::from_static("no-cache, no-transform");
    let no_buffer = (HeaderName::from_static("x-accel-buffering"), HeaderValue::from_static("no"));
    ([(header::CACHE_CONTROL, no_cache), no_buffer], stream).into_response()
}

fn framed(id: impl ToString, name: &str, data: &impl Serialize) -> Frame {
    // serde_json escapes line ends, so one `data:` line holds it.
    let text = serde_json::to_string(data).unwrap_or_else(|_| "{}".to_owned());
    Frame::default().id(id.to_string()).event(name).data(text)
}

/// Whose events.
#[derive(Clone, Copy)]
enum Source {
    /// Those of one job; `over` once its last was sent.
    Job { id: JobId, over: bool },
    /// Those of all jobs: this never ends of itself.
    All,
}

/// Reads rows behind `after`, and waits for more when there are none.
struct Tail {
    state: AppState,
    changes: Changes,
    source: Source,
    after: i64,
    rows: VecDeque<Event>,
}

impl Tail {
    fn new(state: &AppState, source: Source, after: i64) -> Self {
        // The subscription is older than the first look, so no commit falls between.
        let changes = state.changes.clone();
        Self { state: state.clone(), changes, source, after, rows: VecDeque::new() }
    }

    fn frames(self) -> impl Stream<Item = Frame> + Send {
        unfold(self, |mut tail| async move {
            match tail.next().await {
                Ok(frame) => frame.map(|frame| (frame, tail)),
                Err(error) => {
                    // The reader comes back with its last id and misses nothing.
                    tracing::error!(%error, "an event stream broke off");
                    None
                }
            }
        })
    }

    /// The next frame; `None` when the job is over and all was sent, or is gone, and when the service
    /// closes: then what stands in the rows by that time is sent first, such as the end of the job
    /// that the service waited for.
    async fn next(&mut self) -> Result<Option<Frame>, QueueError> {
        loop {
            if let Some(event) = self.rows.pop_front() {
                return Ok(Some(self.frame(event)));
            }
            let closing = self.state.closing.is_cancelled();
            let rows = match self.source {
                Source::Job { over: true, .. } => return Ok(None),
                Source::Job { id, .. } => {
                    self.state.queue.events_after(id, self.after as u64, BATCH).await?
                }
                Source::All => self.state.queue.all_events_after(self.after, BATCH).await?,
            };
            self.rows = rows.into();
            if !self.rows.is_empty() {
                continue;
            }
            if closing {
                return Ok(None);
            }
            if let Source::Job { id, .. } = self.source
                && self.all_sent(id).await?
            {
                return Ok(None);
            }
            tokio::select! {
                () = self.changes.changed_within(KEEP_ALIVE) => {}
                () = self.state.closing.cancelled() => {}
            }
        }
    }

    /// Whether no row can follow: the job is over and its last row was sent, or it was deleted.
    async fn all_sent(&self, id: JobId) -> Result<bool, QueueError> {
        let job = self.state.queue.get(id).await?;
        Ok(job.is_none_or(|job| job.state.is_terminal() && job.last_seq as i64 <= self.after))
    }

    fn frame(&mut self, event: Event) -> Frame {
        let kind = event.kind();
        self.after = match &mut self.source {
            Source::Job { over, .. } => {
                *over = kind.is_terminal();
                event.seq as i64
            }
            Source::All => event.event_id,
        };
        framed(self.after, kind.as_str(), &EventDataBody::from(event))
    }
}
