//! The types that cross every boundary of the program: the command line (clap), the API (serde,
//! OpenAPI) and the pipeline use these same types, so that they cannot drift apart. No algorithm
//! lives here and nothing here knows another module.

mod budget;
mod cancel;
mod certificate;
mod density;
mod error_code;
mod input;
mod limits;
mod mesh_kind;
mod metrics;
mod option_values;
mod options;
mod progress;

pub use budget::Budget;
pub use cancel::{Cancel, Canceled};
pub use certificate::Certificate;
pub use density::weights as density_weights;
pub use error_code::{ErrorCode, JobError};
pub use input::InputRole;
pub use limits::Limits;
pub use mesh_kind::MeshKind;
pub use metrics::*;
pub use option_values::{
    AtlasGrouping, DoubleSided, LossForm, Quality, Rotation, Seed, SegmentationSource, StopAfter,
};
pub use options::{OptionError, UnwrapOptions};
pub use progress::{Progress, Run, Stage};
