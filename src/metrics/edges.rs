//! The edges of the measured surface and what meets at each: faces, different UV edges, cuts, part
//! boundaries. Edges are those of positions, not of vertices: where conditioning took a vertex apart
//! its copies still stand at one place.
//!
//! Faces pair off at an edge, so `k` of them need ⌈k/2⌉ different UV edges; each further one is a cut.
//! Two faces: 1 or 2. The four faces of a double-sided object: 2 where neither sheet is cut, so that two
//! sheets are no seam by themselves.

use rayon::prelude::*;

use super::Measured;
use crate::contract::{Cancel, Canceled};
use crate::mesh::{NONE, Surface};
use crate::tasks;

/// Coordinates that differ by less at one position are the same.
const SAME_UV: f32 = 1e-6;
/// Different UV edges that are compared at one edge; an edge of thousands of faces must not cost
/// their square.
const COMPARED: usize = 64;

/// Every edge of the faces that have coordinates, sorted by its ends.
#[derive(Debug, Clone, Default)]
pub struct EdgeTable {
    /// Two positions each (any vertex of the surface that stands there), the lower number first.
    pub ends: Vec<[u32; 2]>,
    /// Length in 3D, world units.
    pub length: Vec<f64>,
    /// How often it is cut.
    pub cuts: Vec<u32>,
    /// Whether part labels differ across it.
    pub boundary: Vec<bool>,
    /// Where each edge's half-edges start in `half_edges`; one more at the end.
    starts: Vec<u32>,
    half_edges: Vec<u32>,
    /// Which of the edge's different UV edges each half-edge is, as `half_edges`.
    uv_edge: Vec<u32>,
    /// Whether no other face of its chart shares its UV edge, as `half_edges`.
    rim: Vec<bool>,
}

impl EdgeTable {
    /// Collects the edges of the faces for which `measured` holds.
    pub fn new(
        input: &Measured,
        measured: impl Fn(u32) -> bool,
        cancel: &Cancel,
    ) -> Result<Self, Canceled> {
        let surface = input.surface;
        let place = places(surface);
        let mut records: Vec<(u32, u32, u32)> = (0..3 * surface.face_count() as u32)
            .filter(|&h| measured(h / 3))
            .filter_map(|h| {
                let (a, b) = (place[surface.from(h) as usize], place[surface.to(h) as usize]);
                (a != b).then(|| (a.min(b), a.max(b), h))
            })
            .collect();
        cancel.check()?;
        tasks::even("edges", records.len(), || records.par_sort_unstable());
        cancel.check()?;
        let mut table = Self { starts: vec![0], ..Self::default() };
        for group in records.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
            table.push(input, &place, group);
        }
        cancel.check()?;
        Ok(table)
    }

    /// Number of edges.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there is no edge.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The half-edges of edge `e`, and which of its different UV edges each one is.
    pub fn half_edges(&self, e: usize) -> impl Iterator<Item = (u32, u32)> + Clone {
        let range = self.starts[e] as usize..self.starts[e + 1] as usize;
        range.map(|i| (self.half_edges[i], self.uv_edge[i]))
    }

    /// Every half-edge of every edge.
    pub fn all_half_edges(&self) -> &[u32] {
        &self.half_edges
    }

    /// The half-edges of edge `e` on the rim of their chart.
    pub fn rim(&self, e: usize) -> impl Iterator<Item = u32> {
        let range = self.starts[e] as usize..self.starts[e + 1] as usize;
        range.filter(|&i| self.rim[i]).map(|i| self.half_edges[i])
    }

    /// Pairs of half-edges of edge `e` that continue one another in 3D but not in UV.
    pub fn cut_pairs(&self, e: usize, surface: &Surface) -> impl Iterator<Item = (u32, u32)> {
        let range = self.starts[e] as usize..self.starts[e + 1] as usize;
        // Ascending within an edge.
        let (around, uv_edge) = (&self.half_edges[range.clone()], &self.uv_edge[range]);
        around.iter().zip(uv_edge).filter_map(|(&h, own)| {
            let t = surface.twin[h as usize];
            let other = around.binary_search(&t).ok()?;
            (h < t && *own != uv_edge[other]).then_some((h, t))
        })
    }

    fn push(&mut self, input: &Measured, place: &[u32], group: &[(u32, u32, u32)]) {
        let Some(&(a, b, first)) = group.first() else { return };
        let surface = input.surface;
        let mut different: Vec<[[f32; 2]; 2]> = Vec::with_capacity(2);
        for &(_, _, h) in group {
            let (f, k) = (h as usize / 3, h as usize % 3);
            let mut ends = [input.uvs[f][k], input.uvs[f][(k + 1) % 3]];
            if place[surface.from(h) as usize] != a {
                ends.swap(0, 1);
            }
            let known = different.iter().take(COMPARED).position(|d| same(d, &ends));
            let c = known.unwrap_or_else(|| {
                different.push(ends);
                different.len() - 1
            });
            self.half_edges.push(h);
            self.uv_edge.push(c as u32);
        }
        let start = self.starts.last().copied().unwrap_or(0) as usize;
        let chart = |i: usize| input.chart_of[self.half_edges[i] as usize / 3];
        let key = |i: usize| (self.uv_edge[i], chart(i));
        let range = start..self.half_edges.len();
        // Compared with at most COMPARED others, for the same reason as above.
        let alone = |i: usize| !range.clone().take(COMPARED).any(|j| j != i && key(j) == key(i));
        let rim: Vec<bool> = range.clone().map(alone).collect();
        self.rim.extend(rim);
        self.ends.push([a, b]);
        self.length.push(surface.length(first));
        let needed = group.len().div_ceil(2);
        self.cuts.push(different.len().saturating_sub(needed) as u32);
        self.boundary.push(is_boundary(input, group));
        self.starts.push(self.half_edges.len() as u32);
    }
}

/// Whether part labels differ at an edge. With given labels, between any two of its faces (−1 is no
/// label); without, between those of two twins, since the two sheets of a double-sided object may be two
/// parts.
fn is_boundary(input: &Measured, group: &[(u32, u32, u32)]) -> bool {
    if let Some(labels) = input.boundary_labels {
        let mut known = group.iter().map(|&(_, _, h)| labels[h as usize / 3]).filter(|&l| l >= 0);
        return known.next().is_some_and(|first| known.any(|l| l != first));
    }
    group.iter().any(|&(_, _, h)| {
        let t = input.surface.twin[h as usize];
        t != NONE && {
            let (p, q) = (input.part_of[h as usize / 3], input.part_of[t as usize / 3]);
            p != q && p != NONE && q != NONE
        }
    })
}

/// Whether two UV edges of one edge coincide.
pub(super) fn same(a: &[[f32; 2]; 2], b: &[[f32; 2]; 2]) -> bool {
    a.iter().flatten().zip(b.iter().flatten()).all(|(x, y)| (x - y).abs() <= SAME_UV)
}

/// For each vertex the lowest-numbered vertex at its position.
pub fn places(surface: &Surface) -> Vec<u32> {
    // Adding zero makes −0 and 0 one place.
    let key = |&v: &u32| (surface.positions[v as usize] + 0.0).to_array().map(f64::to_bits);
    let mut order: Vec<u32> = (0..surface.positions.len() as u32).collect();
    tasks::even("places", order.len(), || order.par_sort_unstable_by_key(|v| (key(v), *v)));
    let mut place = vec![0; order.len()];
    for group in order.chunk_by(|a, b| key(a) == key(b)) {
        for &v in group {
            place[v as usize] = group[0];
        }
    }
    place
}
