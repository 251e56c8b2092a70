//! One attempt of one job: the pipeline runs on its thread, and beside it the tick writes events,
//! holds the lease and learns whether to stop.

use std::future::pending;
use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use tokio::sync::oneshot;
use tokio::time::{Instant, MissedTickBehavior, interval, sleep_until};
use tokio_util::sync::CancellationToken;

use super::pipeline_thread::{Beside, Call, Outcome, start};
use super::reporter::Reporter;
use super::results::{discard, store_all};
use crate::contract::{ArtifactKind, Budget, Cancel, ErrorCode, InputRole, JobError, Limits, Run};
use crate::jobs::{
    Blobs, Changes, Claim, Handover, Job, JobState, Lease, MetricsSummary, NewEvent, QueueError,
    StoredArtifact, Tick, TickAnswer, Work,
};
use crate::pipeline::{Engine, Unwrapped};
use crate::telemetry::JobLog;

/// How often events are written.
const TICK: Duration = Duration::from_millis(500);
/// How often the lease is extended.
const EXTEND: Duration = Duration::from_secs(5);
/// How long the pipeline gets to stop: a factorisation cannot look at its token.
const GRACE: Duration = Duration::from_millis(1500);

/// What every attempt of a worker is given.
pub struct Context {
    /// The queue.
    pub queue: Arc<dyn Work>,
    /// The blobs.
    pub blobs: Blobs,
    /// Tells when somebody may have asked for the job to stop.
    pub changes: Changes,
    /// What computes.
    pub engine: Engine,
    /// What is accepted.
    pub limits: Limits,
    /// Set when the worker is to shut down.
    pub drain: CancellationToken,
    /// How long a job may go on after that.
    pub drain_timeout: Duration,
}

/// Whether this process can take another job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Next {
    /// It can.
    Go,
    /// It cannot: the pipeline still runs, or it left the process in an unknown state.
    Renew,
}

/// Why the pipeline was told to stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stop {
    Canceled,
    Drained,
    TimedOut,
    LeaseLost,
}

/// How the pipeline's part of the attempt ended.
enum End {
    /// It returned.
    Returned(Outcome),
    /// It was told to stop and did not.
    Overdue,
}

/// Run the job that was claimed, to whatever end. Errors are errors of the queue: the job is then
/// taken back when the lease lapses.
pub async fn run(context: &Context, claim: Claim) -> Result<Next, QueueError> {
    let Claim { job, lease } = claim;
    JobLog::begin();
    tracing::info!(job = %job.id, attempt = job.attempt, "job begins");
    let mut attempt = Attempt {
        context,
        lease,
        reporter: Arc::new(Reporter::new(job.attempt)),
        cancel: Cancel::default(),
        unwritten: Tick::default(),
        stop: None,
    };
    let ended = match attempt.start(&job).await {
        Ok(outcome) => attempt.watch(outcome).await,
        Err(error) => End::Returned(Outcome::Failed(error)),
    };
    let next = attempt.conclude(ended).await;
    JobLog::end();
    next
}

struct Attempt<'a> {
    context: &'a Context,
    lease: Lease,
    reporter: Arc<Reporter>,
    cancel: Cancel,
    /// What the pipeline told and no tick has written yet.
    unwritten: Tick,
    stop: Option<Stop>,
}

impl Attempt<'_> {
    /// Fetch the input and begin the pipeline.
    async fn start(&self, job: &Job) -> Result<oneshot::Receiver<Outcome>, JobError> {
        let (mut mesh, mut beside) = (None, Vec::new());
        for input in job.inputs.iter() {
            let bytes = self.fetch(&input.blob).await?;
            match input.kind {
                Some(kind) if input.role == InputRole::Mesh => mesh = Some((kind, bytes)),
                _ => beside.push(Beside { role: input.role, name: input.name.clone(), bytes }),
            }
        }
        let no_mesh = || JobError::new(ErrorCode::Internal, "the job has no mesh of a known kind");
        let (kind, mesh) = mesh.ok_or_else(no_mesh)?;
        let limits = &self.context.limits;
        let reporter = self.reporter.clone();
        let run = Run::new(
            move |progress| reporter.tell(progress),
            self.cancel.clone(),
            Budget::new(job.options.budget_s, job.options.budget_mib),
        );
        start(Call {
            mesh,
            kind,
            beside,
            options: job.options.clone(),
            limits: limits.clone(),
            engine: self.context.engine.clone(),
            run,
        })
        .map_err(|error| JobError::new(ErrorCode::Internal, format!("cannot start: {error}")))
    }

    async fn fetch(&self, blob: &str) -> Result<Bytes, JobError> {
        self.context.blobs.read(blob).await.map_err(|error| {
            JobError::new(ErrorCode::Internal, format!("cannot read the upload: {error}"))
        })
    }

    /// Tick until the pipeline returns, or does not though it was told to stop.
    async fn watch(&mut self, mut outcome: oneshot::Receiver<Outcome>) -> End {
        let began = Instant::now();
        let limit = began + Duration::from_secs(self.context.limits.job_seconds);
        let mut changes = self.context.changes.clone();
        let mut ticks = interval(TICK);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut extended = began;
        let mut drained_at = None;
        let mut overdue_at: Option<Instant> = None;
        loop {
            tokio::select! {
                ended = &mut outcome => {
                    let gone = |_| Outcome::Panicked("its thread is gone".into());
                    return End::Returned(ended.unwrap_or_else(gone));
                }
                () = at(overdue_at) => return End::Overdue,
                () = at(drained_at), if self.stop.is_none() => self.halt(Stop::Drained),
                () = sleep_until(limit), if self.stop.is_none() => self.halt(Stop::TimedOut),
                () = self.context.drain.cancelled(), if drained_at.is_none() => {
                    drained_at = Some(Instant::now() + self.context.drain_timeout);
                }
                _ = ticks.tick() => {
                    let extend = extended.elapsed() >= EXTEND;
                    if self.tick(extend).await && extend {
                        extended = Instant::now();
                    }
                }
                () = changes.changed(), if self.stop.is_none() => self.look().await,
            }
            if self.stop.is_some() {
                overdue_at.get_or_insert(Instant::now() + GRACE);
            }
        }
    }

    /// Tell the pipeline to stop, once.
    fn halt(&mut self, stop: Stop) {
        if self.stop.is_none() {
            tracing::info!(job = %self.lease.job, reason = ?stop, "told to stop");
            self.stop = Some(stop);
            self.cancel.cancel();
        }
    }

    /// Write what there is to write. What could not be written is kept for the next time.
    async fn tick(&mut self, extend: bool) -> bool {
        self.gather();
        let tick = Tick { extend, ..self.unwritten.clone() };
        match self.context.queue.tick(&self.lease, tick).await {
            Ok(answer) => {
                self.unwritten = Tick::default();
                self.obey(answer);
                true
            }
            Err(error) => {
                tracing::warn!(%error, "a tick failed");
                false
            }
        }
    }

    /// Something was committed somewhere: was it a request to cancel? This only reads.
    async fn look(&mut self) {
        if let Ok(answer) = self.context.queue.tick(&self.lease, Tick::default()).await {
            self.obey(answer);
        }
    }

    fn obey(&mut self, answer: TickAnswer) {
        match answer {
            TickAnswer::Continue => {}
            TickAnswer::Cancel => self.halt(Stop::Canceled),
            TickAnswer::LeaseLost => self.halt(Stop::LeaseLost),
        }
    }

    fn gather(&mut self) {
        let (events, progress) = self.reporter.take();
        self.unwritten.events.extend(events);
        self.unwritten.progress = progress.or(self.unwritten.progress.take());
    }

    /// The events and the progress that go with the end.
    fn rest(&mut self) -> (Vec<NewEvent>, Handover) {
        self.gather();
        let rest = std::mem::take(&mut self.unwritten);
        let handover = Handover { progress: rest.progress, ..Handover::default() };
        (rest.events, handover)
    }

    /// Commit the end of the attempt.
    async fn conclude(&mut self, ended: End) -> Result<Next, QueueError> {
        let (next, outcome) = match ended {
            End::Returned(outcome @ Outcome::Panicked(_)) => (Next::Renew, outcome),
            End::Returned(outcome) => (Next::Go, outcome),
            End::Overdue => {
                tracing::warn!(job = %self.lease.job, "the pipeline did not stop in time");
                (Next::Renew, Outcome::Canceled)
            }
        };
        let committed = match outcome {
            Outcome::Done(unwrapped) => self.succeed(&unwrapped).await.map(|()| next),
            Outcome::Failed(error) => self.fail(error).await.map(|lost| lost.unwrap_or(next)),
            Outcome::Panicked(message) => {
                let error = format!("the pipeline panicked: {message}");
                self.fail(JobError::new(ErrorCode::WorkerCrashed, error)).await.map(|_| next)
            }
            Outcome::Canceled => self.stopped().await.map(|()| next),
        };
        match committed {
            Err(QueueError::LeaseLost) => {
                tracing::warn!(job = %self.lease.job, "the lease was lost, nothing is committed");
                Ok(next)
            }
            other => other,
        }
    }

    async fn succeed(&mut self, unwrapped: &Unwrapped) -> Result<(), QueueError> {
        let (events, mut handover) = self.rest();
        if let Some(progress) = &mut handover.progress {
            (progress.fraction, progress.eta_s) = (1.0, Some(0.0));
        }
        tracing::info!(job = %self.lease.job, "job succeeded");
        let files = unwrapped.artifacts().iter();
        let files = files.map(|file| (file.kind, Bytes::from(file.bytes.clone())));
        let stored = store_all(&self.context.blobs, files.chain([log()])).await;
        let artifacts = match stored {
            Ok(artifacts) => artifacts,
            Err(error) => {
                let error = format!("the result cannot be stored: {error}");
                self.unwritten.events = events;
                return self.fail(JobError::new(ErrorCode::Internal, error)).await.map(|_| ());
            }
        };
        let metrics = Some(MetricsSummary::from(&unwrapped.metrics));
        let handover = Handover { events, artifacts: artifacts.clone(), metrics, ..handover };
        let committed = self.context.queue.finish(&self.lease, handover).await;
        self.keep_if_ok(committed, &artifacts).await
    }

    /// Says that this process is to be renewed where the device was lost.
    async fn fail(&mut self, error: JobError) -> Result<Option<Next>, QueueError> {
        let (events, handover) = self.rest();
        tracing::warn!(job = %self.lease.job, %error, "attempt failed");
        let lost = error.code == ErrorCode::DeviceLost;
        // A log that cannot be stored must not hide the error that it was to explain.
        let artifacts = store_all(&self.context.blobs, [log()]).await.unwrap_or_default();
        let handover = Handover { events, artifacts: artifacts.clone(), ..handover };
        let state = self.context.queue.fail(&self.lease, error, handover).await;
        if matches!(state, Ok(JobState::Canceled)) {
            tracing::info!(job = %self.lease.job, "not tried again, for it is to be canceled");
        }
        if !matches!(state, Ok(JobState::Failed)) {
            discard(&self.context.blobs, &artifacts).await;
        }
        state.map(|_| lost.then_some(Next::Renew))
    }

    /// The pipeline stopped, or is given up, because it was told to stop.
    async fn stopped(&mut self) -> Result<(), QueueError> {
        let queue = &self.context.queue;
        match self.stop {
            Some(Stop::LeaseLost) => Err(QueueError::LeaseLost),
            Some(Stop::Canceled) => {
                let (events, handover) = self.rest();
                tracing::info!(job = %self.lease.job, "job canceled");
                queue.canceled(&self.lease, Handover { events, ..handover }).await
            }
            Some(Stop::Drained) => {
                let (events, _) = self.rest();
                tracing::info!(job = %self.lease.job, "job handed back");
                queue.release(&self.lease, events).await
            }
            Some(Stop::TimedOut) => {
                let seconds = self.context.limits.job_seconds;
                let message = format!(
                    "the job ran for {seconds} s, which is the limit; give it fewer triangles, \
                     `steps` or `points`"
                );
                self.fail(JobError::new(ErrorCode::TimedOut, message)).await.map(|_| ())
            }
            None => {
                let message = "the pipeline stopped though nobody asked it to";
                self.fail(JobError::new(ErrorCode::Internal, message)).await.map(|_| ())
            }
        }
    }

    async fn keep_if_ok(
        &self,
        committed: Result<(), QueueError>,
        artifacts: &[StoredArtifact],
    ) -> Result<(), QueueError> {
        // Of any other error it is not known whether the row stands: the orphan sweep knows.
        if matches!(committed, Err(QueueError::LeaseLost)) {
            discard(&self.context.blobs, artifacts).await;
        }
        committed
    }
}

/// The log so far, as a file.
fn log() -> (ArtifactKind, Bytes) {
    (ArtifactKind::Log, JobLog::so_far().into())
}

/// The moment, or never.
async fn at(moment: Option<Instant>) {
    match moment {
        Some(moment) => sleep_until(moment).await,
        None => pending().await,
    }
}
