//! One label a face: the votes of its points, weighted by the area they stand for, and a graph cut
//! over the dual graph by α-expansion (Boykov, Veksler & Zabih 2001, doi:10.1109/34.969114). Faces
//! whose label is certain only bound the problem; the others fall into islands, each with the few
//! labels that stand in it or around it, so that many labels cost little.

use std::collections::{BTreeSet, VecDeque};

use super::dual::DualGraph;
use super::error::SegmentationError;

use super::scores::PartScores;
use super::votes::Votes;
use crate::contract::{Canceled, Run};
use crate::mesh::{Flow, Surface};
use crate::sampling::PointCloud;

/// Weight of a boundary against the votes.
const SMOOTH: f64 = 1.5;

/// Passes over the labels of an island; a pass that changes nothing is the last.
const PASSES: usize = 4;

/// An island with more faces × labels than this keeps its votes uncut.
const MOST: usize = 4_000_000;

/// No label yet.
const UNKNOWN: i32 = -1;

/// Not in the island at hand.
const OUTSIDE: u32 = u32::MAX;

/// Label of each face: an index into the candidates; −1 for
/// connected components of which the source says nothing.
pub fn decide(
    surface: &Surface,
    cloud: &PointCloud,
    dual: &DualGraph,
    scores: &PartScores,
    run: &Run,
) -> Result<Vec<i32>, SegmentationError> {
    let open: Vec<bool> = scores.fixed.iter().map(|&label| label == UNKNOWN).collect();
    let mut label = scores.fixed.clone();
    if open.iter().any(|&o| o) {
        let votes = Votes::count(surface, cloud, scores);
        (0..dual.len()).filter(|&f| open[f]).for_each(|f| label[f] = votes.winner(f));
        spread(dual, &mut label);
        let mut place = vec![OUTSIDE; dual.len()];
        for island in islands(dual, &open) {
            run.cancel.check()?;
            (0u32..).zip(&island).for_each(|(i, &f)| place[f as usize] = i);
            settle(dual, &votes, &island, &place, &mut label, run)?;
            island.iter().for_each(|&f| place[f as usize] = OUTSIDE);
        }
    }
    Ok(label)
}

/// Faces without a label take that of the nearest face that has one.
fn spread(dual: &DualGraph, label: &mut [i32]) {
    let mut queue: VecDeque<u32> =
        (0..dual.len() as u32).filter(|&f| label[f as usize] != UNKNOWN).collect();
    while let Some(f) = queue.pop_front() {
        for &(g, _) in dual.links(f) {
            if label[g as usize] == UNKNOWN {
                label[g as usize] = label[f as usize];
                queue.push_back(g);
            }
        }
    }
}

/// Connected sets of open faces, each ascending.
fn islands(dual: &DualGraph, open: &[bool]) -> Vec<Vec<u32>> {
    let mut seen = vec![false; open.len()];
    let mut islands = Vec::new();
    for seed in 0..open.len() {
        if !open[seed] || seen[seed] {
            continue;
        }
        seen[seed] = true;
        let (mut island, mut next) = (vec![seed as u32], 0);
        while next < island.len() {
            for &(g, _) in dual.links(island[next]) {
                if open[g as usize] && !std::mem::replace(&mut seen[g as usize], true) {
                    island.push(g);
                }
            }
            next += 1;
        }
        island.sort_unstable();
        islands.push(island);
    }
    islands
}

/// Expand every label of an island in turn until nothing changes.
fn settle(
    dual: &DualGraph,
    votes: &Votes,
    island: &[u32],
    place: &[u32],
    label: &mut [i32],
    run: &Run,
) -> Result<(), Canceled> {
    let around = island.iter().flat_map(|&f| dual.links(f)).map(|&(g, _)| label[g as usize]);
    let own = island.iter().map(|&f| label[f as usize]);
    let labels: BTreeSet<i32> = own.chain(around).filter(|&l| l != UNKNOWN).collect();
    if labels.len() < 2 || island.len() * labels.len() > MOST {
        return Ok(());
    }
    for _ in 0..PASSES {
        let mut changed = false;
        for &alpha in &labels {
            run.cancel.check()?;
            changed |= expand(dual, votes, island, place, alpha, label);
        }
        if !changed {
            break;
        }
    }
    Ok(())
}

/// Let the faces of an island take the label `alpha` where that lowers the energy. Tells whether
/// any did.
fn expand(
    dual: &DualGraph,
    votes: &Votes,
    island: &[u32],
    place: &[u32],
    alpha: i32,
    label: &mut [i32],
) -> bool {
    let n = island.len();
    let (source, sink) = (n, n + 1);
    let mut flow = Flow::new(n + 2);
    // On the source's side a face takes alpha, on the sink's it keeps what it has.
    for (i, &f) in island.iter().enumerate() {
        let own = label[f as usize];
        if own == alpha {
            continue;
        }
        let mut take = votes.cost(f as usize, alpha);
        let mut keep = votes.cost(f as usize, own);
        for &(g, w) in dual.links(f) {
            let theirs = label[g as usize];
            let w = SMOOTH * w;
            if place[g as usize] == OUTSIDE || theirs == alpha {
                take += if theirs == alpha { 0.0 } else { w };
                keep += if theirs == own { 0.0 } else { w };
            } else if f < g {
                // E(keep, keep) = w·[own ≠ theirs], E(take, take) = 0, one of each = w: half of
                // the first is paid by each face for keeping, the rest between them.
                let (j, both) = (place[g as usize] as usize, if own == theirs { 0.0 } else { w });
                flow.edge(i, j, w - both / 2.0, w - both / 2.0);
                if both > 0.0 {
                    flow.edge(source, i, both / 2.0, 0.0);
                    flow.edge(source, j, both / 2.0, 0.0);
                }
            }
        }
        flow.edge(i, sink, take, 0.0);
        flow.edge(source, i, keep, 0.0);
    }
    let takes = flow.source_side(source, sink);
    let mut changed = false;
    for (&f, _) in island.iter().zip(takes).filter(|(_, takes)| *takes) {
        changed |= label[f as usize] != alpha;
        label[f as usize] = alpha;
    }
    changed
}
