//! What one job may use: wall-clock time and memory. Every stage asks the same [`Budget`]. Where there is
//! none to spare a stage takes its cheaper form, and what it gave up is recorded here; the clock is read
//! only where the job was given a time.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use super::Stage;

/// What a stage gave up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum GaveUp {
    /// The segmentation network: parts come from the file's own structure.
    Network,
    /// Joining charts further and moving their seams.
    Joining,
    /// Training the seams.
    JointSeams,
    /// Training, in part or as a whole: charts carry the best map so far.
    Training,
    /// Descent: charts carry the map by which they were cut.
    Descent,
    /// The search for a denser arrangement on the page.
    Search,
    /// The pictures.
    Pictures,
}

impl GaveUp {
    /// What is left out, in words.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Network => "the segmentation network",
            Self::Joining => "joining charts further and moving their seams",
            Self::JointSeams => "training the seams",
            Self::Training => "further training",
            Self::Descent => "descent to the nearest optimum",
            Self::Search => "the search for a denser arrangement",
            Self::Pictures => "the pictures",
        }
    }
}

/// What there was too little of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Scarce {
    /// Seconds: the result depends on the machine's speed.
    Time,
    /// Memory, which is counted from input and options: the same everywhere.
    Memory,
}

/// A stage that took a cheaper form.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Degradation {
    /// Which stage.
    pub stage: Stage,
    /// What it gave up.
    pub gave_up: GaveUp,
    /// What there was too little of.
    pub scarce: Scarce,
}

impl std::fmt::Display for Degradation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (option, scarce) = match self.scarce {
            Scarce::Time => ("`budget_s`", "time"),
            Scarce::Memory => ("`budget_mib`", "memory"),
        };
        let (stage, gave_up) = (self.stage.as_str(), self.gave_up.as_str());
        write!(f, "{stage}: too little {scarce} ({option}) was left for {gave_up}")
    }
}

/// A job's allowance, started when it is made.
#[derive(Debug)]
pub struct Budget {
    started: Instant,
    wall: Option<Duration>,
    memory: u64,
    /// Bytes that the job holds to its end.
    held: AtomicU64,
    degraded: Mutex<Vec<Degradation>>,
}

impl Budget {
    /// A budget of `wall_s` seconds (none: as many as it takes) and `memory_mib` MiB that starts now.
    pub fn new(wall_s: Option<f64>, memory_mib: u64) -> Self {
        Self {
            started: Instant::now(),
            wall: wall_s.map(|s| Duration::from_secs_f64(s.clamp(0.0, 1e9))),
            memory: memory_mib.saturating_mul(1 << 20),
            held: AtomicU64::new(0),
            degraded: Mutex::new(Vec::new()),
        }
    }

    /// The same, started at another moment.
    pub fn since(self, started: Instant) -> Self {
        Self { started, ..self }
    }

    /// Seconds since the start, and of how many; `None` where the job has as many as it takes.
    pub fn spent_s(&self) -> Option<(f64, f64)> {
        self.wall.map(|wall| (self.started.elapsed().as_secs_f64(), wall.as_secs_f64()))
    }

    /// When the job must be over, if ever.
    pub fn end(&self) -> Option<Instant> {
        self.wall.map(|wall| self.started + wall)
    }

    /// Whether `stage` should have ended by now. A stage that sees `true` takes its cheaper form and says
    /// so with [`Budget::give_up`].
    pub fn is_late(&self, stage: Stage) -> bool {
        self.spent_s().is_some_and(|(spent, wall)| spent >= wall * stage.deadline())
    }

    /// Count bytes that the job holds to its end; how many MiB it would need where it has not so many.
    pub fn hold(&self, bytes: u64) -> Result<(), u64> {
        let held = self.held.fetch_add(bytes, Ordering::Relaxed).saturating_add(bytes);
        if held > self.memory { Err(held.div_ceil(1 << 20)) } else { Ok(()) }
    }

    /// Bytes that a stage may hold besides, while it runs.
    pub fn spare_bytes(&self) -> u64 {
        self.memory.saturating_sub(self.held.load(Ordering::Relaxed))
    }

    /// MiB that the job may hold.
    pub fn memory_mib(&self) -> u64 {
        self.memory >> 20
    }

    /// Record that `stage` took a cheaper form. Says whether that is news.
    pub fn give_up(&self, degradation: Degradation) -> bool {
        let mut list = self.degraded.lock().unwrap_or_else(|e| e.into_inner());
        let news = !list.contains(&degradation);
        if news {
            list.push(degradation);
        }
        news
    }

    /// What was given up, by stage.
    pub fn degraded(&self) -> Vec<Degradation> {
        let mut list = self.degraded.lock().unwrap_or_else(|e| e.into_inner()).clone();
        list.sort_by_key(|d| d.stage);
        list
    }
}

impl Default for Budget {
    /// What a job has that is told nothing.
    fn default() -> Self {
        let options = super::UnwrapOptions::default();
        Self::new(options.budget_s, options.budget_mib)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_time_nothing_is_ever_late() {
        let budget = Budget::new(None, 64);
        assert!(Stage::ALL.iter().all(|&stage| !budget.is_late(stage)));
        assert_eq!((budget.spent_s(), budget.end()), (None, None));
    }

    #[test]
    fn stages_are_late_in_their_order() {
        let started = Instant::now() - Duration::from_secs(55);
        let budget = Budget::new(Some(100.0), 64).since(started);
        assert!(budget.is_late(Stage::Charts) && !budget.is_late(Stage::Pack));
        let deadlines: Vec<f64> = Stage::ALL.iter().map(|s| s.deadline()).collect();
        assert!(deadlines.is_sorted() && deadlines[0] > 0.0 && deadlines[10] <= 1.0);
    }

    #[test]
    fn memory_is_held_to_the_end_and_the_rest_is_to_spare() {
        let budget = Budget::new(None, 64);
        assert_eq!(budget.hold(60 << 20), Ok(()));
        assert_eq!(budget.spare_bytes(), 4 << 20);
        assert_eq!(budget.hold(5 << 20), Err(65));
        assert_eq!(budget.spare_bytes(), 0);
        // Whatever number an option can be.
        assert_eq!(Budget::new(Some(f64::MAX), u64::MAX).hold(u64::MAX), Ok(()));
    }

    #[test]
    fn what_is_given_up_is_told_once_and_in_words() {
        let budget = Budget::default();
        let one = Degradation { stage: Stage::Pack, gave_up: GaveUp::Search, scarce: Scarce::Time };
        assert!(budget.give_up(one) && !budget.give_up(one));
        assert_eq!(budget.degraded(), [one]);
        let text =
            "pack: too little time (`budget_s`) was left for the search for a denser arrangement";
        assert_eq!(one.to_string(), text);
    }
}
