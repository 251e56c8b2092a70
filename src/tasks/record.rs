//! What a run on one thread tells of many: the tree of its strands and forks, with the seconds of each strand
//! (the work and span of Blumofe & Leiserson 1999, doi:10.1145/324133.324234, as Cilkview measures them: He,
//! Leiserson & Leiserson 2010, doi:10.1145/1810479.1810509). Nothing is recorded, and next to nothing spent,
//! unless it is asked for.

use std::cell::RefCell;
use std::time::Instant;

/// What was done one after the other.
pub type Series = Vec<Node>;

/// A piece of work.
#[derive(Debug, Clone, PartialEq)]
pub enum Node {
    /// Done by one thread.
    Strand {
        /// What it is part of.
        name: &'static str,
        /// How long it took, s.
        seconds: f64,
    },
    /// Tasks that threads may take at the same time.
    Fork {
        /// The tasks.
        tasks: Vec<Series>,
    },
    /// Many equal tasks, so small that they were not looked at one by one.
    Even {
        /// What they are.
        name: &'static str,
        /// How many.
        tasks: usize,
        /// How long all took, s.
        seconds: f64,
    },
    /// Here a stage of the run begins.
    Mark(&'static str),
}

/// A recorded run.
#[derive(Debug, Clone, PartialEq)]
pub struct Recorded {
    /// What was done.
    pub series: Series,
}

struct Recorder {
    /// Series that have not ended: the last is the present one.
    open: Vec<Series>,
    /// Tasks of the forks that have not ended.
    forks: Vec<Vec<Series>>,
    names: Vec<&'static str>,
    /// When the present strand began.
    since: Instant,
}

thread_local! {
    static RECORDER: RefCell<Option<Recorder>> = const { RefCell::new(None) };
}

/// The strand that no name was given.
const UNNAMED: &str = "between";

/// Do `work` and record what it was made of. It must run on one thread: in a pool of one.
pub fn record<R>(work: impl FnOnce() -> R) -> (R, Recorded) {
    let recorder = Recorder {
        open: vec![Vec::new()],
        forks: Vec::new(),
        names: vec![UNNAMED],
        since: Instant::now(),
    };
    let outer = RECORDER.replace(Some(recorder));
    let made = work();
    let ended = RECORDER.replace(outer);
    let series = ended.and_then(|mut ended| {
        ended.end_strand();
        ended.open.pop()
    });
    (made, Recorded { series: series.unwrap_or_default() })
}

/// Whether this thread records.
pub(super) fn is_on() -> bool {
    RECORDER.with_borrow(Option::is_some)
}

/// A stage begins.
pub fn mark(stage: &'static str) {
    with(|recorder| {
        // What is begun within a task belongs to the stage of its fork.
        if recorder.forks.is_empty() {
            recorder.end_strand();
            recorder.push(Node::Mark(stage));
        }
    });
}

/// Work of one thread, by its name.
pub fn link<R>(name: &'static str, work: impl FnOnce() -> R) -> R {
    with(|recorder| {
        recorder.end_strand();
        recorder.names.push(name);
    });
    let made = work();
    with(|recorder| {
        recorder.end_strand();
        recorder.names.pop();
    });
    made
}

/// A fork opens. Its tasks follow, each between [`begin_task`] and [`end_task`].
pub(super) fn open_fork(name: &'static str) {
    with(|recorder| {
        recorder.end_strand();
        recorder.forks.push(Vec::new());
        recorder.names.push(name);
    });
}

/// A task of the fork that was opened last begins.
pub(super) fn begin_task() {
    with(|recorder| {
        // What lies between tasks is rayon's.
        recorder.since = Instant::now();
        recorder.open.push(Vec::new());
    });
}

/// The task ends.
pub(super) fn end_task() {
    with(|recorder| {
        recorder.end_strand();
        let task = recorder.open.pop().unwrap_or_default();
        if let Some(fork) = recorder.forks.last_mut() {
            fork.push(task);
        }
    });
}

/// The fork that was opened last is over.
pub(super) fn close_fork() {
    with(|recorder| {
        let tasks = recorder.forks.pop().unwrap_or_default();
        recorder.names.pop();
        recorder.push(Node::Fork { tasks });
        recorder.since = Instant::now();
    });
}

/// The strand that ends here was that many equal tasks.
pub(super) fn close_even(name: &'static str, tasks: usize) {
    with(|recorder| {
        let seconds = recorder.since.elapsed().as_secs_f64();
        recorder.push(Node::Even { name, tasks, seconds });
        recorder.since = Instant::now();
    });
}

/// The strand so far ends; what follows is another.
pub(super) fn cut() {
    with(Recorder::end_strand);
}

fn with<R>(f: impl FnOnce(&mut Recorder) -> R) -> Option<R> {
    RECORDER.with_borrow_mut(|recorder| recorder.as_mut().map(f))
}

impl Recorder {
    fn push(&mut self, node: Node) {
        if let Some(series) = self.open.last_mut() {
            series.push(node);
        }
    }

    fn end_strand(&mut self) {
        let now = Instant::now();
        let seconds = (now - self.since).as_secs_f64();
        let name = self.names.last().copied().unwrap_or(UNNAMED);
        self.push(Node::Strand { name, seconds });
        self.since = now;
    }
}
