//! The edges of a triangle mesh, and an order of elimination of its vertices that fills in little: what systems on
//! one mesh have in common, found once.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;

use super::FlattenError;

/// A corner whose vertex is no unknown.
pub(super) const PINNED: u32 = u32::MAX;

/// The pattern of systems on a mesh.
#[derive(Debug, Clone)]
pub struct Pattern {
    /// Pairs of unknowns, the lower first, ascending.
    pub(super) edges: Vec<(u32, u32)>,
    /// The edges from each unknown to higher ones: those of `v` are `starts[v]..starts[v + 1]`.
    pub(super) starts: Vec<u32>,
    /// For edge k (corner k to k + 1) of each triangle its place in `edges`; [`PINNED`] where it joins no two
    /// unknowns.
    pub(super) edge_of: Vec<[u32; 3]>,
    /// The unknowns in the order in which they are eliminated (approximate minimum degree).
    pub(super) order: Vec<u32>,
    /// Unknowns.
    pub(super) unknowns: usize,
}

impl Pattern {
    /// Of `unknowns` vertices joined by triangles, whose corners are unknowns or [`PINNED`].
    pub(super) fn of(unknowns: usize, triangles: &[[u32; 3]]) -> Result<Self, FlattenError> {
        let mut sides: Vec<((u32, u32), u32)> = Vec::with_capacity(3 * triangles.len());
        for (h, (a, b)) in
            (0u32..).zip(triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]))
        {
            if a != b && a != PINNED && b != PINNED {
                sides.push(((a.min(b), a.max(b)), h));
            }
        }
        sides.sort_unstable();
        let mut edges: Vec<(u32, u32)> = Vec::with_capacity(sides.len() / 2 + 1);
        let mut edge_of = vec![[PINNED; 3]; triangles.len()];
        for (edge, h) in sides {
            if edges.last() != Some(&edge) {
                edges.push(edge);
            }
            edge_of[h as usize / 3][h as usize % 3] = edges.len() as u32 - 1;
        }
        let mut starts = vec![0; unknowns + 1];
        edges.iter().for_each(|e| starts[e.0 as usize + 1] += 1);
        for v in 0..unknowns {
            starts[v + 1] += starts[v];
        }
        let order = order(&starts, &edges)?;
        Ok(Self { edges, starts, edge_of, order, unknowns })
    }

    /// The order for so many unknowns a vertex, which stay together, and its inverse.
    pub(super) fn permutation(&self, each: u32) -> (Vec<u32>, Vec<u32>) {
        let all = |&v: &u32| (0..each).map(move |k| each * v + k);
        let order: Vec<u32> = self.order.iter().flat_map(all).collect();
        let mut inverse = vec![0; order.len()];
        (0u32..).zip(&order).for_each(|(place, &v)| inverse[v as usize] = place);
        (order, inverse)
    }
}

/// An order of elimination that fills in little (approximate minimum degree). `edges`: pairs, lower first, sorted;
/// `columns`: where those of each vertex start.
fn order(columns: &[u32], edges: &[(u32, u32)]) -> Result<Vec<u32>, FlattenError> {
    let vertices = columns.len() - 1;
    let rows: Vec<u32> = edges.iter().map(|e| e.1).collect();
    let graph = SymbolicSparseColMatRef::new_checked(vertices, vertices, columns, None, &rows);
    let (mut order, mut inverse) = (vec![0; vertices], vec![0; vertices]);
    let request = amd::order_maybe_unsorted_scratch::<u32>(vertices, edges.len());
    let mut memory = MemBuffer::new(request);
    let stack = MemStack::new(&mut memory);
    amd::order_maybe_unsorted(&mut order, &mut inverse, graph, Default::default(), stack)
        .map_err(|_| FlattenError::Singular)?;
    Ok(order)
}
