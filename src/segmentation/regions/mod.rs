//! Parts as sets of regions: evidence from network, geometry and file (`evidence`); the authored
//! components (`solids`) and the initial regions into which they are over-segmented (`patches`); their
//! graph, with the places where welded components touch (`region`, `graph`, `contact`); and its
//! agglomeration to a hierarchy by the boundary classifier or the rule (`features`, `judge`, `rule`,
//! `hierarchy`).

pub mod contact;
pub mod evidence;
pub mod features;
pub mod graph;
pub mod hierarchy;
pub mod judge;
pub mod patches;
pub mod region;
pub mod rule;
pub mod solids;

pub use evidence::{Evidence, gather};
pub use features::{AUTHORED, FEATURES, LEARNED, SHAPE};
pub use graph::RegionGraph;
pub use hierarchy::{Boundary, Hierarchy, Join, agglomerate};
pub use judge::{Heard, Judge, Opinion};
pub use region::Region;
pub use rule::Rule;
pub use solids::Solids;

use crate::contract::{Canceled, Run};
use crate::mesh::Surface;
use crate::sampling::PointCloud;

/// A surface made ready: its initial regions and their graph.
pub struct Prepared {
    /// Initial region of each face; [`NONE`](crate::mesh::NONE) for faces without area.
    pub patch: Vec<u32>,
    /// The graph of the regions.
    pub graph: RegionGraph,
    /// Where welded components touch.
    pub contacts: Vec<contact::Contact>,
}

/// Make a surface ready. `truth`: part of each face, where it is to be learned from.
pub fn prepare(
    surface: &Surface,
    cloud: &PointCloud,
    evidence: &Evidence,
    truth: Option<&[i32]>,
    run: &Run,
) -> Result<Prepared, Canceled> {
    let bodies = solids::bodies(surface);
    let solids = Solids::new(surface, &bodies);
    let (patch, count) = patches::patches(surface, evidence, &solids);
    run.cancel.check()?;
    let contacts = contact::contacts(surface, cloud, &bodies);
    let graph = RegionGraph::new(surface, evidence, (&patch, count), (&contacts, solids), truth);
    Ok(Prepared { patch, graph, contacts })
}
