//! A progress bar on standard error for the commands that run the pipeline themselves.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use crate::contract::{Budget, Cancel, Progress, Run, UnwrapOptions};

/// Steps of the bar.
const SCALE: u64 = 1000;

/// A run that shows itself as a bar; quiet where standard error is no terminal, warnings apart.
pub fn run(options: &UnwrapOptions) -> (Run, ProgressBar) {
    let bar = ProgressBar::new(SCALE);
    let style = ProgressStyle::with_template("{msg:<24} {wide_bar} {elapsed}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    bar.set_style(style);
    bar.enable_steady_tick(Duration::from_millis(200));
    let shown = bar.clone();
    let show = move |progress: Progress| match progress {
        Progress::Stage { stage } => shown.set_message(stage.as_str()),
        Progress::Progress { stage, fraction, parts_done, parts_total } => {
            shown.set_message(match parts_total {
                0 => stage.as_str().to_owned(),
                _ => format!("{} {parts_done}/{parts_total}", stage.as_str()),
            });
            shown.set_position((SCALE as f64 * fraction.clamp(0.0, 1.0)) as u64);
        }
        Progress::Warning(warning) => {
            let line = format!("warning: {}", warning.message);
            if shown.is_hidden() { eprintln!("{line}") } else { shown.println(line) }
        }
        Progress::PartCompleted { .. } => {}
    };
    let budget = Budget::new(options.budget_s, options.budget_mib);
    (Run::new(show, Cancel::default(), budget), bar)
}
