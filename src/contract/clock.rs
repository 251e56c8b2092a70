//! What each stage costs: wall clock, CPU time over all threads, and the most memory the process
//! held, as Linux tells them under /proc (zero and null elsewhere).

use std::time::Instant;

use super::{Cost, Stage, StageCost};

/// Length of the kernel's clock tick as user space sees it (USER_HZ is 100 on every Linux).
const TICK_S: f64 = 0.01;

/// Runs while the pipeline runs.
#[derive(Debug)]
pub struct Clock {
    begun: Instant,
    begun_cpu: f64,
    current: Option<(Stage, Instant, f64)>,
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
        self.current = Some((stage, Instant::now(), cpu_seconds()));
    }

    fn end_stage(&mut self) {
        if let Some((stage, wall, cpu)) = self.current.take() {
            let (wall_s, cpu_s) = (wall.elapsed().as_secs_f64(), cpu_seconds() - cpu);
            // A stage that the pipeline comes back to is one row.
            match self.stages.iter_mut().find(|s| s.name == stage.as_str()) {
                Some(row) => {
                    row.wall_s += wall_s;
                    row.cpu_s += cpu_s;
                }
                None => self.stages.push(StageCost { name: stage.as_str().into(), wall_s, cpu_s }),
            }
        }
    }

    /// The cost so far.
    pub fn cost(&mut self, steps: u32, device: &str) -> Cost {
        self.end_stage();
        Cost {
            stages: self.stages.clone(),
            wall_s: self.begun.elapsed().as_secs_f64(),
            cpu_s: cpu_seconds() - self.begun_cpu,
            peak_memory_mib: peak_memory_mib(),
            steps,
            device: device.to_owned(),
        }
    }
}

/// User and system seconds of this process.
fn cpu_seconds() -> f64 {
    let Ok(stat) = std::fs::read_to_string("/proc/self/stat") else { return 0.0 };
    // The second field is the name in parentheses and may hold spaces; utime and stime are the
    // 14th and 15th.
    let Some((_, rest)) = stat.rsplit_once(')') else { return 0.0 };
    let ticks = rest.split_whitespace().skip(11).take(2).filter_map(|t| t.parse::<f64>().ok());
    ticks.sum::<f64>() * TICK_S
}

/// High-water mark of the resident set.
fn peak_memory_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
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
        let cost = clock.cost(0, "none");
        let names: Vec<_> = cost.stages.iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names, ["polish", "pack"]);
        assert!(cost.stages.iter().map(|s| s.wall_s).sum::<f64>() <= cost.wall_s);
    }
}
