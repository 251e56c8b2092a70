//! The figures of `metrics.json`, one file a family; docs/metrics.md defines each in prose. All are
//! taken on the exported coordinates: what is measured is what ships.

mod alignment;
mod avoidable;
mod consistency;
mod contact;
mod curvature;
mod distortion;
mod edges;
mod figures;
#[cfg(test)]
pub(crate) mod fixtures;
mod instances;
mod jaggedness;
mod levels;
mod packing;
mod paper;
mod partuv;
mod seams;
mod small_charts;
mod statistics;
mod stretch;
#[cfg(test)]
mod tests;

pub use curvature::developable;
pub use edges::{EdgeTable, places};
pub use figures::{Measured, MeasuredFigures, measure};
pub use instances::transformed_dirichlet;
pub use jaggedness::{Jaggedness, seam_jaggedness};
pub use packing::packing_efficiency;
pub use small_charts::{SmallCharts, small_charts};
pub use stretch::FaceMap;
