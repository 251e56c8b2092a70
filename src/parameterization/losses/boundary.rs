//! Boundary loss: seam openness. The paper weighs a boundary loss (2.3.8) that it does not define.
//! A mesh that is cut at every candidate seam (`charts::over_cut`) has many; the loss Σ ℓ_e c_e o_e / Σ ℓ_e c_e counts how open each is,
//! o_e = g_e² / (g_e² + δ²), g_e² = (‖u_i − u_i'‖² + ‖u_j − u_j'‖²) / (2 s² r²) over the two copies of
//! e's ends. It closes what is dear and leaves open what is cheap: at label boundaries and creases, out
//! of sight. δ must fall slowly from above the widest gap: fixed small, whatever is nearest closes.

use glam::DVec2;

use super::{Loss, Map};

/// A candidate seam: an edge that stands twice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutEdge {
    /// The edge's ends on the one side and, in the same order, on the other: vertices of the disk.
    pub sides: [[u32; 2]; 2],
    /// Its length in 3D.
    pub length: f64,
    /// Its c_e: what a unit of it costs as a seam (of joint seams, the cost of the charts' objective).
    pub cost: f64,
}

/// The candidate seams of a mesh that is cut at all of them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct OverCut {
    /// The edges.
    pub edges: Vec<CutEdge>,
    /// Radius of the mesh in 3D, √(area/π) for joint seams: the unit in which gaps are measured. Above 0.
    pub radius: f64,
}

impl OverCut {
    /// Whether this speaks of a disk of `vertices` vertices and can be measured.
    pub(super) fn fits(&self, vertices: usize) -> bool {
        let weight: f64 = self.edges.iter().map(|e| e.length * e.cost).sum();
        let mut corners = self.edges.iter().flat_map(|e| e.sides.iter().flatten());
        weight > 0.0 && self.radius > 0.0 && corners.all(|v| (*v as usize) < vertices)
    }
}

/// The loss, the same in both forms.
#[derive(Debug)]
pub(super) struct Openness {
    /// Copies of the ends, and the edge's share of Σ ℓ_e c_e.
    edges: Vec<([[u32; 2]; 2], f64)>,
    radius: f64,
}

impl Openness {
    /// Adds the ends of the edges to `vertices`.
    pub fn prepare(cut: OverCut, vertices: &mut Vec<u32>) -> Option<Box<dyn Loss>> {
        let total: f64 = cut.edges.iter().map(|e| e.length * e.cost).sum();
        let edges = cut.edges.iter().map(|e| (e.sides, e.length * e.cost / total)).collect();
        vertices.extend(cut.edges.iter().flat_map(|e| e.sides.iter().flatten()));
        Some(Box::new(Self { edges, radius: cut.radius }))
    }
}

impl Loss for Openness {
    fn evaluate(&self, map: Map, weight: f64, gradient: &mut [DVec2]) -> f64 {
        let unit = map.scale * self.radius;
        let (per_square, half) = (0.5 / (unit * unit), map.at.delta * map.at.delta);
        let mut sum = 0.0;
        for ([[i, j], [k, l]], share) in &self.edges {
            let [i, j, k, l] = [*i, *j, *k, *l].map(|v| v as usize);
            let (first, second) = (map.uv[i] - map.uv[k], map.uv[j] - map.uv[l]);
            let gap = (first.length_squared() + second.length_squared()) * per_square;
            sum += share * gap / (gap + half);
            let slope = 2.0 * weight * share * per_square * half / (gap + half).powi(2);
            gradient[i] += slope * first;
            gradient[k] -= slope * first;
            gradient[j] += slope * second;
            gradient[l] -= slope * second;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::scenes::noise;
    use super::super::{Annealing, ChartTerms, LossContext, Term};
    use super::*;
    use crate::flatten::Disk;

    /// A prism of so many sides, each a strip of its own: a tube, over-cut.
    struct Ring {
        disk: Disk,
        cut: OverCut,
        widths: Vec<f64>,
    }

    const SIDES: usize = 8;

    fn ring(seed: u64) -> Ring {
        let widths: Vec<f64> = (0..SIDES).map(|k| 1.0 + 0.5 * noise(seed, k)).collect();
        let around: f64 = widths.iter().sum();
        let radius = around / std::f64::consts::TAU;
        let mut angle: f64 = 0.0;
        let (mut positions, mut triangles, mut edges) = (Vec::new(), Vec::new(), Vec::new());
        for (k, width) in widths.iter().enumerate() {
            let next = angle + width / radius;
            let at = |a: f64, z: f64| DVec3::new(radius * a.cos(), radius * a.sin(), z);
            positions.extend([at(angle, 0.0), at(next, 0.0), at(next, 1.0), at(angle, 1.0)]);
            let [v, w] = [4 * k as u32, 4 * ((k + 1) % SIDES) as u32];
            triangles.extend([[v, v + 1, v + 2], [v, v + 2, v + 3]]);
            let cost = 0.55 + 0.4 * noise(seed, 100 + k);
            edges.push(CutEdge { sides: [[v + 1, v + 2], [w, w + 3]], length: 1.0, cost });
            angle = next;
        }
        Ring { disk: Disk::new(positions, triangles), cut: OverCut { edges, radius }, widths }
    }

    /// Strips laid side by side, first the one after edge `open`, then moved as a whole each by descent.
    /// Returns the edges that end more than half open.
    fn open_after(ring: &Ring, open: usize, deltas: impl Iterator<Item = f64>) -> Vec<usize> {
        let context = LossContext { over_cut: Some(ring.cut.clone()), ..Default::default() };
        let terms = ChartTerms::new(&ring.disk, context);
        let mut uv = vec![DVec2::ZERO; 4 * SIDES];
        let mut x = 0.0;
        for k in (open + 1..=open + SIDES).map(|k| k % SIDES) {
            let width = ring.widths[k];
            let corners = [(0.0, 0.0), (width, 0.0), (width, 1.0), (0.0, 1.0)];
            for (p, (dx, dy)) in uv[4 * k..].iter_mut().zip(corners) {
                *p = DVec2::new(x + dx, dy);
            }
            x += width;
        }
        for delta in deltas {
            let at = Annealing { epsilon: 0.1, delta };
            let step = (delta * ring.cut.radius).powi(2);
            for _ in 0..200 {
                let mut gradient = vec![DVec2::ZERO; uv.len()];
                terms.evaluate(Term::Boundary, &uv, 1.0, at, &mut gradient);
                for (strip, g) in uv.chunks_mut(4).zip(gradient.chunks(4)) {
                    let move_by = g.iter().sum::<DVec2>() * step;
                    strip.iter_mut().for_each(|p| *p -= move_by);
                }
            }
        }
        let gap = |e: &CutEdge| uv[e.sides[0][0] as usize].distance(uv[e.sides[1][0] as usize]);
        (0..SIDES).filter(|k| gap(&ring.cut.edges[*k]) > 0.01 * ring.cut.radius).collect()
    }

    /// The tube must stay open somewhere. With δ falling, that is the cheapest edge, wherever it was
    /// open before; with δ small from the start, it stays where it was.
    #[test]
    fn a_falling_delta_opens_the_cheapest_seam_of_a_ring() {
        for seed in 0..12 {
            let ring = ring(seed);
            let cost = |k: &usize| ring.cut.edges[*k].cost;
            let best = (0..SIDES).min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap();
            for before in [best, best + 1, best + 4].map(|k| k % SIDES) {
                let falling = (0..=60).map(|k| Annealing::at(f64::from(k) / 60.0).delta);
                assert_eq!(open_after(&ring, before, falling), [best], "{seed}");
                let fixed = std::iter::repeat_n(0.01, 60);
                assert_eq!(open_after(&ring, before, fixed), [before], "{seed}");
            }
        }
    }

    #[test]
    fn closed_seams_score_nothing_and_gaping_ones_their_share() {
        let ring = ring(1);
        let context = LossContext { over_cut: Some(ring.cut.clone()), ..Default::default() };
        let terms = ChartTerms::new(&ring.disk, context);
        let mut uv = vec![DVec2::ONE; 4 * SIDES];
        let at = Annealing::at(1.0);
        let mut gradient = uv.clone();
        assert_eq!(terms.evaluate(Term::Boundary, &uv, 1.0, at, &mut gradient), 0.0);
        uv[1] += DVec2::splat(1e4);
        uv[2] += DVec2::splat(1e4);
        let total: f64 = ring.cut.edges.iter().map(|e| e.cost).sum();
        let value = terms.evaluate(Term::Boundary, &uv, 1.0, at, &mut gradient);
        assert!((value - ring.cut.edges[0].cost / total).abs() < 1e-9);
    }

    #[test]
    fn a_cut_that_does_not_fit_the_chart_is_not_measured() {
        let mut ring = ring(2);
        ring.cut.edges[0].sides[0][0] = 999;
        let context = LossContext { over_cut: Some(ring.cut), ..Default::default() };
        assert!(!ChartTerms::new(&ring.disk, context).has(Term::Boundary));
    }
}
