//! Log lines: for the operator on standard error, and for the client as the artifact `log.jsonl` of
//! the job that a worker runs.

use std::io::{self, Write};
use std::sync::{Mutex, MutexGuard};

use tracing_subscriber::fmt::MakeWriter;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use tracing_subscriber::{EnvFilter, Layer};

/// The environment variable that says what is logged, in the syntax of `RUST_LOG`.
const FILTER: &str = "UVSEGNET_LOG";

/// Most bytes of a job's log; further lines are left out.
const JOB_LOG_BYTES: usize = 4 << 20;

/// The lines of the job that this process runs; `None` while it runs none.
static JOB_LOG: Mutex<Option<Vec<u8>>> = Mutex::new(None);

/// How much the operator is told where the environment does not say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Told {
    /// What begins and ends, and what goes wrong.
    #[default]
    Usual,
    /// What goes wrong for good.
    Errors,
}

/// Begin to log. Later calls change nothing.
pub fn init(told: Told) {
    let level = |fallback: &str| {
        EnvFilter::try_from_env(FILTER).unwrap_or_else(|_| EnvFilter::new(fallback))
    };
    let usual = match told {
        Told::Usual => "warn,uvsegnet=info",
        Told::Errors => "error",
    };
    let operator = tracing_subscriber::fmt::layer()
        .with_writer(io::stderr)
        .with_ansi(io::IsTerminal::is_terminal(&io::stderr()))
        .with_target(false)
        .with_filter(level(usual));
    let client = tracing_subscriber::fmt::layer()
        .json()
        .flatten_event(true)
        .with_writer(JobLog)
        .with_filter(EnvFilter::new("warn,uvsegnet=debug"));
    let _ = tracing_subscriber::registry().with(operator).with(client).try_init();
}

/// The log of the job that this process runs. A worker runs one job at a time.
#[derive(Debug, Clone, Copy)]
pub struct JobLog;

impl JobLog {
    /// Begin the log of a new job.
    pub fn begin() {
        *lines() = Some(Vec::new());
    }

    /// The lines so far, one JSON object each.
    pub fn so_far() -> Vec<u8> {
        lines().clone().unwrap_or_default()
    }

    /// The job is over.
    pub fn end() {
        *lines() = None;
    }
}

/// A panic while a line was written leaves the lines before it intact.
fn lines() -> MutexGuard<'static, Option<Vec<u8>>> {
    JOB_LOG.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

impl Write for JobLog {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        if let Some(log) = lines().as_mut()
            && log.len() + line.len() <= JOB_LOG_BYTES
        {
            log.extend_from_slice(line);
        }
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl MakeWriter<'_> for JobLog {
    type Writer = JobLog;

    fn make_writer(&self) -> JobLog {
        JobLog
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_job_log_holds_the_lines_of_its_job() {
        init(Told::Usual);
        tracing::info!("prelude-of-the-log-test");
        JobLog::begin();
        tracing::info!(answer = 42, "within");
        let log = JobLog::so_far();
        JobLog::end();
        tracing::info!("epilogue-of-the-log-test");
        let text = String::from_utf8(log).unwrap();
        let ours: Vec<serde_json::Value> = text
            .lines()
            .map(|line| serde_json::from_str(line).unwrap())
            .filter(|line: &serde_json::Value| line["answer"] == 42)
            .collect();
        assert_eq!(ours.len(), 1);
        assert_eq!(ours[0]["message"], "within");
        assert!(!text.contains("prelude-of") && !text.contains("epilogue-of"));
        assert!(JobLog::so_far().is_empty());
    }
}
