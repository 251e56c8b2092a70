//! Parts into charts: boundary features, cylinders and cones, cuts, split and merge. A chart is a
//! topological disk, or a flat set of faces with holes. Charts are made from patches that can be
//! flattened and are joined along one path at a time, so that holes, handles and closed surfaces are cut
//! where they must be and never refused.

pub mod boundary;
mod build;
mod chart;
mod component;
mod joins;
#[cfg(test)]
mod joint_tests;
mod limits;
mod moves;
mod objective;
mod part_mesh;
mod patches;
mod patchwork;
#[cfg(test)]
mod scenes;
#[cfg(test)]
mod tests;

pub use build::{Built, ChartOptions, build, build_jointly, split_chart};
pub use chart::{Chart, ChartShape, StartKind};
pub use component::Orders;
pub use joins::over_cut::{OverCutPart, Seam, over_cut};
pub use limits::clearance;
pub use limits::cost::seam_cost;
pub use limits::fit::{is_sound, is_sound_within};
pub use objective::objective;
pub use part_mesh::{PartMesh, Piece};
pub use patches::{initial_patches, open_where};
