//! A connected component made a ring of sections with two ends: an open tube is one; a ring is cut along its
//! shorter generator (greedy tree and cotree: Erickson & Whittlesey 2005, "Greedy optimal homotopy and
//! homology generators"); what is closed, at one end or both, loses its caps.

use std::collections::{BTreeMap, BTreeSet};

use super::both_sides;
use super::course::Course;
use super::net::Net;
use crate::charts::part_mesh::PartMesh;
use crate::mesh::{DisjointSets, NONE};

/// A cap's faces look along the course: at least so much of their normal does.
const CAP: f64 = 0.7;

/// Girths from a tip to where the course runs straight.
const END: f64 = 0.75;

/// A component that is a tube along a curve: its net with two ends, which of its edges were cut for that.
pub struct Ended<'a> {
    /// Two borders, Euler characteristic 0.
    pub net: Net<'a>,
    /// Half-edges, on both sides, at which a ring was cut.
    pub cut: BTreeSet<u32>,
}

/// Two ends for a component, if it is a sphere, a disk, a tube or a ring and slender.
pub fn with_two_ends<'a>(mesh: &'a PartMesh<'a>) -> Option<Ended<'a>> {
    let all: Vec<u32> = (0..mesh.len() as u32).collect();
    let net = Net::new(mesh, all, |_| true);
    if net.is(2, 0) {
        return Some(Ended { net, cut: BTreeSet::new() });
    }
    if net.is(0, 0) {
        let cut = generator(&net)?;
        let faces = net.piece.faces.clone();
        let net = Net::new(mesh, faces, |h| !cut.contains(&h));
        return net.is(2, 0).then_some(Ended { net, cut });
    }
    if net.is(0, 2) || net.is(1, 1) {
        return without_caps(&net).map(|net| Ended { net, cut: BTreeSet::new() });
    }
    None
}

/// The shorter of two loops that cut a ring open, through the vertex that is farthest from the first.
fn generator(net: &Net) -> Option<BTreeSet<u32>> {
    let base = farthest(net, &[0])?;
    let ways = net.ways(&[base], &[], |h, _| net.mesh.length(h));
    let mesh = net.mesh;
    let lowest = |h: u32| h.min(mesh.twin[h as usize]);
    let tree: BTreeSet<u32> =
        (0..net.len() as u32).filter_map(|v| ways.by(v)).map(lowest).collect();
    // Loops over one edge beside the tree, the longest first: a spanning tree of the faces closes all but two.
    let mut loops: Vec<(f64, u32)> = Vec::new();
    for h in net.piece.faces.iter().flat_map(|&f| 3 * f..3 * f + 3) {
        if lowest(h) == h && !tree.contains(&h) {
            let (a, b) = (net.from(h)?, net.to(h)?);
            loops.push((ways.cost[a as usize] + ways.cost[b as usize] + mesh.length(h), h));
        }
    }
    loops.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut faces = DisjointSets::new(mesh.len());
    let generators: Vec<u32> = loops
        .into_iter()
        .filter(|&(_, h)| {
            let (f, g) = (h / 3, mesh.twin[h as usize] / 3);
            let apart = faces.root(f) != faces.root(g);
            faces.join(f, g);
            !apart
        })
        .map(|(_, h)| h)
        .collect();
    let &shortest = generators.last()?;
    // Edges that both ways have in common are no part of the loop.
    let mut edges: BTreeMap<u32, u32> = BTreeMap::from([(shortest, 1)]);
    for v in [net.from(shortest)?, net.to(shortest)?] {
        ways.to(v).into_iter().for_each(|h| *edges.entry(lowest(h)).or_default() += 1);
    }
    let once = edges.iter().filter(|(_, count)| **count == 1).map(|(h, _)| h);
    Some(both_sides(mesh, once))
}

/// The vertex that is farthest from some others.
fn farthest(net: &Net, from: &[u32]) -> Option<u32> {
    let ways = net.ways(from, &[], |h, _| net.mesh.length(h));
    (0..net.len() as u32)
        .filter(|&v| ways.cost[v as usize].is_finite())
        .max_by(|&v, &w| ways.cost[v as usize].total_cmp(&ways.cost[w as usize]).then(w.cmp(&v)))
}

/// A sphere, or a disk, without what lies across its course at its tips.
fn without_caps<'a>(net: &Net<'a>) -> Option<Net<'a>> {
    let first = match &net.border.loops[..] {
        [rim] => rim.clone(),
        _ => vec![farthest(net, &[0])?],
    };
    let last = farthest(net, &first)?;
    let along = net.harmonic(first.iter().map(|&v| (v, 0.0)).chain([(last, 1.0)]))?;
    let course = Course::new(net, along)?;
    if !course.is_slender() {
        return None;
    }
    let mesh = net.mesh;
    // The first and the last sections lie askew about the tips.
    let (from, to) = (END * course.girth, course.length - END * course.girth);
    let tangent = |face: usize| course.tangent(course.of_face(net, face).clamp(from, to));
    let across: Vec<u32> = (0..)
        .zip(&net.piece.faces)
        .filter(|&(i, &f)| mesh.normal(f as usize).dot(tangent(i)).abs() > CAP)
        .map(|(_, &f)| f)
        .collect();
    let tips: &[u32] = if net.border.loops.is_empty() { &[first[0], last] } else { &[last] };
    let mut caps = vec![false; mesh.len()];
    for cap in mesh.components(&across, |_| true) {
        let at_tip = cap.iter().flat_map(|&f| 3 * f..3 * f + 3);
        if at_tip.filter_map(|h| net.from(h)).any(|v| tips.contains(&v)) {
            cap.iter().for_each(|&f| caps[f as usize] = true);
        }
    }
    let side: Vec<u32> = net.piece.faces.iter().copied().filter(|&f| !caps[f as usize]).collect();
    let inside = |h: u32| mesh.twin[h as usize] != NONE;
    let pieces = mesh.components(&side, inside);
    let side = pieces.into_iter().max_by_key(Vec::len)?;
    let net = Net::new(mesh, side, |_| true);
    net.is(2, 0).then_some(net)
}
