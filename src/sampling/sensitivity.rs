//! Salient edges and the edge-sensitivity field (paper 2.1.1, Eq. 1). An edge is salient where its
//! faces meet at more than 30°. The field is 1 on a right-angled edge, less on a blunter one, and
//! falls with the distance over the surface like a Gaussian of width σ = 0.02 diagonals. (The paper
//! names the field and does not define it.)

use std::collections::BinaryHeap;
use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use crate::contract::{Canceled, Run};
use crate::mesh::{CREASE, NONE, Surface};

/// Width of the field over the diagonal.
const WIDTH: f64 = 0.02;
/// The field is followed this many widths.
const REACH: f64 = 3.0;

/// The salient edges of a surface and how near everything is to them.
#[derive(Debug, Clone)]
pub struct EdgeField {
    /// Strength of each half-edge: 0 where not salient, else the angle over 90°, at most 1. Both
    /// half-edges of an edge carry it.
    pub strength: Vec<f32>,
    /// Whether each face has a salient edge.
    pub salient_face: Vec<bool>,
    /// For each vertex, how far the salient edge is whose field it has, and its strength (0: none
    /// within reach).
    vertex: Vec<(f64, f64)>,
    width: f64,
}

/// An entry of the queue, nearest first.
#[derive(PartialEq)]
struct Reached {
    distance: f64,
    vertex: u32,
    strength: f64,
}

impl Eq for Reached {}

impl Ord for Reached {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        other
            .distance
            .total_cmp(&self.distance)
            .then_with(|| self.strength.total_cmp(&other.strength))
            .then_with(|| other.vertex.cmp(&self.vertex))
    }
}

impl PartialOrd for Reached {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl EdgeField {
    /// Find the salient edges and carry their strength along the mesh's edges.
    pub fn new(surface: &Surface, run: &Run) -> Result<Self, Canceled> {
        let faces = surface.face_count();
        let mut strength = vec![0.0f32; 3 * faces];
        for h in 0..3 * faces as u32 {
            let t = surface.twin[h as usize];
            if t == NONE || h > t {
                continue;
            }
            let angle = surface.dihedral(h).abs();
            if angle > CREASE {
                let value = (angle / FRAC_PI_2).min(1.0) as f32;
                strength[h as usize] = value;
                strength[t as usize] = value;
            }
        }
        run.cancel.check()?;
        let salient_face =
            strength.chunks_exact(3).map(|edges| edges.iter().any(|&s| s > 0.0)).collect();
        let mut field = Self {
            strength,
            salient_face,
            vertex: vec![(0.0, 0.0); surface.positions.len()],
            width: WIDTH * surface.diagonal,
        };
        field.spread(surface, run)?;
        Ok(field)
    }

    fn spread(&mut self, surface: &Surface, run: &Run) -> Result<(), Canceled> {
        let mut source = vec![0.0f64; surface.positions.len()];
        for (h, &s) in (0u32..).zip(&self.strength).filter(|(_, s)| **s > 0.0) {
            for v in [surface.from(h), surface.to(h)] {
                source[v as usize] = source[v as usize].max(s.into());
            }
        }
        let sources = (0u32..).zip(&source).filter(|(_, s)| **s > 0.0);
        let mut queue: BinaryHeap<Reached> = sources
            .map(|(vertex, &strength)| Reached { distance: 0.0, vertex, strength })
            .collect();
        if queue.is_empty() {
            return Ok(());
        }
        let neighbours = Neighbours::new(surface);
        let mut nearest: Vec<f64> =
            source.iter().map(|&s| if s > 0.0 { 0.0 } else { REACH * self.width }).collect();
        let mut steps = 0u32;
        while let Some(Reached { distance, vertex, strength }) = queue.pop() {
            let v = vertex as usize;
            // Reached on a shorter way, or from a stronger edge, before.
            if self.vertex[v].1 > 0.0 {
                continue;
            }
            steps += 1;
            if steps.is_multiple_of(4096) {
                run.cancel.check()?;
            }
            self.vertex[v] = (distance, strength);
            for &w in neighbours.of(vertex) {
                let on = distance + surface.positions[v].distance(surface.positions[w as usize]);
                if on < nearest[w as usize] {
                    nearest[w as usize] = on;
                    queue.push(Reached { distance: on, vertex: w, strength });
                }
            }
        }
        Ok(())
    }

    fn decay(&self, distance: f64) -> f64 {
        (-0.5 * (distance / self.width).powi(2)).exp()
    }

    /// The field (0 to 1) at a point of a face.
    pub fn at(&self, surface: &Surface, face: usize, point: DVec3) -> f64 {
        let corners = surface.corners(face);
        let mut value = 0.0f64;
        for k in 0..3 {
            let (before, strength) = self.vertex[surface.triangles[face][k] as usize];
            if strength > value {
                value = value.max(strength * self.decay(before + point.distance(corners[k])));
            }
            let strength: f64 = self.strength[3 * face + k].into();
            if strength > value {
                let away = distance_to_segment(point, corners[k], corners[(k + 1) % 3]);
                value = value.max(strength * self.decay(away));
            }
        }
        value
    }
}

fn distance_to_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let along =
        ((p - a).dot(b - a) / (b - a).length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    p.distance(a + (b - a) * along)
}

/// The vertices next to each vertex, in one array.
struct Neighbours {
    start: Vec<u32>,
    list: Vec<u32>,
}

impl Neighbours {
    fn new(surface: &Surface) -> Self {
        let edges = || {
            surface
                .triangles
                .iter()
                .flat_map(|t| (0..3).flat_map(|k| [(t[k], t[(k + 1) % 3]), (t[(k + 1) % 3], t[k])]))
        };
        let mut start = vec![0u32; surface.positions.len() + 1];
        for (a, _) in edges() {
            start[a as usize + 1] += 1;
        }
        for i in 1..start.len() {
            start[i] += start[i - 1];
        }
        let mut place = start.clone();
        let mut list = vec![0u32; start.last().copied().unwrap_or(0) as usize];
        for (a, b) in edges() {
            list[place[a as usize] as usize] = b;
            place[a as usize] += 1;
        }
        Self { start, list }
    }

    fn of(&self, v: u32) -> &[u32] {
        &self.list[self.start[v as usize] as usize..self.start[v as usize + 1] as usize]
    }
}
