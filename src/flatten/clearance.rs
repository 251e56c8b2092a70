//! Whether a chart's border keeps clear of itself. A border that touches itself but for the last bits
//! of its coordinates is simple, and is so no more when the coordinates are rounded.

use glam::DVec2;

use super::sweep::Sweep;
use super::{Border, segments_meet};

/// Edges nearer to each other along the border than this many clearances may be near in the plane.
const ALONG: f64 = 4.0;

/// An edge of a border.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edge {
    /// Vertices of the disk.
    pub vertices: [u32; 2],
    ends: [DVec2; 2],
    ring: usize,
    /// Where it starts along its ring.
    start: f64,
}

/// The edges of a border where they lie.
struct Edges {
    edges: Vec<Edge>,
    /// Length of each ring.
    around: Vec<f64>,
}

impl Edges {
    fn new(border: &Border, uv: &[DVec2]) -> Self {
        let (mut edges, mut around) = (Vec::new(), Vec::new());
        for (ring, vertices) in border.loops.iter().enumerate() {
            let mut start = 0.0;
            for (k, &v) in vertices.iter().enumerate() {
                let vertices = [v, vertices[(k + 1) % vertices.len()]];
                let ends = vertices.map(|v| uv[v as usize]);
                edges.push(Edge { vertices, ends, ring, start });
                start += ends[0].distance(ends[1]);
            }
            around.push(start);
        }
        Self { edges, around }
    }

    /// Pairs that may be nearer than `clearance`.
    fn sweep(&self, clearance: f64) -> Sweep {
        let margin = DVec2::splat(0.5 * clearance);
        let bounds =
            |e: &Edge| [e.ends[0].min(e.ends[1]) - margin, e.ends[0].max(e.ends[1]) + margin];
        Sweep::new(self.edges.iter().map(bounds).collect())
    }

    /// Whether two edges that do not cross are nearer than they may be.
    fn are_near(&self, e: &Edge, f: &Edge, clearance: f64) -> bool {
        if e.ring != f.ring {
            return distance(e.ends, f.ends) < clearance;
        }
        let length = |e: &Edge| e.ends[0].distance(e.ends[1]);
        let (first, second) = if e.start <= f.start { (e, f) } else { (f, e) };
        let ahead = second.start - first.start - length(first);
        let behind = self.around[e.ring] - (second.start + length(second) - first.start);
        let along = ahead.min(behind).max(0.0);
        // Neighbours share an end: the other end of the shorter one must be clear of the longer.
        if along <= f64::EPSILON * self.around[e.ring] {
            let (short, long) = if length(e) <= length(f) { (e, f) } else { (f, e) };
            let far = short.ends.map(|p| to_segment(p, long.ends)).into_iter().fold(0.0, f64::max);
            return length(short) > ALONG * clearance && far < clearance;
        }
        along > ALONG * clearance && distance(e.ends, f.ends) < clearance
    }
}

/// Whether edges that are not neighbours keep `clearance` from each other, and neighbours do not run
/// back along each other that near.
pub fn is_clear(border: &Border, uv: &[DVec2], clearance: f64) -> bool {
    let edges = Edges::new(border, uv);
    let edge = |i: u32| &edges.edges[i as usize];
    !edges.sweep(clearance).any(|i, j| edges.are_near(edge(i), edge(j), clearance))
}

/// Pairs of edges that cross, or are nearer than [`is_clear`] lets them be.
pub(super) fn contacts(border: &Border, uv: &[DVec2], clearance: f64) -> Vec<[Edge; 2]> {
    let edges = Edges::new(border, uv);
    let edge = |i: u32| &edges.edges[i as usize];
    let touch = |i: u32, j: u32| {
        let (e, f) = (edge(i), edge(j));
        let neighbours = e.vertices[1] == f.vertices[0] || f.vertices[1] == e.vertices[0];
        (!neighbours && segments_meet(e.ends, f.ends)) || edges.are_near(e, f, clearance)
    };
    let pairs = edges.sweep(clearance).pairs(touch);
    pairs.into_iter().map(|(i, j)| [*edge(i), *edge(j)]).collect()
}

/// Vertices of a border, ascending, at which it crosses itself or is nearer to itself than [`is_clear`] lets it.
pub fn touching(border: &Border, uv: &[DVec2], clearance: f64) -> Vec<u32> {
    let pairs = contacts(border, uv, clearance);
    let mut vertices: Vec<u32> = pairs.iter().flatten().flat_map(|edge| edge.vertices).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}

/// Distance of two segments that do not cross.
fn distance(e: [DVec2; 2], f: [DVec2; 2]) -> f64 {
    let ends = [to_segment(e[0], f), to_segment(e[1], f), to_segment(f[0], e), to_segment(f[1], e)];
    ends.into_iter().fold(f64::INFINITY, f64::min)
}

fn to_segment(p: DVec2, [a, b]: [DVec2; 2]) -> f64 {
    let d = b - a;
    let t = if d.length_squared() > 0.0 { (p - a).dot(d) / d.length_squared() } else { 0.0 };
    p.distance(a + d * t.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clear(points: &[(f64, f64)], clearance: f64) -> bool {
        let uv: Vec<DVec2> = points.iter().map(|&p| DVec2::from(p)).collect();
        let ring = (0..uv.len() as u32).collect();
        let border = Border { loops: vec![ring], euler: 1, manifold: true, pieces: 1 };
        is_clear(&border, &uv, clearance)
    }

    #[test]
    fn squares_are_clear_and_near_sides_are_not() {
        assert!(clear(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)], 1e-3));
        // A slot of 1e-4 between two arms.
        let slot = |w: f64| {
            [
                (0.0, 0.0),
                (2.0, 0.0),
                (2.0, 1.0),
                (1.0 + w, 1.0),
                (1.0 + w, 0.2),
                (1.0, 0.2),
                (1.0, 1.0),
                (0.0, 1.0),
            ]
        };
        assert!(!clear(&slot(1e-4), 1e-3));
        assert!(clear(&slot(1e-2), 1e-3));
    }

    #[test]
    fn a_slit_is_not_clear_and_a_short_edge_does_no_harm() {
        let slit = |w: f64| {
            [
                (0.0, 0.0),
                (2.0, 0.0),
                (2.0, 1.0),
                (1.0 + w, 1.0),
                (1.0, 0.2),
                (1.0 - w, 1.0),
                (0.0, 1.0),
            ]
        };
        assert!(!clear(&slit(1e-4), 1e-3));
        assert!(clear(&slit(1e-2), 1e-3));
        let chamfer = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (1e-4, 1.0), (0.0, 1.0 - 1e-4)];
        assert!(clear(&chamfer, 1e-3));
    }

    #[test]
    fn a_hole_keeps_clear_of_the_rim() {
        let square = |low: f64, high: f64| [(low, low), (high, low), (high, high), (low, high)];
        for (low, want) in [(0.3, true), (1e-4, false)] {
            let uv: Vec<DVec2> =
                square(0.0, 1.0).into_iter().chain(square(low, 0.7)).map(DVec2::from).collect();
            let loops = vec![vec![0, 1, 2, 3], vec![7, 6, 5, 4]];
            let border = Border { loops, euler: 0, manifold: true, pieces: 1 };
            assert_eq!(is_clear(&border, &uv, 1e-3), want);
        }
    }
}
