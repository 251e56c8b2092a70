//! What every long call is given: whom to tell, when to stop, how much may be used, and what each stage
//! has cost.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};

use super::clock::Clock;
use super::{
    Budget, Cancel, Canceled, Cost, Degradation, GaveUp, Progress, Scarce, Stage, Warning,
    WarningCode,
};

/// Least news of a fraction that is told.
const NEWS: f64 = 0.002;

/// How far the job is.
#[derive(Debug)]
struct Way {
    /// Expected work of each stage, in the order of [`Stage::ALL`].
    work: [f64; Stage::ALL.len()],
    stage: Stage,
    /// Share of all work that is done.
    fraction: f64,
    /// The fraction that was told last.
    told: f64,
    parts: [u32; 2],
}

impl Way {
    /// The share of all work that is done when `share` of the present stage is.
    fn fraction_at(&self, share: f64) -> f64 {
        let stage = self.stage as usize;
        let before: f64 = self.work[..stage].iter().sum();
        let all: f64 = self.work.iter().sum();
        ((before + share.clamp(0.0, 1.0) * self.work[stage]) / all).clamp(0.0, 1.0)
    }
}

/// What every long call is given: where to tell progress, when to stop, how much it may use.
#[derive(Clone)]
pub struct Run {
    tell: Arc<dyn Fn(Progress) + Send + Sync>,
    /// Asked to stop, or out of time?
    pub cancel: Cancel,
    /// How much may be used.
    pub budget: Arc<Budget>,
    way: Arc<Mutex<Way>>,
    clock: Arc<Mutex<Clock>>,
    warnings: Arc<Mutex<Vec<Warning>>>,
}

impl Run {
    /// A run that reports to `tell`.
    pub fn new(
        tell: impl Fn(Progress) + Send + Sync + 'static,
        cancel: Cancel,
        budget: Budget,
    ) -> Self {
        let way = Way {
            work: [1.0; Stage::ALL.len()],
            stage: Stage::Import,
            fraction: 0.0,
            told: 0.0,
            parts: [0, 0],
        };
        Self {
            tell: Arc::new(tell),
            cancel: cancel.until(budget.end()),
            budget: Arc::new(budget),
            way: Arc::new(Mutex::new(way)),
            clock: Arc::new(Mutex::new(Clock::new())),
            warnings: Arc::default(),
        }
    }

    /// A run that nobody watches, with the default budget.
    pub fn quiet() -> Self {
        Self::new(|_| {}, Cancel::default(), Budget::default())
    }

    /// Tell one thing; a warning that was told already is not told again.
    pub fn tell(&self, progress: Progress) {
        if let Progress::Warning(warning) = &progress {
            let mut held = self.held_warnings();
            if held.contains(warning) {
                return;
            }
            held.push(warning.clone());
        }
        (self.tell)(progress);
    }

    /// Tell a warning.
    pub fn warn(&self, code: WarningCode, message: impl Into<String>) {
        self.tell(Progress::Warning(Warning::new(code, message)));
    }

    /// The warnings so far, in the order in which they were told.
    pub fn warnings(&self) -> Vec<Warning> {
        self.held_warnings().clone()
    }

    /// Say how much work is expected of each stage, in any unit; stages that are not named are not run.
    pub fn expect(&self, work: &[(Stage, f64)]) {
        let mut way = self.way();
        way.work = [0.0; Stage::ALL.len()];
        for &(stage, expected) in work {
            way.work[stage as usize] = expected;
        }
    }

    /// Begin a stage: tells it and stops here if the work is to stop.
    pub fn stage(&self, stage: Stage) -> Result<(), Canceled> {
        self.cancel.check()?;
        self.clock().stage(stage);
        self.way().stage = stage;
        self.tell(Progress::Stage { stage });
        self.advance(0.0);
        Ok(())
    }

    /// `share` of the present stage is done, 0 to 1. Less than was said before changes nothing.
    pub fn advance(&self, share: f64) {
        let mut way = self.way();
        way.fraction = way.fraction_at(share).max(way.fraction);
        let ended = way.fraction == 1.0 && way.told < 1.0;
        if way.fraction >= way.told + NEWS || ended {
            self.tell_way(&mut way);
        }
    }

    /// Count work that the present stage did, from any thread, in its unit ([`Stage::unit`]).
    pub fn count(&self, work: usize) {
        self.clock().count(work as u64);
    }

    /// Count steps of the present stage, from any thread: `total` of them take it from `from` to `to`.
    pub fn steps(&self, total: usize, from: f64, to: f64) -> Steps<'_> {
        Steps { run: self, done: AtomicUsize::new(0), total: total.max(1), from, to }
    }

    /// Say of how many parts every chart has its map.
    pub fn parts(&self, done: u32, total: u32) {
        let mut way = self.way();
        way.parts = [done, total];
        self.tell_way(&mut way);
    }

    /// The stage that runs.
    pub fn present_stage(&self) -> Stage {
        self.way().stage
    }

    /// What the run has cost so far.
    pub fn cost(&self, steps: u32, device: &str, threads: usize) -> Cost {
        self.clock().cost(steps, device, threads)
    }

    /// Whether `stage` should have ended by now. Whoever takes a cheaper form then says so with
    /// [`Run::give_up`].
    pub fn is_late(&self, stage: Stage) -> bool {
        self.budget.is_late(stage)
    }

    /// `stage` takes a cheaper form: it is recorded, and told as a warning.
    pub fn give_up(&self, stage: Stage, gave_up: GaveUp, scarce: Scarce) {
        let degradation = Degradation { stage, gave_up, scarce };
        if self.budget.give_up(degradation) {
            self.warn(WarningCode::Degraded, degradation.to_string());
        }
    }

    /// Whether `stage` is late; if so it is recorded that it gives this up.
    pub fn skips(&self, stage: Stage, gave_up: GaveUp) -> bool {
        let late = self.is_late(stage);
        if late {
            self.give_up(stage, gave_up, Scarce::Time);
        }
        late
    }

    /// Where the work stopped for want of time: the stage, the share of all work that was done, and the
    /// seconds that were spent. `None` where it is not out of time.
    pub fn out_of_time(&self) -> Option<(Stage, f64, f64)> {
        let (spent, wall) = self.budget.spent_s()?;
        let way = self.way();
        (spent >= wall && !self.cancel.is_asked()).then_some((way.stage, way.fraction, spent))
    }

    fn tell_way(&self, way: &mut Way) {
        way.told = way.fraction;
        let (stage, fraction, [parts_done, parts_total]) = (way.stage, way.fraction, way.parts);
        self.tell(Progress::Progress { stage, fraction, parts_done, parts_total });
    }

    fn held_warnings(&self) -> MutexGuard<'_, Vec<Warning>> {
        self.warnings.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    fn clock(&self) -> MutexGuard<'_, Clock> {
        self.clock.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// A panic elsewhere leaves nothing half-written here.
    fn way(&self) -> MutexGuard<'_, Way> {
        self.way.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

/// Counts the steps of a stage.
pub struct Steps<'a> {
    run: &'a Run,
    done: AtomicUsize,
    total: usize,
    from: f64,
    to: f64,
}

impl Steps<'_> {
    /// One more is done.
    pub fn step(&self) {
        self.add(1);
    }

    /// So many more are done.
    pub fn add(&self, steps: usize) {
        let done = self.done.fetch_add(steps, Ordering::Relaxed).saturating_add(steps);
        let share = (done as f64 / self.total as f64).min(1.0);
        self.run.advance(self.from + (self.to - self.from) * share);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run and what it tells.
    fn watched() -> (Run, Arc<Mutex<Vec<Progress>>>) {
        let told = Arc::new(Mutex::new(Vec::new()));
        let listener = told.clone();
        let tell = move |progress| listener.lock().unwrap().push(progress);
        (Run::new(tell, Cancel::default(), Budget::default()), told)
    }

    #[test]
    fn the_fraction_counts_work_and_never_falls() {
        let (run, told) = watched();
        run.expect(&[(Stage::Charts, 3.0), (Stage::Pack, 1.0)]);
        run.stage(Stage::Charts).unwrap();
        let steps = run.steps(4, 0.0, 1.0);
        (0..4).for_each(|_| steps.step());
        run.stage(Stage::Pack).unwrap();
        run.advance(0.5);
        // The pipeline goes back.
        run.stage(Stage::Charts).unwrap();
        run.advance(0.1);
        run.stage(Stage::Pack).unwrap();
        run.advance(1.0);
        let told = told.lock().unwrap();
        let fractions = told.iter().filter_map(|p| match p {
            Progress::Progress { fraction, .. } => Some(*fraction),
            _ => None,
        });
        let fractions: Vec<f64> = fractions.collect();
        assert_eq!(fractions, [0.1875, 0.375, 0.5625, 0.75, 0.875, 1.0]);
    }

    #[test]
    fn the_end_is_told_once_and_parts_as_they_are_done() {
        let (run, told) = watched();
        run.expect(&[(Stage::Charts, 1.0)]);
        run.stage(Stage::Charts).unwrap();
        // Too little news before the end, and none behind it.
        for share in [0.999, 0.9995, 1.0, 1.0] {
            run.advance(share);
        }
        run.parts(3, 8);
        let told = told.lock().unwrap();
        let fractions = told.iter().filter_map(|p| match p {
            Progress::Progress { fraction, parts_done, parts_total, .. } => {
                Some((*fraction, *parts_done, *parts_total))
            }
            _ => None,
        });
        let fractions: Vec<_> = fractions.collect();
        assert_eq!(fractions, [(0.999, 0, 0), (1.0, 0, 0), (1.0, 3, 8)]);
    }

    #[test]
    fn what_is_given_up_is_a_warning_once() {
        let (run, told) = watched();
        for _ in 0..2 {
            run.give_up(Stage::Preview, GaveUp::Pictures, Scarce::Memory);
        }
        let told = told.lock().unwrap();
        assert!(matches!(&told[..], [Progress::Warning(w)] if w.code == WarningCode::Degraded));
        assert_eq!(run.budget.degraded().len(), 1);
        assert_eq!(run.warnings().len(), 1);
    }

    #[test]
    fn work_stops_when_its_time_is_over() {
        let run = Run::new(|_| {}, Cancel::default(), Budget::new(Some(0.0), 64));
        assert_eq!(run.cancel.check(), Err(Canceled));
        assert!(run.out_of_time().is_some());
        assert!(Run::quiet().out_of_time().is_none());
        run.cancel.cancel();
        assert!(run.out_of_time().is_none(), "it was asked to stop");
    }
}
