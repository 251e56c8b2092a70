//! Parts into charts: boundary features, cylinders and cones, cuts, split and merge. A chart is a
//! topological disk, cut open. Every disk is made from patches that are disks by construction and
//! joined along one path at a time, so that holes, handles and closed surfaces are cut and never
//! refused.

pub mod boundary;
mod build;
mod candidates;
mod chart;
mod cluster;
mod cost;
mod extent;
mod fit;
mod limits;
mod merge;
mod open;
mod part_mesh;
mod patchwork;
mod split;
mod tube;

#[cfg(test)]
mod tests;

pub use build::{ChartOptions, build, split_chart};
pub use chart::{Chart, ChartShape, StartKind};
pub use fit::is_sound;
pub use limits::clearance;
