//! A progress bar on standard error for the commands that run the pipeline themselves.

use std::sync::Mutex;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use crate::contract::{Budget, Cancel, Progress, Run, Stage, UnwrapOptions};

/// A run that shows itself as a bar; quiet where standard error is no terminal, warnings apart.
pub fn run(options: &UnwrapOptions) -> (Run, ProgressBar) {
    let bar = ProgressBar::new(1000 * Stage::ALL.len() as u64);
    let style = ProgressStyle::with_template("{msg:<24} {wide_bar} {elapsed}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    bar.set_style(style);
    bar.enable_steady_tick(Duration::from_millis(200));
    let shown = bar.clone();
    let current = Mutex::new(Stage::Import);
    let show = move |progress: Progress| {
        let position = |stage: Stage, fraction: f64| {
            let index = Stage::ALL.iter().position(|&s| s == stage).unwrap_or(0);
            (1000.0 * (index as f64 + fraction.clamp(0.0, 1.0))) as u64
        };
        match progress {
            Progress::Stage { stage } => {
                *current.lock().unwrap_or_else(|e| e.into_inner()) = stage;
                shown.set_message(stage.as_str());
                shown.set_position(position(stage, 0.0));
            }
            Progress::Progress { stage, fraction, parts_done, parts_total } => {
                shown.set_message(format!("{} {parts_done}/{parts_total}", stage.as_str()));
                shown.set_position(position(stage, fraction));
            }
            Progress::Warning(warning) => {
                let line = format!("warning: {}", warning.message);
                if shown.is_hidden() { eprintln!("{line}") } else { shown.println(line) }
            }
            Progress::PartCompleted { .. } => {}
        }
    };
    let budget = Budget::new(options.budget_s, options.budget_mib);
    (Run::new(show, Cancel::default(), budget), bar)
}
