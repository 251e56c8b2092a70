//! The wall-clock time and memory that one job may use. Cheaper forms are chosen from counted work
//! before a stage starts; the clock is only the last guard, and a result that it changed says so.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use super::Stage;

/// A job's allowance, started when it is made.
#[derive(Debug)]
pub struct Budget {
    started: Instant,
    wall: Duration,
    memory_mib: u64,
    degraded: Mutex<Vec<Stage>>,
}

impl Budget {
    /// A budget of `wall_s` seconds and `memory_mib` MiB that starts now.
    pub fn new(wall_s: f64, memory_mib: u64) -> Self {
        Self {
            started: Instant::now(),
            wall: Duration::from_secs_f64(wall_s.clamp(0.0, 1e9)),
            memory_mib,
            degraded: Mutex::new(Vec::new()),
        }
    }

    /// Seconds since the start.
    pub fn elapsed_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Whether `share` (0 to 1) of the wall clock is spent. A stage that sees `true` takes its
    /// cheaper form and must say so with [`Budget::degrade`].
    pub fn spent(&self, share: f64) -> bool {
        self.started.elapsed().as_secs_f64() >= self.wall.as_secs_f64() * share
    }

    /// MiB that the job may hold.
    pub fn memory_mib(&self) -> u64 {
        self.memory_mib
    }

    /// Record that the clock made `stage` take a cheaper form: the result is no longer a function
    /// of the input alone.
    pub fn degrade(&self, stage: Stage) {
        let mut list = self.degraded.lock().unwrap_or_else(|e| e.into_inner());
        if !list.contains(&stage) {
            list.push(stage);
        }
    }

    /// The stages that the clock cut short, in the order in which they were.
    pub fn degraded(&self) -> Vec<Stage> {
        self.degraded.lock().unwrap_or_else(|e| e.into_inner()).clone()
    }
}

impl Default for Budget {
    fn default() -> Self {
        Self::new(600.0, 4096)
    }
}
