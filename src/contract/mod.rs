//! The types that cross every boundary of the program: the command line (clap), the API (serde,
//! OpenAPI) and the pipeline use these same types, so that they cannot drift apart. No algorithm
//! lives here and nothing here knows another module.

mod artifact;
mod budget;
mod cancel;
mod certificate;
mod chart_words;
mod clock;
mod density;
mod error_code;
mod figures;
mod format;
mod input;
mod limits;
mod metrics;
mod option_table;
mod option_values;
mod options;
mod progress;
mod repairs;
mod run;
mod switch;
mod warning;

pub use artifact::{ArtifactKind, Written};
pub use budget::{Budget, Degradation, GaveUp, Scarce};
pub use cancel::{Cancel, Canceled};
pub use certificate::Certificate;
pub use chart_words::{ChartForm, ShapeKind, StartKind};
pub use density::weights as density_weights;
pub use error_code::{ErrorCode, JobError};
pub use figures::*;
pub use format::{Carry, MeshKind};
pub use input::InputRole;
pub use limits::Limits;
pub use metrics::*;
pub use option_table::{OptionGroup, OptionInfo};
pub use option_values::{
    AtlasGrouping, DoubleSided, LossForm, Quality, Rotation, Seed, SegmentationSource, StopAfter,
    Winding,
};
pub use options::{OptionError, UnwrapOptions};
pub use progress::{Progress, Stage};
pub use repairs::{FirstFaces, Repairs};
pub use run::{Run, Steps};
pub use warning::{Warning, WarningCode};
