//! From what was recorded to what many threads would take: work, span, and greedy schedules.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use super::record::{Node, Recorded, Series};

/// Pieces into which even tasks are put together for each thread.
const PIECES: usize = 8;

/// A recorded run, or a stage of it, as it would be scheduled.
#[derive(Debug, Clone, Copy)]
pub struct Schedule<'a>(&'a [Node]);

/// A part of the longest chain of tasks.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Its name.
    pub name: &'static str,
    /// Seconds of it on the chain …
    pub chain: f64,
    /// … and in all.
    pub work: f64,
}

impl Recorded {
    /// All of it.
    pub fn schedule(&self) -> Schedule<'_> {
        Schedule(&self.series)
    }

    /// Its stages, in the order in which they were first begun; what was done before the first is left out. A
    /// stage that is begun again has several pieces.
    pub fn stages(&self) -> Vec<(&'static str, Vec<Schedule<'_>>)> {
        let mut stages: Vec<(&'static str, Vec<Schedule>)> = Vec::new();
        let mut at = 0usize;
        for piece in self.series.split_inclusive(|node| matches!(node, Node::Mark(_))) {
            // The mark that begins a piece ends the one before.
            if let Some(&Node::Mark(name)) = at.checked_sub(1).map(|i| &self.series[i]) {
                match stages.iter_mut().find(|stage| stage.0 == name) {
                    Some(stage) => stage.1.push(Schedule(piece)),
                    None => stages.push((name, vec![Schedule(piece)])),
                }
            }
            at += piece.len();
        }
        stages
    }
}

impl Schedule<'_> {
    /// Seconds of all that was done: what one thread takes.
    pub fn work(&self) -> f64 {
        work(self.0)
    }

    /// Seconds of the longest chain: what no number of threads goes below.
    pub fn span(&self) -> f64 {
        span(self.0)
    }

    /// Seconds that so many threads take, of which none is idle where there is a task.
    pub fn on(&self, threads: usize) -> f64 {
        Simulation::new(self.0, threads.max(1)).run()
    }

    /// What the longest chain is made of, the longest first.
    pub fn links(&self) -> Vec<Link> {
        let (mut on_chain, mut in_all) = (BTreeMap::new(), BTreeMap::new());
        chain(self.0, &mut on_chain);
        total(self.0, &mut in_all);
        let link = |(name, chain)| Link { name, chain, work: in_all[name] };
        let mut links: Vec<Link> = on_chain.into_iter().map(link).collect();
        links.sort_by(|a, b| b.chain.total_cmp(&a.chain));
        links
    }
}

fn work(series: &[Node]) -> f64 {
    let of = |node: &Node| match node {
        Node::Strand { seconds, .. } | Node::Even { seconds, .. } => *seconds,
        Node::Fork { tasks } => tasks.iter().map(|task| work(task)).sum(),
        Node::Mark(_) => 0.0,
    };
    series.iter().map(of).sum()
}

fn span(series: &[Node]) -> f64 {
    let of = |node: &Node| match node {
        Node::Strand { seconds, .. } => *seconds,
        Node::Even { seconds, tasks, .. } => seconds / (*tasks).max(1) as f64,
        Node::Fork { tasks } => tasks.iter().map(|task| span(task)).fold(0.0, f64::max),
        Node::Mark(_) => 0.0,
    };
    series.iter().map(of).sum()
}

/// Seconds by name along the longest chain.
fn chain(series: &[Node], of: &mut BTreeMap<&'static str, f64>) {
    for node in series {
        match node {
            Node::Strand { name, seconds } => *of.entry(*name).or_default() += seconds,
            Node::Even { name, seconds, tasks } => {
                *of.entry(*name).or_default() += seconds / (*tasks).max(1) as f64;
            }
            Node::Fork { tasks } => {
                let longest = tasks.iter().max_by(|a, b| span(a).total_cmp(&span(b)));
                longest.iter().for_each(|task| chain(task, of));
            }
            Node::Mark(_) => {}
        }
    }
}

/// Seconds by name in all.
fn total(series: &[Node], of: &mut BTreeMap<&'static str, f64>) {
    for node in series {
        match node {
            Node::Strand { name, seconds } | Node::Even { name, seconds, .. } => {
                *of.entry(*name).or_default() += seconds;
            }
            Node::Fork { tasks } => tasks.iter().for_each(|task| total(task, of)),
            Node::Mark(_) => {}
        }
    }
}

/// Threads that take what is ready: the tasks of the fork that was opened last come first.
struct Simulation<'a> {
    threads: usize,
    frames: Vec<Frame<'a>>,
    /// Tasks that no thread has yet: number of the fork, place in it, frame.
    ready: BinaryHeap<(usize, Reverse<usize>, usize)>,
    forks: usize,
}

/// A series while it is done.
struct Frame<'a> {
    series: Work<'a>,
    next: usize,
    /// The frame whose fork this is a task of.
    parent: Option<usize>,
    /// Tasks that its own fork waits for.
    waits_for: usize,
}

#[derive(Clone, Copy)]
enum Work<'a> {
    Series(&'a [Node]),
    /// One piece of even tasks, s.
    Piece(f64),
}

impl<'a> Simulation<'a> {
    fn new(series: &'a [Node], threads: usize) -> Self {
        let root = Frame { series: Work::Series(series), next: 0, parent: None, waits_for: 0 };
        let ready = BinaryHeap::from([(0, Reverse(0), 0)]);
        Self { threads, frames: vec![root], ready, forks: 0 }
    }

    /// Seconds until all is done.
    fn run(mut self) -> f64 {
        // Strands that end, soonest first: nanoseconds, so that they have an order; and their frames.
        let mut busy: BinaryHeap<Reverse<(u64, usize)>> = BinaryHeap::new();
        let mut now = 0;
        loop {
            while busy.len() < self.threads
                && let Some((.., frame)) = self.ready.pop()
            {
                busy.extend(self.strand(frame).map(|(ns, frame)| Reverse((now + ns, frame))));
            }
            let Some(Reverse((at, frame))) = busy.pop() else { return now as f64 * 1e-9 };
            now = at;
            // Whoever ends a strand goes on with what follows it.
            busy.extend(self.strand(frame).map(|(ns, frame)| Reverse((now + ns, frame))));
        }
    }

    /// The next strand of a frame or, where that is over, of what waited for it: its length and its frame. `None`
    /// where there is none that this thread has to go on with.
    fn strand(&mut self, mut at: usize) -> Option<(u64, usize)> {
        loop {
            let frame = &mut self.frames[at];
            let next = frame.next;
            frame.next += 1;
            let node = match frame.series {
                Work::Piece(seconds) if next == 0 => return Some((ns(seconds), at)),
                Work::Piece(_) => None,
                Work::Series(series) => series.get(next),
            };
            match node {
                Some(Node::Strand { seconds, .. }) => return Some((ns(*seconds), at)),
                Some(Node::Mark(_)) => {}
                Some(Node::Fork { tasks }) if tasks.is_empty() => {}
                Some(Node::Fork { tasks }) => {
                    let tasks = tasks.iter().map(|task: &Series| Work::Series(task));
                    return self.fork(at, tasks.collect());
                }
                Some(&Node::Even { seconds, tasks, .. }) => {
                    let pieces = tasks.min(PIECES * self.threads).max(1);
                    return self.fork(at, vec![Work::Piece(seconds / pieces as f64); pieces]);
                }
                None => {
                    at = frame.parent?;
                    self.frames[at].waits_for -= 1;
                    if self.frames[at].waits_for > 0 {
                        return None;
                    }
                }
            }
        }
    }

    fn fork(&mut self, parent: usize, tasks: Vec<Work<'a>>) -> Option<(u64, usize)> {
        self.frames[parent].waits_for = tasks.len();
        self.forks += 1;
        let first = self.frames.len();
        for (place, series) in tasks.into_iter().enumerate() {
            self.ready.push((self.forks, Reverse(place), first + place));
            self.frames.push(Frame { series, next: 0, parent: Some(parent), waits_for: 0 });
        }
        self.ready.pop().and_then(|(.., frame)| self.strand(frame))
    }
}

fn ns(seconds: f64) -> u64 {
    (seconds * 1e9).round().max(0.0) as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tasks::{Fork, even, join, link, map, map_by_size, mark, record, threads};

    fn strand(name: &'static str, seconds: f64) -> Node {
        Node::Strand { name, seconds }
    }

    /// A second, then tasks of 4, 1, 1 and 1 s of which the last forks in two of 1 s, then a second.
    fn sample() -> Recorded {
        let inner = Node::Fork { tasks: vec![vec![strand("c", 1.0)], vec![strand("c", 1.0)]] };
        let tasks = vec![
            vec![strand("a", 4.0)],
            vec![strand("b", 1.0)],
            vec![strand("b", 1.0)],
            vec![strand("b", 1.0), inner],
        ];
        Recorded { series: vec![strand("s", 1.0), Node::Fork { tasks }, strand("s", 1.0)] }
    }

    #[test]
    fn a_greedy_schedule_lies_between_work_and_span() {
        let sample = sample();
        let plan = sample.schedule();
        assert_eq!((plan.work(), plan.span()), (11.0, 6.0));
        // On two threads the one has 4, the other 1 + 1 + 1 + 1, and one of them 1 more.
        assert_eq!([1, 2, 3, 9].map(|threads| plan.on(threads)), [11.0, 7.0, 6.0, 6.0]);
        let links = plan.links();
        let told: Vec<_> = links.iter().map(|l| (l.name, l.chain, l.work)).collect();
        assert_eq!(told, [("a", 4.0, 4.0), ("s", 2.0, 2.0)]);
    }

    #[test]
    fn even_tasks_divide_evenly() {
        let even = Node::Even { name: "e", tasks: 1000, seconds: 8.0 };
        let recorded = Recorded { series: vec![even, strand("s", 1.0)] };
        let plan = recorded.schedule();
        assert_eq!([1, 2, 4, 16].map(|threads| plan.on(threads)), [9.0, 5.0, 3.0, 1.5]);
        assert!((plan.span() - 1.008).abs() < 1e-12);
    }

    #[test]
    fn stages_that_are_come_back_to_are_put_together() {
        let series = vec![
            strand("-", 9.0),
            Node::Mark("pack"),
            strand("s", 1.0),
            Node::Mark("polish"),
            strand("s", 2.0),
            Node::Mark("pack"),
            strand("s", 4.0),
        ];
        let recorded = Recorded { series };
        let stages = recorded.stages();
        let of = |pieces: &[Schedule]| pieces.iter().map(Schedule::work).sum::<f64>();
        let told: Vec<_> = stages.iter().map(|(name, pieces)| (*name, of(pieces))).collect();
        assert_eq!(told, [("pack", 5.0), ("polish", 2.0)]);
    }

    /// The tree without its seconds.
    fn shape(series: &[Node]) -> String {
        let of = |node: &Node| match node {
            Node::Strand { name, .. } => (*name).to_owned(),
            Node::Even { name, tasks, .. } => format!("{tasks}x{name}"),
            Node::Mark(name) => format!("[{name}]"),
            Node::Fork { tasks } => {
                let tasks: Vec<String> = tasks.iter().map(|task| shape(task)).collect();
                format!("({})", tasks.join("|"))
            }
        };
        series.iter().map(of).collect::<Vec<_>>().join(" ")
    }

    /// What every kind of fork does.
    fn work() -> (usize, Vec<u32>) {
        mark("stage");
        let (a, b) = join("pair", || link("left", || 1), || even("right", 7, || 2));
        let by_size = map_by_size("sized", vec![1, 3, 2], |&n| n, |n| n as u32);
        let fork = Fork::open("own");
        let sum: u32 = map("items", 0..3u32, |i| fork.task(|| i)).into_iter().sum();
        (threads(), vec![a, b, sum].into_iter().chain(by_size).collect())
    }

    #[test]
    fn a_run_on_one_thread_is_recorded_and_any_other_is_the_same_without() {
        let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (made, recorded) = pool(1).install(|| record(work));
        let made_by = |threads| pool(threads).install(work);
        for (threads, own) in [1, 2, 3].map(|threads| (threads, made_by(threads))) {
            assert_eq!(own, (threads, made.1.clone()));
        }
        assert_eq!(made.0, 1);
        let (plan, shape) = (recorded.schedule(), shape(&recorded.series));
        assert!(shape.starts_with("between [stage] between (pair left pair|pair 7xright pair)"));
        assert!(shape.contains("(sized|sized|sized)"), "{shape}");
        assert!(plan.span() <= plan.on(4) && plan.on(4) <= plan.on(2) + 1e-9, "{shape}");
        assert!((plan.on(1) - plan.work()).abs() < 1e-6);
    }
}
