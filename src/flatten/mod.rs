//! Maps of one disk to the plane: the measures of a map (Jacobians, energies), the maps that need
//! no training (unroll, planar, unfold, LSCM, Tutte), the descent that keeps triangles unflipped
//! (SLIM), and the proof that one chart is injective.

mod border;
mod classical;
mod clearance;
mod coarse;
mod colors;
mod disk;
mod error;
mod extend;
mod fans;
mod harmonic;
mod injective;
mod jacobian;
mod krylov;
mod lscm;
mod model;
mod overlap;
mod pattern;
mod pinches;
mod planar;
mod rectangle;
mod relax;
mod separate;
mod slim;
mod start;
mod step;
mod stitch;
mod sweep;
mod system;
mod tutte;
mod unfold;
mod unroll;
mod untangle;

#[cfg(test)]
pub(crate) mod samples;

pub use border::{Border, is_disk};
pub use classical::{Island, classical_islands, unwrap_classically};
pub use clearance::{is_clear, touching};
pub use disk::{Disk, UvMap, flatten_triangle};
pub use error::FlattenError;
pub use extend::extend;
pub use harmonic::harmonic;
pub use injective::{
    ChartProof, certify, certify_within, count_flips, has_simple_boundary, is_positive, is_simple,
    orientation, segments_meet,
};
pub use jacobian::{
    MapQuality, mean_energy, quality, rescale, rescale_optimally, scale, singular_values,
    symmetric_dirichlet, symmetric_dirichlet_gradient,
};
pub use lscm::lscm;
pub use overlap::{list_overlapping_pairs, overlap_depth, overlapping_pairs};
pub use pattern::Pattern;
pub use pinches::parted;
pub use planar::planar;
pub use rectangle::smallest_rectangle;
pub use relax::relax;
pub use separate::separate;
pub use slim::{Slim, SlimOptions, slim};
pub use start::{StartMap, start_map};
pub use stitch::{misfit, stitch};
pub use tutte::tutte;
pub use unfold::unfold;
pub use unroll::unroll;
pub use untangle::untangle;
