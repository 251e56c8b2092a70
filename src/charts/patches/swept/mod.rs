//! Tubes along a curve (docs/method.md, 4.2): springs, hoses, rings, knots. A section's course from end to end
//! is a harmonic function; a tube is cut along one line, the cheapest way from end to end, and across where a
//! page is too short for it. What a strip so made cannot be flattened for, being bent too much, is cut along two
//! lines: beside the bend, so that its outside and its inside are straight strips, or on it, which makes two
//! curved ones.

mod course;
mod ends;
mod net;
#[cfg(test)]
mod tests;

use std::collections::BTreeSet;

use super::sides::Side;
use crate::charts::limits::ChartLimits;
use crate::charts::limits::cost::edge_cost;
use crate::charts::limits::fit::from_scratch;
use crate::charts::part_mesh::PartMesh;
use crate::charts::patchwork::next;
use crate::contract::{Canceled, Run};
use crate::flatten;
use crate::mesh::NONE;
use course::Course;
use ends::{Ended, with_two_ends};
use net::Net;

/// Fewest faces that show a tube's course.
const LEAST: usize = 64;

/// Steps across a line's way, or along it where it is to run across, cost so many times more.
const ASIDE: f64 = 2.0;

/// How far a line strays at twice the cost: a cut across, in girths; one along, in turns.
const STRAY: f64 = 0.25;
const STRAY_TURNS: f64 = 0.06;

/// The strips that a component is cut into, if it is a tube along a curve; those that cannot be flattened
/// within the bound are left out.
pub fn swept(mesh: &PartMesh, limits: &ChartLimits, run: &Run) -> Result<Vec<Side>, Canceled> {
    if mesh.len() < LEAST {
        return Ok(Vec::new());
    }
    let Some(ended) = with_two_ends(mesh) else { return Ok(Vec::new()) };
    let Some(tube) = SweptTube::new(ended) else { return Ok(Vec::new()) };
    let Some(long) = tube.long_cut() else { return Ok(Vec::new()) };
    let cuts = tube.cross_cuts(&long, limits.length);
    let across: BTreeSet<u32> = both_sides(mesh, cuts.iter().flatten());
    let across = &across | &tube.ended.cut;
    let long_sides = both_sides(mesh, &long);
    let inside = |h: u32| !long_sides.contains(&h) && !across.contains(&h);
    let mut sides = Vec::new();
    for faces in mesh.components(&tube.ended.net.piece.faces, inside) {
        run.cancel.check()?;
        let (long, long_sides, across) = (&long, &long_sides, &across);
        let strip = Strip { tube: &tube, long, long_sides, across, faces };
        sides.extend(strip.sides(limits, run)?);
    }
    Ok(sides)
}

/// Half-edges and their twins.
fn both_sides<'h>(mesh: &PartMesh, half_edges: impl IntoIterator<Item = &'h u32>) -> BTreeSet<u32> {
    half_edges.into_iter().flat_map(|&h| [h, mesh.twin[h as usize]]).collect()
}

/// A tube with its course.
struct SweptTube<'a> {
    ended: Ended<'a>,
    course: Course,
    /// Way along the course of each corner of the part; 0 where it is none of the tube's.
    along: Vec<f64>,
    /// Length times cost of each of its half-edges, and the share of it that runs along the course.
    edges: Vec<(f64, f64)>,
}

impl<'a> SweptTube<'a> {
    fn new(ended: Ended<'a>) -> Option<Self> {
        let net = &ended.net;
        let [first, last] = &net.border.loops[..] else { return None };
        let first = first.iter().map(|&v| (v, 0.0));
        let function = net.harmonic(first.chain(last.iter().map(|&v| (v, 1.0))))?;
        let course = Course::new(net, function)?;
        if !course.is_slender() {
            return None;
        }
        let mesh = net.mesh;
        let mut along = vec![0.0; mesh.twin.len()];
        let mut edges = vec![(f64::INFINITY, 0.0); mesh.twin.len()];
        for (&f, t) in net.piece.faces.iter().zip(&net.piece.disk.triangles) {
            for k in 0..3 {
                let h = 3 * f + k as u32;
                let [v, w] = [t[k], t[(k + 1) % 3]];
                let [from, to] = [v, w].map(|v| course.along[v as usize]);
                let way = (net.position(w) - net.position(v)).normalize_or_zero();
                let tangent = course.tangent(0.5 * (from + to));
                along[h as usize] = from;
                edges[h as usize] = (edge_cost(mesh, h), way.dot(tangent).abs());
            }
        }
        Some(Self { ended, course, along, edges })
    }

    /// Way along the course of an edge's middle.
    fn along(&self, h: u32) -> f64 {
        0.5 * (self.along[h as usize] + self.along[next(h) as usize])
    }

    /// The cheapest way from end to end, as half-edges on one side.
    fn long_cut(&self) -> Option<Vec<u32>> {
        let net = &self.ended.net;
        let [first, last] = &net.border.loops[..] else { return None };
        let ways = net.ways(first, last, |h, _| {
            let (cost, along) = self.edges[h as usize];
            cost * (1.0 + ASIDE * (1.0 - along))
        });
        let way = ways.to(ways.reached?);
        (!way.is_empty()).then_some(way)
    }

    /// Cuts from one side of the long cut to the other, so that no piece is longer than `most`.
    fn cross_cuts(&self, long: &[u32], most: f64) -> Vec<Vec<u32>> {
        let (net, mesh) = (&self.ended.net, self.ended.net.mesh);
        let count = (self.course.length / most).ceil().max(1.0);
        let cut = &both_sides(mesh, long) | &self.ended.cut;
        let open = Net::new(mesh, net.piece.faces.clone(), |h| !cut.contains(&h));
        let [left, right] = banks(&open, long);
        let mut cuts = Vec::new();
        for k in 1..count as usize {
            let at = self.course.length * k as f64 / count;
            let ways = open.ways(&left, &right, |h, _| {
                let (cost, along) = self.edges[h as usize];
                let stray = (self.along(h) - at) / (STRAY * self.course.girth);
                cost * (1.0 + ASIDE * along) * (1.0 + stray * stray)
            });
            cuts.extend(ways.reached.map(|v| ways.to(v)));
        }
        cuts
    }
}

/// Vertices on both sides of a cut (half-edges on one of its sides) in a net that is open there.
fn banks(open: &Net, cut: &[u32]) -> [Vec<u32>; 2] {
    let of = |h: u32| [open.from(h), open.to(h)].into_iter().flatten();
    let left = cut.iter().flat_map(|&h| of(h)).collect();
    let right = cut.iter().flat_map(|&h| of(open.mesh.twin[h as usize])).collect();
    [left, right]
}

/// A piece of a tube between two cuts across.
struct Strip<'t, 'a> {
    tube: &'t SweptTube<'a>,
    /// Half-edges of the long cut, on one of its sides …
    long: &'t [u32],
    /// … and on both.
    long_sides: &'t BTreeSet<u32>,
    /// Half-edges of the cuts across, on both sides.
    across: &'t BTreeSet<u32>,
    faces: Vec<u32>,
}

impl Strip<'_, '_> {
    /// The strip in as few pieces as can be flattened within the bound; none if it cannot.
    fn sides(&self, limits: &ChartLimits, run: &Run) -> Result<Vec<Side>, Canceled> {
        let mesh = self.tube.ended.net.mesh;
        if let Some(sides) = self.pieces(self.long_sides, limits, run)? {
            return Ok(sides);
        }
        let Some(open) = self.opened() else { return Ok(Vec::new()) };
        if let (Some(a), Some(b)) = (self.line(&open, 0.25), self.line(&open, 0.75)) {
            let beside = both_sides(mesh, a.iter().chain(&b));
            if let Some(sides) = self.pieces(&beside, limits, run)? {
                return Ok(sides);
            }
        }
        if let Some(middle) = self.line(&open, 0.5) {
            let on = self.long_sides | &both_sides(mesh, &middle);
            if let Some(sides) = self.pieces(&on, limits, run)? {
                return Ok(sides);
            }
        }
        Ok(Vec::new())
    }

    /// The pieces that some cuts along leave, each with its map; `None` if one has none.
    fn pieces(
        &self,
        cuts: &BTreeSet<u32>,
        limits: &ChartLimits,
        run: &Run,
    ) -> Result<Option<Vec<Side>>, Canceled> {
        let mesh = self.tube.ended.net.mesh;
        let closed = |h: u32| {
            mesh.twin[h as usize] != NONE && !cuts.contains(&h) && !self.across.contains(&h)
        };
        let mut sides = Vec::new();
        for faces in mesh.components(&self.faces, closed) {
            let piece = mesh.cut_open_where(faces, closed);
            if !flatten::is_disk(&piece.disk) {
                return Ok(None);
            }
            let fit = from_scratch(&piece.disk, limits.bound, limits, run)?;
            let Some(fit) = fit else { return Ok(None) };
            let own = |f: u32| piece.faces.binary_search(&f).is_ok();
            let within = |h: &u32| {
                let t = mesh.twin[*h as usize];
                t != NONE && own(t / 3) && !closed(*h)
            };
            let cut = piece.faces.iter().flat_map(|&f| 3 * f..3 * f + 3).filter(within).collect();
            sides.push(Side { faces: piece.faces, cut, fit });
        }
        Ok(Some(sides))
    }

    /// The strip, open at its long cut, and how far round the section each vertex is: 0 on one side of the
    /// cut to 1 on the other.
    fn opened(&self) -> Option<(Net<'_>, Vec<f64>)> {
        let mesh = self.tube.ended.net.mesh;
        let open = Net::new(mesh, self.faces.clone(), |h| {
            !self.long_sides.contains(&h) && !self.across.contains(&h)
        });
        let [left, right] = banks(&open, self.long);
        let given = left.iter().map(|&v| (v, 0.0)).chain(right.iter().map(|&v| (v, 1.0)));
        let turn = open.harmonic(given)?;
        Some((open, turn))
    }

    /// A line from end to end of the strip at a share of a turn.
    fn line(&self, (open, turn): &(Net, Vec<f64>), at: f64) -> Option<Vec<u32>> {
        let [rim] = &open.border.loops[..] else { return None };
        let along = |v: u32| self.tube.along[open.corner[v as usize] as usize];
        let (low, high) = rim.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &v| {
            (low.min(along(v)), high.max(along(v)))
        });
        // The long cut's own ends are none.
        let ends = |first: bool| -> Vec<u32> {
            let beside = |v: u32| turn[v as usize] > 0.0 && turn[v as usize] < 1.0;
            let here = |v: u32| (along(v) < 0.5 * (low + high)) == first;
            rim.iter().copied().filter(|&v| beside(v) && here(v)).collect()
        };
        let ways = open.ways(&ends(true), &ends(false), |h, [v, w]| {
            let (cost, along) = self.tube.edges[h as usize];
            let stray = (0.5 * (turn[v as usize] + turn[w as usize]) - at) / STRAY_TURNS;
            cost * (1.0 + ASIDE * (1.0 - along)) * (1.0 + stray * stray)
        });
        ways.reached.map(|v| ways.to(v))
    }
}
