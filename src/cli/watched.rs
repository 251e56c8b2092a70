//! A run of the pipeline that shows itself on standard error: a bar with stage and share on a terminal, a line
//! a stage elsewhere, nothing but warnings where quiet was asked for.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use super::told;
use crate::contract::{Budget, Cancel, Progress, Run, Stage, UnwrapOptions};

/// Steps of the bar.
const SCALE: u64 = 1000;

/// How much is said.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct Quiet {
    /// Say nothing but warnings and errors.
    #[arg(short, long)]
    pub quiet: bool,
}

/// Where progress goes.
enum Screen {
    /// A bar on a terminal.
    Bar(ProgressBar),
    /// A line a stage: the last one that was told, and the fraction of the job that is done.
    Lines(Mutex<(Option<Stage>, f64)>),
    /// Nowhere.
    Nothing,
}

impl Screen {
    fn new(quiet: bool, terminal: bool) -> Self {
        match (quiet, terminal) {
            (true, _) => Self::Nothing,
            (false, false) => Self::Lines(Mutex::new((None, 0.0))),
            (false, true) => {
                let bar = ProgressBar::new(SCALE);
                let template = "{msg:<24} {wide_bar} {percent:>3} % {elapsed}";
                let style = ProgressStyle::with_template(template);
                bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
                bar.enable_steady_tick(Duration::from_millis(200));
                Self::Bar(bar)
            }
        }
    }

    /// Show what was told, and return the line that is to be printed for it.
    fn show(&self, progress: &Progress) -> Option<String> {
        match (self, progress) {
            (_, Progress::Warning(warning)) => {
                let line = format!("warning: {}", told::as_flags(&warning.message));
                let Self::Bar(bar) = self else { return Some(line) };
                bar.println(line);
                None
            }
            (Self::Bar(bar), Progress::Stage { stage }) => {
                bar.set_message(stage.as_str());
                None
            }
            (Self::Bar(bar), Progress::Progress { stage, fraction, parts_done, parts_total }) => {
                bar.set_message(match parts_total {
                    0 => stage.as_str().to_owned(),
                    _ => format!("{} {parts_done}/{parts_total}", stage.as_str()),
                });
                bar.set_position((SCALE as f64 * fraction.clamp(0.0, 1.0)) as u64);
                None
            }
            (Self::Lines(told), Progress::Stage { stage }) => {
                let mut told = told.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
                // The pipeline may go back; a stage is told when it is first reached.
                let is_new = told.0.is_none_or(|last| *stage > last);
                is_new.then(|| {
                    told.0 = Some(*stage);
                    format!("{:>3.0} %  {}", 100.0 * told.1, stage.as_str())
                })
            }
            (Self::Lines(told), Progress::Progress { fraction, .. }) => {
                told.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).1 = *fraction;
                None
            }
            _ => None,
        }
    }
}

/// A run that shows itself. The bar is to be cleared when it is over.
pub fn run(options: &UnwrapOptions, quiet: Quiet) -> (Run, Watcher) {
    let screen = Screen::new(quiet.quiet, std::io::stderr().is_terminal());
    let bar = match &screen {
        Screen::Bar(bar) => Some(bar.clone()),
        _ => None,
    };
    let show = move |progress: Progress| {
        if let Some(line) = screen.show(&progress) {
            eprintln!("{line}");
        }
    };
    let budget = Budget::new(options.budget_s, options.budget_mib);
    (Run::new(show, Cancel::default(), budget), Watcher(bar))
}

/// Takes the bar from the screen when it goes.
pub struct Watcher(Option<ProgressBar>);

impl Drop for Watcher {
    fn drop(&mut self) {
        if let Some(bar) = &self.0 {
            bar.finish_and_clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::{Warning, WarningCode};

    fn at(stage: Stage, fraction: f64) -> Progress {
        Progress::Progress { stage, fraction, parts_done: 0, parts_total: 0 }
    }

    #[test]
    fn without_a_terminal_each_stage_is_a_line() {
        let screen = Screen::new(false, false);
        let told = [
            Progress::Stage { stage: Stage::Import },
            at(Stage::Import, 0.25),
            Progress::Stage { stage: Stage::Charts },
            at(Stage::Charts, 0.5),
            at(Stage::Charts, 0.75),
            Progress::Stage { stage: Stage::Pack },
            Progress::Stage { stage: Stage::Polish },
        ];
        let lines: Vec<String> = told.iter().filter_map(|p| screen.show(p)).collect();
        assert_eq!(lines, ["  0 %  import", " 25 %  charts", " 75 %  pack"]);
    }

    #[test]
    fn warnings_are_told_whatever_else_is() {
        let warning = Warning::new(WarningCode::Degraded, "too little time (`budget_s`)");
        let warning = Progress::Warning(warning);
        for quiet in [false, true] {
            let screen = Screen::new(quiet, false);
            let line = screen.show(&warning);
            assert_eq!(line.as_deref(), Some("warning: too little time (--budget-s)"));
        }
        assert!(Screen::new(true, true).show(&at(Stage::Charts, 0.5)).is_none());
    }
}
