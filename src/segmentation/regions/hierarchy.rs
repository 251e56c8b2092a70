//! Agglomeration: the two neighbours between which a part is least likely to end are joined, again and
//! again, until all that touch are one. The joins in their order are a hierarchy: cut at a
//! probability, it gives parts.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::features::{FEATURES, features};
use super::graph::RegionGraph;
use crate::contract::{Canceled, Run};
use crate::mesh::DisjointSets;

/// One join.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Join {
    /// The region that goes on.
    pub keep: u32,
    /// The region that is gone.
    pub gone: u32,
    /// How likely a part ended between them.
    pub boundary: f64,
}

/// The joins of an object, in order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Hierarchy {
    /// Initial regions at the bottom.
    pub patches: usize,
    /// Joins; a later one may be more certain than an earlier one.
    pub joins: Vec<Join>,
}

/// Waiting pairs; the least boundary comes first out of the heap.
#[derive(PartialEq)]
struct Pair {
    boundary: f64,
    regions: (u32, u32),
}

impl Eq for Pair {}

impl Ord for Pair {
    fn cmp(&self, other: &Self) -> Ordering {
        let by = other.boundary.total_cmp(&self.boundary);
        by.then_with(|| other.regions.cmp(&self.regions))
    }
}

impl PartialOrd for Pair {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Says how likely a part ends between two regions, from their features.
pub type Boundary<'a> = dyn Fn(&[f32; FEATURES]) -> f64 + 'a;

/// Join everything that touches and whose boundary is no likelier than `until`. `allowed` is asked
/// before every join, with its features.
pub fn agglomerate(
    graph: &mut RegionGraph,
    boundary: &Boundary,
    until: f64,
    run: &Run,
    mut allowed: impl FnMut(&RegionGraph, u32, u32, &[f32; FEATURES]) -> bool,
) -> Result<Hierarchy, Canceled> {
    let patches = graph.regions.len();
    let pair_of = |graph: &RegionGraph, a: u32, b: u32| -> Option<(f64, [f32; FEATURES])> {
        let border = graph.borders[a as usize].get(&b)?;
        let (r, s) = (graph.region(a)?, graph.region(b)?);
        let x = features(graph, r, s, border);
        Some((boundary(&x), x))
    };
    let mut heap = BinaryHeap::new();
    for a in 0..patches as u32 {
        for (&b, _) in graph.borders[a as usize].range(a + 1..) {
            heap.extend(pair_of(graph, a, b).map(|j| Pair { boundary: j.0, regions: (a, b) }));
        }
    }
    let mut hierarchy = Hierarchy { patches, joins: Vec::new() };
    let mut steps = 0u32;
    while let Some(Pair { boundary: before, regions: (a, b) }) = heap.pop() {
        steps += 1;
        if steps.is_multiple_of(2048) {
            run.cancel.check()?;
        }
        if before > until {
            break;
        }
        let Some((now, x)) = pair_of(graph, a, b) else { continue };
        // Either has grown since: its turn comes later.
        if now > before + 1e-9 {
            heap.push(Pair { boundary: now, regions: (a, b) });
            continue;
        }
        if !allowed(graph, a, b, &x) {
            continue;
        }
        let more = graph.borders[a as usize].len() >= graph.borders[b as usize].len();
        let (keep, gone) = if more { (a, b) } else { (b, a) };
        hierarchy.joins.push(Join { keep, gone, boundary: now });
        for n in graph.join(keep, gone) {
            let pair = (keep.min(n), keep.max(n));
            heap.extend(
                pair_of(graph, pair.0, pair.1).map(|j| Pair { boundary: j.0, regions: pair }),
            );
        }
    }
    Ok(hierarchy)
}

impl Hierarchy {
    /// Region of each patch when joins above `most` are undone, numbered in order of first patch.
    pub fn cut(&self, most: f64) -> Vec<u32> {
        groups(self.patches, self.joins.iter().map(|j| (j.keep, j.gone, j.boundary)), most)
    }
}

/// Group of each of `count` things when joins (two of them, and how likely a boundary is between) above
/// `most` are undone, numbered in order of first member.
pub fn groups(count: usize, joins: impl Iterator<Item = (u32, u32, f64)>, most: f64) -> Vec<u32> {
    let mut sets = DisjointSets::new(count);
    // A join stands on those below it: above the first that is too bold, none holds for its side.
    let mut torn = vec![false; count];
    for (a, b, boundary) in joins {
        let (a, b) = (sets.root(a), sets.root(b));
        if boundary > most || torn[a as usize] || torn[b as usize] {
            torn[a as usize] = true;
            torn[b as usize] = true;
        } else {
            sets.join(a, b);
        }
    }
    let mut number = vec![u32::MAX; count];
    let mut next = 0;
    (0..count as u32)
        .map(|i| {
            let root = sets.root(i) as usize;
            if number[root] == u32::MAX {
                number[root] = next;
                next += 1;
            }
            number[root]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn join(keep: u32, gone: u32, boundary: f64) -> Join {
        Join { keep, gone, boundary }
    }

    #[test]
    fn a_deeper_cut_only_divides() {
        let joins = vec![join(0, 1, 0.1), join(2, 3, 0.2), join(0, 2, 0.6), join(0, 4, 0.9)];
        let tree = Hierarchy { patches: 5, joins };
        assert_eq!(tree.cut(1.0), [0, 0, 0, 0, 0]);
        assert_eq!(tree.cut(0.7), [0, 0, 0, 0, 1]);
        assert_eq!(tree.cut(0.5), [0, 0, 1, 1, 2]);
        assert_eq!(tree.cut(0.0), [0, 1, 2, 3, 4]);
    }
}
