//! What each stage costs: wall clock, CPU time over all threads, and the most memory the process
//! held, as Linux tells them under /proc (zero and null elsewhere).

use std::time::Instant;

use super::{Cost, Stage, StageCost};

/// Length of the kernel's clock tick as user space sees it (USER_HZ is 100 on every Linux).
const TICK_S: f64 = 0.01;

/// The stage that runs.
#[derive(Debug)]
struct Running {
    stage: Stage,
    begun: Instant,
    begun_cpu: f64,
    work: u64,
}

/// Runs while the pipeline runs.
#[derive(Debug)]
pub struct Clock {
    begun: Instant,
    begun_cpu: f64,
    current: Option<Running>,
    stages: Vec<StageCost>,
}

impl Clock {
    /// Start.
    pub fn new() -> Self {
        Self { begun: Instant::now(), begun_cpu: cpu_seconds(), current: None, stages: Vec::new() }
    }

    /// End the stage that runs and begin another.
    pub fn stage(&mut self, stage: Stage) {
        self.end_stage();
        let (begun, begun_cpu) = (Instant::now(), cpu_seconds());
        self.current = Some(Running { stage, begun, begun_cpu, work: 0 });
    }

    /// Count work of the stage that runs.
    pub fn count(&mut self, work: u64) {
        if let Some(running) = &mut self.current {
            running.work = running.work.saturating_add(work);
        }
    }

    fn end_stage(&mut self) {
        let Some(Running { stage, begun, begun_cpu, work }) = self.current.take() else { return };
        let (wall_s, cpu_s) = (begun.elapsed().as_secs_f64(), cpu_seconds() - begun_cpu);
        // A stage that the pipeline comes back to is one row.
        match self.stages.iter_mut().find(|s| s.name == stage.as_str()) {
            Some(row) => {
                row.wall_s += wall_s;
                row.cpu_s += cpu_s;
                row.work += work;
            }
            None => {
                let (name, unit) = (stage.as_str().into(), stage.unit().into());
                self.stages.push(StageCost { name, wall_s, cpu_s, work, unit });
            }
        }
    }

    /// The cost so far.
    pub fn cost(&mut self, steps: u32, device: &str, threads: usize) -> Cost {
        self.end_stage();
        Cost {
            stages: self.stages.clone(),
            wall_s: self.begun.elapsed().as_secs_f64(),
            cpu_s: cpu_seconds() - self.begun_cpu,
            peak_memory_mib: peak_memory_mib(),
            steps,
            device: device.to_owned(),
            threads: u32::try_from(threads).unwrap_or(u32::MAX),
        }
    }
}

/// User and system seconds of this process.
fn cpu_seconds() -> f64 {
    std::fs::read_to_string("/proc/self/stat").map_or(0.0, |stat| cpu_of(&stat))
}

/// The same from the text of `/proc/PID/stat`.
fn cpu_of(stat: &str) -> f64 {
    // The second field is the name in parentheses and may hold spaces; utime and stime are the
    // 14th and 15th.
    let Some((_, rest)) = stat.rsplit_once(')') else { return 0.0 };
    let ticks = rest.split_whitespace().skip(11).take(2).filter_map(|t| t.parse::<f64>().ok());
    ticks.sum::<f64>() * TICK_S
}

/// High-water mark of the resident set.
fn peak_memory_mib() -> Option<f64> {
    peak_of(&std::fs::read_to_string("/proc/self/status").ok()?)
}

/// The same from the text of `/proc/PID/status`.
fn peak_of(status: &str) -> Option<f64> {
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    let kib: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib / 1024.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stage_met_twice_is_one_row() {
        let mut clock = Clock::new();
        for stage in [Stage::Polish, Stage::Pack, Stage::Polish] {
            clock.stage(stage);
        }
        let cost = clock.cost(0, "none", 1);
        let names: Vec<_> = cost.stages.iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names, ["polish", "pack"]);
        assert!(cost.stages.iter().map(|s| s.wall_s).sum::<f64>() <= cost.wall_s);
    }

    #[test]
    fn a_stage_that_is_come_back_to_costs_the_sum() {
        let mut clock = Clock::new();
        let wait = || std::thread::sleep(std::time::Duration::from_millis(20));
        clock.count(7);
        for stage in [Stage::Polish, Stage::Pack, Stage::Polish] {
            clock.stage(stage);
            clock.count(3);
            wait();
        }
        let cost = clock.cost(0, "none", 1);
        let [polish, pack] = &cost.stages[..] else { panic!("{:?}", cost.stages) };
        assert!(polish.wall_s >= 0.04 && pack.wall_s >= 0.02, "{cost:?}");
        assert!(polish.wall_s + pack.wall_s <= cost.wall_s, "{cost:?}");
        // What is counted before the first stage belongs to none.
        assert_eq!((polish.work, pack.work), (6, 3));
        assert_eq!(polish.unit, Stage::Polish.unit());
    }

    /// A program's name may hold what separates the fields.
    #[test]
    fn the_kernels_words_are_read() {
        let stat = "7 (a) b (c) R 1 2 3 4 5 6 7 8 9 10 250 150 99 99";
        assert_eq!(cpu_of(stat), 4.0);
        assert_eq!(cpu_of("nothing"), 0.0);
        assert_eq!(peak_of("VmPeak: 1 kB\nVmHWM:\t  3072 kB\n"), Some(3.0));
        assert_eq!(peak_of("VmPeak: 1 kB"), None);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn work_costs_cpu_and_memory() {
        let mut clock = Clock::new();
        let before = clock.cost(0, "none", 1).cpu_s;
        let begun = Instant::now();
        let mut sum = 0u64;
        while cpu_seconds() - clock.begun_cpu < 0.05 && begun.elapsed().as_secs() < 60 {
            sum = (0..100_000u64).fold(sum, |sum, i| std::hint::black_box(sum ^ i));
        }
        let cost = clock.cost(0, "none", 1);
        assert!(before < 60.0 && cost.cpu_s >= 0.05 && cost.cpu_s < 600.0, "{cost:?}");
        // A test holds more than three megabytes and less than all there is.
        assert!(cost.peak_memory_mib.is_some_and(|m| (3.0..1e6).contains(&m)), "{cost:?}");
    }
}
