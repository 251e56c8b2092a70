//! The union on a grid and the surface of its voxels: a quad for every pair of neighbouring samples
//! of which one is inside, a vertex for every cell that a quad touches. That surface is a manifold
//! once the set is *well-composed* (Latecki, "3D well-composed pictures", 1997,
//! doi:10.1006/gmip.1997.0422), which a few added samples see to.

use std::collections::VecDeque;

use glam::DVec3;

use super::distance::{Near, Parts};

struct Grid {
    low: DVec3,
    spacing: f64,
    size: [usize; 3],
    inside: Vec<bool>,
}

/// Quads around the union, wound outwards, one closed piece; vertices at the cells' middles.
pub(super) fn surface(parts: &Parts, near: &Near, spacing: f64) -> (Vec<DVec3>, Vec<[u32; 4]>) {
    let mut grid = Grid::sample(parts, near, spacing);
    grid.keep_largest();
    grid.compose_well();
    grid.fill_hollows();
    grid.quads()
}

impl Grid {
    fn sample(parts: &Parts, near: &Near, spacing: f64) -> Self {
        // Off the round numbers that faces of objects like to lie on.
        let low = parts.low - DVec3::new(2.37, 2.41, 2.43) * spacing;
        let size = ((parts.high - low) / spacing).to_array().map(|n| n.ceil() as usize + 3);
        let mut inside = vec![false; size[0] * size[1] * size[2]];
        let mut index = 0;
        for k in 0..size[2] {
            for j in 0..size[1] {
                // Beyond reach of its surface a part goes on as it was before along the row.
                let mut within = vec![false; parts.count];
                for i in 0..size[0] {
                    let p = low + spacing * DVec3::new(i as f64, j as f64, k as f64);
                    for c in near.each(p) {
                        within[c.part as usize] = c.distance < 0.0;
                    }
                    inside[index] = within.contains(&true);
                    index += 1;
                }
            }
        }
        Self { low, spacing, size, inside }
    }

    fn strides(&self) -> [usize; 3] {
        [1, self.size[0], self.size[0] * self.size[1]]
    }

    /// The samples that `value` samples reach from each other, in pieces, largest first.
    fn pieces(&self, value: bool) -> Vec<Vec<usize>> {
        let strides = self.strides();
        let mut seen = vec![false; self.inside.len()];
        let mut pieces: Vec<Vec<usize>> = vec![];
        for start in 0..self.inside.len() {
            if seen[start] || self.inside[start] != value {
                continue;
            }
            seen[start] = true;
            let (mut piece, mut queue) = (vec![], VecDeque::from([start]));
            while let Some(at) = queue.pop_front() {
                piece.push(at);
                for axis in 0..3 {
                    let place = at / strides[axis] % self.size[axis];
                    let before = (place > 0).then(|| at - strides[axis]);
                    let after = (place + 1 < self.size[axis]).then(|| at + strides[axis]);
                    for next in [before, after].into_iter().flatten() {
                        if !seen[next] && self.inside[next] == value {
                            seen[next] = true;
                            queue.push_back(next);
                        }
                    }
                }
            }
            pieces.push(piece);
        }
        pieces.sort_by_key(|p| std::cmp::Reverse(p.len()));
        pieces
    }

    fn keep_largest(&mut self) {
        for piece in self.pieces(true).iter().skip(1) {
            for &i in piece {
                self.inside[i] = false;
            }
        }
    }

    /// Bubbles are no part of the outer surface.
    fn fill_hollows(&mut self) {
        for piece in self.pieces(false).iter().skip(1) {
            for &i in piece {
                self.inside[i] = true;
            }
        }
    }

    /// Add samples until no two inside (or outside) samples of a block meet only across an edge or
    /// a corner. Every round adds, so it ends.
    fn compose_well(&mut self) {
        let s = self.strides();
        let block: [usize; 8] =
            std::array::from_fn(|c| (0..3).filter(|a| c >> a & 1 == 1).map(|a| s[a]).sum());
        loop {
            let mut added = false;
            for base in self.cells() {
                let set = |c: usize, inside: &[bool]| inside[base + block[c]];
                // The checkerboards on the six sides of the block.
                for axis in 0..3 {
                    let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
                    for from in [0, 1 << axis] {
                        let corners = [from, from | u, from | v, from | u | v];
                        let on = corners.map(|c| set(c, &self.inside));
                        if on[0] == on[3] && on[1] == on[2] && on[0] != on[1] {
                            let add = if on[0] { corners[1] } else { corners[0] };
                            self.inside[base + block[add]] = true;
                            added = true;
                        }
                    }
                }
                // Two opposite corners alone.
                for c in 0..4 {
                    let odd = set(c, &self.inside);
                    let alone =
                        (0..8).all(|d| (set(d, &self.inside) == odd) == (d == c || d == 7 - c));
                    if alone {
                        let add = if odd { c ^ 1 } else { c };
                        self.inside[base + block[add]] = true;
                        added = true;
                    }
                }
            }
            if !added {
                return;
            }
        }
    }

    /// The lowest sample of each cell.
    fn cells(&self) -> impl Iterator<Item = usize> + use<> {
        let (size, s) = (self.size, self.strides());
        (0..size[2] - 1).flat_map(move |k| {
            (0..size[1] - 1)
                .flat_map(move |j| (0..size[0] - 1).map(move |i| i + s[1] * j + s[2] * k))
        })
    }

    fn quads(&self) -> (Vec<DVec3>, Vec<[u32; 4]>) {
        let s = self.strides();
        let mut vertex = vec![u32::MAX; self.inside.len()];
        let (mut positions, mut quads) = (vec![], vec![]);
        let mut cell = |at: usize| {
            if vertex[at] == u32::MAX {
                vertex[at] = positions.len() as u32;
                let place = [0, 1, 2].map(|a| (at / s[a] % self.size[a]) as f64 + 0.5);
                positions.push(self.low + self.spacing * DVec3::from_array(place));
            }
            vertex[at]
        };
        // The margin is outside, so every edge that changes sign has its four cells.
        for at in 0..self.inside.len() {
            for axis in 0..3 {
                let next = at + s[axis];
                if next >= self.inside.len() || self.inside[at] == self.inside[next] {
                    continue;
                }
                let (u, v) = (s[(axis + 1) % 3], s[(axis + 2) % 3]);
                let mut quad = [at - u - v, at - v, at, at - u].map(&mut cell);
                if self.inside[next] {
                    quad.reverse();
                }
                quads.push(quad);
            }
        }
        (positions, quads)
    }
}
