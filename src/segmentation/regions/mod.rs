//! Parts as sets of regions: evidence from network, geometry and file (`evidence`); the authored
//! components (`components`) and the initial regions into which they are over-segmented (`patches`); their
//! graph, with the places where welded components touch (`region`, `graph`, `contact`); and its
//! agglomeration to a hierarchy by the boundary classifier or the rule (`features`, `boundary_classifier`, `rule`,
//! `hierarchy`).

pub mod boundary_classifier;
pub mod components;
pub mod contact;
pub mod evidence;
pub mod features;
pub mod graph;
pub mod hierarchy;
pub mod patches;
pub mod region;
pub mod rule;

pub use boundary_classifier::{BoundaryClassifier, Heard, Opinion};
pub use components::AuthoredComponents;
pub use evidence::{Evidence, gather};
pub use features::{AUTHORED, FEATURES, LEARNED, SHAPE};
pub use graph::RegionGraph;
pub use hierarchy::{Boundary, Hierarchy, Join, agglomerate};
pub use region::Region;
pub use rule::Rule;

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
    let welded = components::welded(surface);
    let components = AuthoredComponents::new(surface, &welded);
    let (patch, count) = patches::patches(surface, evidence, &components);
    run.cancel.check()?;
    let contacts = contact::contacts(surface, cloud, &welded);
    let graph =
        RegionGraph::new(surface, evidence, (&patch, count), (&contacts, components), truth);
    Ok(Prepared { patch, graph, contacts })
}
