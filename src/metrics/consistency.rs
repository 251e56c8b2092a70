//! The paper's internal consistency, reconstructed: do near points stay near? For each sampled vertex
//! of a chart and its 8 nearest, (‖Δu‖/(s ℓ) − 1)².
//!
//! Nearest by straight distance scores an exactly unrolled cylinder badly, since the two sides of its
//! cut are near in 3D and far in UV; so the figure is taken over the 8 nearest *along the chart*, and
//! the straight one stands beside it with every term clipped at 1. Along the chart ℓ is the geodesic
//! distance, which no less than the straight distance and no more than the shortest path over edges
//! bound: ℓ is the value between the two that suits the map best, so that every isometry scores 0.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::num::NonZero;

use glam::{DVec2, DVec3};
use kiddo::{ImmutableKdTree, SquaredEuclidean};

use super::Measured;
use crate::contract::{Cancel, Canceled, PaperInternalConsistency};

/// Neighbours a sample.
const NEIGHBOURS: usize = 8;
/// Most samples a chart.
const MOST_SAMPLES: usize = 2048;

/// A chart as a graph: its vertices, those on a cut once a side.
struct Graph {
    positions: Vec<DVec3>,
    uvs: Vec<DVec2>,
    /// Neighbours of vertex `v`: `targets[starts[v]..starts[v + 1]]`.
    starts: Vec<u32>,
    targets: Vec<u32>,
}

impl Graph {
    fn new(input: &Measured, faces: &[u32]) -> Self {
        let surface = input.surface;
        let key = |f: u32, k: usize| {
            let [u, v] = input.uvs[f as usize][k];
            (surface.triangles[f as usize][k], u.to_bits(), v.to_bits())
        };
        let mut keys: Vec<_> = faces.iter().flat_map(|&f| (0..3).map(move |k| key(f, k))).collect();
        keys.sort_unstable();
        keys.dedup();
        let vertex = |f: u32, k: usize| {
            let wanted = key(f, k);
            keys.partition_point(|other| *other < wanted) as u32
        };
        let mut pairs = Vec::with_capacity(6 * faces.len());
        for &f in faces {
            let [a, b, c] = [0, 1, 2].map(|k| vertex(f, k));
            for (x, y) in [(a, b), (b, c), (c, a)] {
                pairs.extend([(x, y), (y, x)]);
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        let mut starts = vec![0u32; keys.len() + 1];
        for (x, _) in &pairs {
            starts[*x as usize + 1] += 1;
        }
        for i in 0..keys.len() {
            starts[i + 1] += starts[i];
        }
        let uv = |bits: u32| f64::from(f32::from_bits(bits));
        Self {
            positions: keys.iter().map(|k| surface.positions[k.0 as usize]).collect(),
            uvs: keys.iter().map(|k| DVec2::new(uv(k.1), uv(k.2))).collect(),
            starts,
            targets: pairs.into_iter().map(|p| p.1).collect(),
        }
    }

    /// Vertices at which the figure is taken: all, or every so many.
    fn samples(&self) -> impl Iterator<Item = u32> {
        (0..self.positions.len())
            .step_by(self.positions.len().div_ceil(MOST_SAMPLES).max(1))
            .map(|v| v as u32)
    }

    /// (‖Δu‖/(s ℓ) − 1)², ℓ between `least` and `most`.
    fn term(&self, a: u32, b: u32, s: f64, least: f64, most: f64) -> f64 {
        let moved = self.uvs[a as usize].distance(self.uvs[b as usize]) / s;
        let length = moved.clamp(least.min(most), most);
        if moved == length {
            0.0
        } else if length > 0.0 {
            (moved / length - 1.0).powi(2)
        } else {
            f64::INFINITY
        }
    }

    fn straight(&self, a: u32, b: u32) -> f64 {
        self.positions[a as usize].distance(self.positions[b as usize])
    }
}

/// Shortest paths from one vertex, no farther than to the nearest few; its memory is used again.
struct Nearby {
    distance: Vec<f64>,
    touched: Vec<u32>,
    open: BinaryHeap<Reverse<(Ordered, u32)>>,
}

/// A distance: never NaN, so totally ordered.
#[derive(PartialEq, Clone, Copy)]
struct Ordered(f64);

impl Eq for Ordered {}

impl PartialOrd for Ordered {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Ordered {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

impl Nearby {
    fn new(vertices: usize) -> Self {
        Self { distance: vec![f64::INFINITY; vertices], touched: vec![], open: BinaryHeap::new() }
    }

    /// The nearest vertices of `from` along the edges, nearest first, with their distances.
    fn of(&mut self, graph: &Graph, from: u32) -> Vec<(u32, f64)> {
        for v in self.touched.drain(..) {
            self.distance[v as usize] = f64::INFINITY;
        }
        self.open.clear();
        self.open.push(Reverse((Ordered(0.0), from)));
        self.distance[from as usize] = 0.0;
        self.touched.push(from);
        let mut found = Vec::with_capacity(NEIGHBOURS);
        while let Some(Reverse((Ordered(d), v))) = self.open.pop() {
            if d > self.distance[v as usize] {
                continue;
            }
            if v != from {
                found.push((v, d));
                if found.len() == NEIGHBOURS {
                    break;
                }
            }
            let range = graph.starts[v as usize] as usize..graph.starts[v as usize + 1] as usize;
            for &w in &graph.targets[range] {
                let far = d + graph.straight(v, w);
                if far < self.distance[w as usize] {
                    if self.distance[w as usize].is_infinite() {
                        self.touched.push(w);
                    }
                    self.distance[w as usize] = far;
                    self.open.push(Reverse((Ordered(far), w)));
                }
            }
        }
        found
    }
}

/// The figure of one chart at the atlas's scale `s`; `None` where no vertex has a neighbour.
pub(super) fn internal_consistency(
    input: &Measured,
    faces: &[u32],
    s: f64,
    cancel: &Cancel,
) -> Result<Option<PaperInternalConsistency>, Canceled> {
    let graph = Graph::new(input, faces);
    cancel.check()?;
    let points: Vec<[f64; 3]> = graph.positions.iter().map(|p| p.to_array()).collect();
    let Ok(tree) = ImmutableKdTree::<f64, 3>::new_from_slice(&points) else {
        return Ok(None);
    };
    let mut nearby = Nearby::new(points.len());
    let (mut geodesic, mut euclidean) = ((0.0, 0u64), (0.0, 0u64));
    for v in graph.samples() {
        cancel.check()?;
        for (w, along) in nearby.of(&graph, v) {
            // Clipped far away: a map that tears may not make the figure infinite.
            let term = graph.term(v, w, s, graph.straight(v, w), along).min(1e4);
            geodesic = (geodesic.0 + term, geodesic.1 + 1);
        }
        let wanted = const { NonZero::new(NEIGHBOURS + 1).unwrap() };
        let nearest =
            tree.query(&points[v as usize]).nearest_n::<SquaredEuclidean<f64>>(wanted).execute();
        for other in nearest.iter().filter(|n| n.item != v).take(NEIGHBOURS) {
            let length = graph.straight(v, other.item);
            let term = graph.term(v, other.item, s, length, length).min(1.0);
            euclidean = (euclidean.0 + term, euclidean.1 + 1);
        }
    }
    Ok((geodesic.1 > 0 && euclidean.1 > 0).then(|| PaperInternalConsistency {
        geodesic: geodesic.0 / geodesic.1 as f64,
        euclidean: euclidean.0 / euclidean.1 as f64,
    }))
}
