//! The one pass over the triangles that measures conformal, stretch and barrier together. Each of
//! the three is an energy of n = ‖J̃‖² = σ1² + σ2² and d = det J̃, so that its gradient with respect to
//! J̃ is 2 E_n J̃ + E_d cof J̃.

use glam::{DMat2, DVec2};

use super::{Map, Term, TermValues, barrier, conformal, stretch};
use crate::flatten::Disk;

/// An energy of one Jacobian, with its derivatives by n = ‖J̃‖² and d = det J̃.
#[derive(Clone, Copy)]
pub(super) struct Energy {
    pub value: f64,
    pub by_norm: f64,
    pub by_det: f64,
}

/// What an energy is a function of.
#[derive(Clone, Copy)]
pub(super) struct Invariants {
    pub norm: f64,
    pub det: f64,
    pub epsilon: f64,
}

/// An energy as a function of a triangle's invariants.
type Measure = fn(Invariants) -> Energy;

/// The three terms measured here.
const ENERGIES: [(Term, Measure); 3] = [
    (Term::Conformal, conformal::energy),
    (Term::Stretch, stretch::energy),
    (Term::Barrier, barrier::energy),
];

/// A triangle with area.
#[derive(Debug, Clone, Copy)]
pub(super) struct Triangle {
    pub corners: [u32; 3],
    /// Share of the measured area.
    pub share: f64,
    /// Inverse of its edge matrix in its own plane.
    rest: DMat2,
}

/// The measured triangles.
#[derive(Debug)]
pub(super) struct Triangles {
    pub list: Vec<Triangle>,
    /// Their total area in 3D.
    area: f64,
}

impl Triangles {
    pub fn new(disk: &Disk, selected: &[u32]) -> Self {
        let area = selected.iter().map(|f| disk.areas[*f as usize]).sum();
        let triangle = |f: &u32| {
            let f = *f as usize;
            let share = disk.areas[f] / area;
            Triangle { corners: disk.triangles[f], share, rest: disk.rest[f] }
        };
        Self { list: selected.iter().map(triangle).collect(), area }
    }

    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// The corners of the triangles, in ascending order, once each.
    pub fn vertices(&self) -> Vec<u32> {
        let mut vertices: Vec<u32> = self.list.iter().flat_map(|t| t.corners).collect();
        vertices.sort_unstable();
        vertices.dedup();
        vertices
    }

    pub fn scale(&self, uv: &[DVec2]) -> f64 {
        let area: f64 =
            self.list.iter().map(|t| 0.5 * edge_matrix(t, uv).determinant().abs()).sum();
        // Not 0 and not NaN, so that what divides by it stays finite.
        if area > 0.0 { (area / self.area).sqrt().max(1e-12) } else { 1e-12 }
    }

    /// Values of the three terms into `values`, gradient of their weighted sum onto `gradient`.
    pub fn evaluate(
        &self,
        map: Map,
        weights: &TermValues,
        gradient: &mut [DVec2],
        values: &mut TermValues,
    ) {
        let per_scale = 1.0 / map.scale;
        for t in &self.list {
            let j = edge_matrix(t, map.uv) * t.rest * per_scale;
            let norm = j.x_axis.length_squared() + j.y_axis.length_squared();
            let at = Invariants { norm, det: j.determinant(), epsilon: map.at.epsilon };
            let (mut by_norm, mut by_det) = (0.0, 0.0);
            for (term, energy) in ENERGIES {
                let weight = weights[term as usize];
                if weight != 0.0 {
                    let energy = energy(at);
                    values[term as usize] += t.share * energy.value;
                    by_norm += weight * energy.by_norm;
                    by_det += weight * energy.by_det;
                }
            }
            let cofactor = DMat2::from_cols(-j.y_axis.perp(), j.x_axis.perp());
            let by_jacobian = j * (2.0 * by_norm) + cofactor * by_det;
            let by_edges = by_jacobian * t.rest.transpose() * (t.share * per_scale);
            let [a, b, c] = t.corners.map(|v| v as usize);
            gradient[a] -= by_edges.x_axis + by_edges.y_axis;
            gradient[b] += by_edges.x_axis;
            gradient[c] += by_edges.y_axis;
        }
    }
}

/// Edges from the first corner to the others, in UV.
#[inline]
fn edge_matrix(t: &Triangle, uv: &[DVec2]) -> DMat2 {
    let [a, b, c] = t.corners.map(|v| uv[v as usize]);
    DMat2::from_cols(b - a, c - a)
}
