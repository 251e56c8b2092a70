//! Step two: charts joined along one path of seam at a time while the objective falls: which paths may
//! be closed, whether one is worth a solve, and the order in which they are tried.

pub mod candidates;
mod collision;
pub mod merge;
pub mod over_cut;
pub mod proposal;
mod queue;
pub mod rejoin;
