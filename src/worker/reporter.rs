//! From what the pipeline tells to rows of events: stages, parts and warnings all, progress only as
//! often as it may be written.

use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};

use crate::contract::{Progress, Stage, Warning};
use crate::jobs::{EventData, JobProgress, NewEvent, PartCompletedEvent, StageEvent, WarningEvent};

/// Least time between two `progress` rows of a job.
const PROGRESS_EVERY: Duration = Duration::from_millis(500);

/// Share of the job's work below which its pace says nothing.
const PACE_FROM: f64 = 0.05;

/// Takes what the pipeline tells, from any thread; gives what is to be written.
#[derive(Debug)]
pub struct Reporter {
    attempt: u32,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    events: Vec<NewEvent>,
    now: Option<JobProgress>,
    /// Whether `now` differs from what was given last.
    changed: bool,
    /// Whether `now` is news of a stage that goes on.
    moved: bool,
    began: Instant,
    progress_given: Option<Instant>,
}

impl Reporter {
    /// A reporter of this attempt.
    pub fn new(attempt: u32) -> Self {
        let state = State {
            events: Vec::new(),
            now: None,
            changed: false,
            moved: false,
            began: Instant::now(),
            progress_given: None,
        };
        Self { attempt, state: Mutex::new(state) }
    }

    /// Take one thing.
    pub fn tell(&self, progress: Progress) {
        let mut state = self.state();
        match progress {
            Progress::Stage { stage } => {
                tracing::info!(stage = stage.as_str(), "stage");
                state.write(EventData::Stage(StageEvent { attempt: self.attempt, stage }));
                // What was done stays done.
                let so_far = state.so_far(stage);
                state.set(so_far);
                // Progress of the stage before that was not yet given is thinned away.
                state.moved = false;
            }
            Progress::Progress { stage, fraction, parts_done, parts_total } => {
                tracing::debug!(
                    stage = stage.as_str(),
                    fraction,
                    parts_done,
                    parts_total,
                    "progress"
                );
                // The fraction never falls; `max` passes over what is no number.
                let fraction = state.so_far(stage).fraction.max(fraction.clamp(0.0, 1.0));
                let spent = state.began.elapsed().as_secs_f64();
                let eta_s = (fraction >= PACE_FROM).then(|| spent * (1.0 - fraction) / fraction);
                state.set(JobProgress { stage, fraction, parts_done, parts_total, eta_s });
                state.moved = true;
            }
            Progress::PartCompleted { part, name, charts, symmetric_dirichlet } => {
                tracing::info!(part, name, charts, symmetric_dirichlet, "part completed");
                let symmetric_dirichlet = Some(symmetric_dirichlet).filter(|e| e.is_finite());
                let completed = PartCompletedEvent { part, name, charts, symmetric_dirichlet };
                state.write(EventData::PartCompleted(completed));
            }
            Progress::Warning(warning) => {
                tracing::warn!(code = warning.code.as_str(), "{}", warning.message);
                let Warning { code, message } = warning;
                state.write(EventData::Warning(WarningEvent { code, message }));
            }
        }
    }

    /// What is to be written: events, and the progress if it changed since it was last asked for.
    pub fn take(&self) -> (Vec<NewEvent>, Option<JobProgress>) {
        let mut state = self.state();
        let due = state.progress_given.is_none_or(|last| last.elapsed() >= PROGRESS_EVERY);
        if state.moved
            && due
            && let Some(now) = state.now.clone()
        {
            state.write(EventData::Progress(now));
            state.progress_given = Some(Instant::now());
            state.moved = false;
        }
        let changed = std::mem::take(&mut state.changed);
        (std::mem::take(&mut state.events), state.now.clone().filter(|_| changed))
    }

    /// A panic in the pipeline leaves nothing half-written here.
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

impl State {
    fn write(&mut self, data: EventData) {
        self.events.push(NewEvent::now(data));
    }

    /// How far the job came, in this stage.
    fn so_far(&self, stage: Stage) -> JobProgress {
        let none = JobProgress { stage, fraction: 0.0, parts_done: 0, parts_total: 0, eta_s: None };
        self.now.clone().map_or(none, |now| JobProgress { stage, ..now })
    }

    fn set(&mut self, now: JobProgress) {
        self.now = Some(now);
        self.changed = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn progress(fraction: f64) -> Progress {
        Progress::Progress { stage: Stage::Train, fraction, parts_done: 1, parts_total: 4 }
    }

    #[test]
    fn progress_is_thinned_and_stages_are_not() {
        let reporter = Reporter::new(2);
        for step in 0..100 {
            reporter.tell(Progress::Stage { stage: Stage::Train });
            reporter.tell(progress(f64::from(step) / 100.0));
            reporter.take();
        }
        reporter.tell(Progress::Stage { stage: Stage::Pack });
        let (events, now) = reporter.take();
        let told: Vec<_> = events.into_iter().map(|event| event.data).collect();
        assert_eq!(told, [EventData::Stage(StageEvent { attempt: 2, stage: Stage::Pack })]);
        let now = now.unwrap();
        assert_eq!((now.stage, now.parts_done, now.parts_total), (Stage::Pack, 1, 4));
        assert_eq!(reporter.take(), (vec![], None));
    }

    #[test]
    fn at_most_two_progress_rows_a_second() {
        let reporter = Reporter::new(1);
        let began = Instant::now();
        let mut rows = 0;
        while began.elapsed() < Duration::from_millis(1200) {
            reporter.tell(progress(0.5));
            rows += reporter.take().0.len();
            std::thread::sleep(Duration::from_millis(5));
        }
        assert_eq!(rows, 3);
    }

    #[test]
    fn the_time_left_follows_the_pace() {
        let reporter = Reporter::new(1);
        reporter.tell(Progress::Stage { stage: Stage::Train });
        reporter.tell(progress(0.01));
        assert_eq!(reporter.take().1.unwrap().eta_s, None);
        std::thread::sleep(Duration::from_millis(50));
        reporter.tell(progress(0.2));
        let eta = reporter.take().1.unwrap().eta_s.unwrap();
        assert!((0.2..0.8).contains(&eta), "{eta}");
        // Neither a new stage nor a wrong number takes anything back.
        reporter.tell(Progress::Stage { stage: Stage::Pack });
        let now = reporter.take().1.unwrap();
        assert_eq!((now.stage, now.fraction), (Stage::Pack, 0.2));
        for wrong in [f64::NAN, 0.1, -1.0] {
            reporter.tell(progress(wrong));
            assert_eq!(reporter.take().1.unwrap().fraction, 0.2);
        }
        reporter.tell(progress(2.0));
        assert_eq!(reporter.take().1.unwrap().fraction, 1.0);
    }
}
