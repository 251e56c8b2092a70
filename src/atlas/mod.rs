//! The atlas: charts placed on pages at one texel density, their coordinates made single precision
//! without losing a triangle, and the proof that nothing overlaps: by raster, by exact predicates,
//! and by the gutter between charts.

mod arrangement;
mod certificate;
mod effort;
mod gutter;
mod mask;
mod options;
mod pack;
mod page;
mod piece;
mod placement;
mod quantise;
mod raster;
mod search;

pub use certificate::{AtlasCertificates, Demands, Placed, certify_atlas};
pub use gutter::gutters;
pub use options::PackOptions;
pub use pack::{Atlas, PackError, pack};
pub use placement::Placement;
pub use quantise::{Grid, Quantised, quantise};
pub use raster::{Coverage, raster_bytes, rasterise};
