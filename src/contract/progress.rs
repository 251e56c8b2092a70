//! What the engine tells while it works: one enum, the whole contract between it and its front ends
//! (progress bar, event stream).

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::Warning;

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

    /// What its work is counted in.
    pub fn unit(self) -> &'static str {
        match self {
            Stage::Import | Stage::Condition | Stage::Measure => "triangles",
            Stage::Sample => "points",
            Stage::Segment => "places looked at",
            Stage::Charts | Stage::Polish => "faces flattened",
            Stage::Train => "points trained on",
            Stage::Pack => "words of masks compared",
            Stage::Preview => "pixels",
            Stage::Export => "bytes",
        }
    }

    /// Share of the job's wall clock by which the stage should be over, where the job was given a time: a
    /// stage that is later takes its cheaper form, so that those behind it get theirs.
    pub fn deadline(self) -> f64 {
        match self {
            Stage::Import | Stage::Condition | Stage::Sample => 0.2,
            Stage::Segment => 0.25,
            Stage::Charts => 0.5,
            Stage::Train => 0.6,
            Stage::Polish => 0.65,
            Stage::Pack => 0.75,
            Stage::Measure | Stage::Preview => 0.85,
            Stage::Export => 1.0,
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
    /// The job goes on.
    Progress {
        /// The stage that it is in.
        stage: Stage,
        /// Share of the job's work that is done, 0 to 1; it never falls. Stages count by the work that is
        /// expected of them for an input of this size.
        fraction: f64,
        /// Parts of which every chart has its map.
        parts_done: u32,
        /// Parts in all; 0 until they are known.
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
    Warning(Warning),
}
