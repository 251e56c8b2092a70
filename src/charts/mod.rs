//! Parts into charts: boundary features, cylinders and cones, cuts, split and merge. A chart is a
//! topological disk, or a flat set of faces with holes. Charts are made from patches that can be
//! flattened and are joined along one path at a time, so that holes, handles and closed surfaces are cut
//! where they must be and never refused.

mod attempt;
pub mod boundary;
mod build;
mod candidates;
mod chart;
mod cluster;
mod collision;
mod compact;
mod cost;
mod extent;
mod fit;
mod initial;
#[cfg(test)]
mod joint_tests;
mod limits;
mod merge;
mod open;
mod over_cut;
mod part_mesh;
mod patches;
mod patchwork;
#[cfg(test)]
mod scenes;
mod sides;
mod split;
mod straighten;
mod tube;
mod visibility;

#[cfg(test)]
mod tests;

pub use build::{Arms, Built, ChartOptions, build, build_jointly, split_chart};
pub use chart::{Chart, ChartShape, StartKind};
pub use fit::is_sound;
pub use initial::initial_patches;
pub use limits::clearance;
pub use over_cut::{OverCutPart, Seam, over_cut};
