//! The whole contract between the engine and its front ends (progress bar, event stream): one enum
//! of progress, and the three things that every long call is given.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{Budget, Cancel, Canceled};

/// The stages of the pipeline, in the order in which a job passes them.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Read the file.
    Import,
    /// Weld, pair, orient.
    Condition,
    /// Place points on the surface.
    Sample,
    /// Find the parts.
    Segment,
    /// Cut the parts into disks.
    Charts,
    /// Train the part networks.
    Train,
    /// Descend to the nearest optimum and certify.
    Polish,
    /// Place the charts in the atlas.
    Pack,
    /// Take the figures.
    Measure,
    /// Draw the pictures.
    Preview,
    /// Write the files.
    Export,
}

impl Stage {
    /// Every stage, in order.
    pub const ALL: [Stage; 11] = [
        Stage::Import,
        Stage::Condition,
        Stage::Sample,
        Stage::Segment,
        Stage::Charts,
        Stage::Train,
        Stage::Polish,
        Stage::Pack,
        Stage::Measure,
        Stage::Preview,
        Stage::Export,
    ];

    /// The stage as it is written in JSON.
    pub fn as_str(self) -> &'static str {
        match self {
            Stage::Import => "import",
            Stage::Condition => "condition",
            Stage::Sample => "sample",
            Stage::Segment => "segment",
            Stage::Charts => "charts",
            Stage::Train => "train",
            Stage::Polish => "polish",
            Stage::Pack => "pack",
            Stage::Measure => "measure",
            Stage::Preview => "preview",
            Stage::Export => "export",
        }
    }
}

/// What the engine tells while it works.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Progress {
    /// A stage begins.
    Stage {
        /// Which one.
        stage: Stage,
    },
    /// A stage goes on.
    Progress {
        /// Which one.
        stage: Stage,
        /// Share of this stage that is done, 0 to 1.
        fraction: f64,
        /// Parts whose charts are finished.
        parts_done: u32,
        /// Parts in all.
        parts_total: u32,
    },
    /// All charts of a part are final.
    PartCompleted {
        /// The part.
        part: u32,
        /// Its name.
        name: String,
        /// How many charts it has.
        charts: u32,
        /// Its symmetric Dirichlet energy (1 is isometric), each chart at its own best scale.
        symmetric_dirichlet: f64,
    },
    /// Something the user should know; the job goes on.
    Warning {
        /// A short machine-readable word.
        code: String,
        /// A sentence.
        message: String,
    },
}

/// What every long call is given: where to tell progress, when to stop, how much it may use.
#[derive(Clone)]
pub struct Run {
    progress: Arc<dyn Fn(Progress) + Send + Sync>,
    /// Asked to stop?
    pub cancel: Cancel,
    /// How much may be used.
    pub budget: Arc<Budget>,
}

impl Run {
    /// A run that reports to `progress`.
    pub fn new(
        progress: impl Fn(Progress) + Send + Sync + 'static,
        cancel: Cancel,
        budget: Budget,
    ) -> Self {
        Self { progress: Arc::new(progress), cancel, budget: Arc::new(budget) }
    }

    /// A run that nobody watches, with the default budget.
    pub fn quiet() -> Self {
        Self::new(|_| {}, Cancel::default(), Budget::default())
    }

    /// Tell one thing.
    pub fn tell(&self, progress: Progress) {
        (self.progress)(progress);
    }

    /// Begin a stage: tells it and stops here if the work was canceled.
    pub fn stage(&self, stage: Stage) -> Result<(), Canceled> {
        self.cancel.check()?;
        self.tell(Progress::Stage { stage });
        Ok(())
    }

    /// Tell a warning.
    pub fn warn(&self, code: &str, message: impl Into<String>) {
        self.tell(Progress::Warning { code: code.into(), message: message.into() });
    }
}
