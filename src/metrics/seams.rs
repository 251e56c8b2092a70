//! Seams: how many edges, how long, how many connected curves.

use super::EdgeTable;
use super::levels::Level;
use crate::contract::SeamLength;
use crate::mesh::DisjointSets;

/// The seams of one level.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Seams {
    /// Cuts.
    pub edges: u64,
    /// Their length in 3D, world units.
    pub length: f64,
    /// Connected curves (paper, Table 4).
    pub curves: u64,
}

impl Seams {
    /// An edge belongs to a part or chart as soon as one of its faces does.
    pub(super) fn of(table: &EdgeTable, level: &Level) -> Self {
        let mut seams = Self::default();
        let mut ends: Vec<[u32; 2]> = vec![];
        for (e, cuts) in level.edges_with_cuts().filter(|(_, cuts)| *cuts > 0) {
            seams.edges += u64::from(cuts);
            seams.length += f64::from(cuts) * table.length[e];
            ends.push(table.ends[e]);
        }
        seams.curves = connected(&ends);
        seams
    }

    /// Made free of size: by the level's own area, and by the diagonal of the whole object.
    pub(super) fn normalised(self, area: f64, diagonal: f64) -> Option<SeamLength> {
        (area > 0.0 && diagonal > 0.0).then(|| SeamLength {
            per_sqrt_area: self.length / area.sqrt(),
            per_diagonal: self.length / diagonal,
        })
    }
}

/// Number of connected components of a graph that is given by its edges.
fn connected(edges: &[[u32; 2]]) -> u64 {
    let mut nodes: Vec<u32> = edges.iter().flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    let mut sets = DisjointSets::new(nodes.len());
    let mut components = nodes.len() as u64;
    for edge in edges {
        let [a, b] = edge.map(|v| nodes.partition_point(|&n| n < v) as u32);
        components -= u64::from(sets.join(a, b));
    }
    components
}
