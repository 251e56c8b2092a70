//! The long waves of a large disk's system: a square grid over the map, bilinear between its nodes, on which the
//! system is solved by a factor (Galerkin). Beside each vertex's own block it makes the second level of an additive
//! preconditioner (Bramble, Pasciak & Xu 1990, doi:10.1090/S0025-5718-1990-1023042-6).

use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, Side};
use glam::{DMat2, DVec2};

use super::UvMap;
use crate::tasks;

/// Cells of the grid along the longer side of the map.
const CELLS: usize = 14;

/// Share by which the diagonal is raised: what the grid cannot tell apart from standing still.
const RAISED: f64 = 1e-8;

/// Neighbours of a node in a row or column, itself among them.
const NEAR: usize = 3;

/// The grid over a map.
pub(super) struct Grid {
    across: usize,
    nodes: usize,
    /// For each vertex the lowest node of its cell, and where in the cell it lies, 0 to 1.
    places: Vec<(u32, DVec2)>,
}

/// A system on the grid, factorised.
pub(super) struct Level {
    factor: Llt<f64>,
}

impl Grid {
    pub fn over(uv: &[DVec2]) -> Self {
        let low = uv.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = uv.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        let cell = ((high - low).max_element() / CELLS as f64).max(f64::MIN_POSITIVE);
        let cells = ((high - low) / cell).ceil().max(DVec2::ONE);
        let (across, up) = (cells.x as usize + 1, cells.y as usize + 1);
        let place = |v: usize| {
            let at = (uv[v] - low) / cell;
            let first = at.floor().clamp(DVec2::ZERO, cells - DVec2::ONE);
            ((first.y as usize * across + first.x as usize) as u32, at - first)
        };
        Self { across, nodes: across * up, places: tasks::fill("grid", uv.len(), place) }
    }

    /// The four nodes of a vertex's cell, and their shares.
    fn shares(&self, v: usize) -> [(usize, f64); 4] {
        let (node, DVec2 { x, y }) = self.places[v];
        let node = node as usize;
        [
            (node, (1.0 - x) * (1.0 - y)),
            (node + 1, x * (1.0 - y)),
            (node + self.across, (1.0 - x) * y),
            (node + self.across + 1, x * y),
        ]
    }

    /// The place of node `m` among the neighbours of node `n`, or `None` where it is none.
    fn near(&self, n: usize, m: usize) -> Option<usize> {
        let apart = |a: usize, b: usize| (a + 1).checked_sub(b).filter(|d| *d < NEAR);
        let column = apart(m % self.across, n % self.across)?;
        Some(NEAR * apart(m / self.across, n / self.across)? + column)
    }

    /// The system of `rows` (vertices and blocks of the row of a vertex) on the grid; `None` where it has no factor.
    pub fn level<'a, R: Iterator<Item = (u32, &'a DMat2)>>(
        &self,
        rows: impl Fn(usize) -> R + Sync + Send,
    ) -> Option<Level> {
        const AROUND: usize = NEAR * NEAR;
        let add = |sum: &mut [DMat2], v: usize| {
            let own = self.shares(v);
            // Most neighbours lie in the same cell.
            let mut same = [DMat2::ZERO; 4];
            for (w, block) in rows(v) {
                let theirs = self.shares(w as usize);
                if theirs[0].0 == own[0].0 {
                    same.iter_mut()
                        .zip(theirs)
                        .for_each(|(sum, (_, share))| *sum += *block * share);
                    continue;
                }
                for (n, mine) in own {
                    for (m, share) in theirs {
                        if let Some(at) = self.near(n, m) {
                            sum[AROUND * n + at] += *block * (mine * share);
                        }
                    }
                }
            }
            for (n, mine) in own {
                for ((m, _), block) in own.into_iter().zip(same) {
                    if let Some(at) = self.near(n, m) {
                        sum[AROUND * n + at] += block * mine;
                    }
                }
            }
        };
        let block = |vertices: std::ops::Range<usize>| {
            let mut sum = vec![DMat2::ZERO; AROUND * self.nodes];
            vertices.for_each(|v| add(&mut sum, v));
            sum
        };
        let mut all = vec![DMat2::ZERO; AROUND * self.nodes];
        for part in tasks::blocks("level", self.places.len(), block) {
            all.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
        }
        let mut matrix = Mat::<f64>::zeros(2 * self.nodes, 2 * self.nodes);
        for n in 0..self.nodes {
            for m in 0..self.nodes {
                if let Some(at) = self.near(n, m) {
                    let block = all[AROUND * n + at];
                    for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                        matrix[(2 * n + i, 2 * m + j)] = block.col(j)[i];
                    }
                }
            }
            for i in 2 * n..2 * n + 2 {
                let own = matrix[(i, i)];
                // A node that no vertex is near stays.
                matrix[(i, i)] = if own > 0.0 { own * (1.0 + RAISED) } else { 1.0 };
            }
        }
        matrix.llt(Side::Lower).ok().map(|factor| Level { factor })
    }

    /// What the level makes of a residual, at each vertex.
    pub fn eased(&self, level: &Level, rest: &[DVec2]) -> UvMap {
        let block = |vertices: std::ops::Range<usize>| {
            let mut sum = vec![DVec2::ZERO; self.nodes];
            for v in vertices {
                self.shares(v).into_iter().for_each(|(n, share)| sum[n] += rest[v] * share);
            }
            sum
        };
        let mut right = Mat::<f64>::zeros(2 * self.nodes, 1);
        for part in tasks::blocks("to the grid", rest.len(), block) {
            for (n, p) in part.into_iter().enumerate() {
                right[(2 * n, 0)] += p.x;
                right[(2 * n + 1, 0)] += p.y;
            }
        }
        let solved = level.factor.solve(&right);
        tasks::fill("from the grid", rest.len(), |v| {
            let at = |(n, share): (usize, f64)| {
                DVec2::new(solved[(2 * n, 0)], solved[(2 * n + 1, 0)]) * share
            };
            self.shares(v).into_iter().map(at).sum()
        })
    }
}
