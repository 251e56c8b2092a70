//! Some faces of a part as a mesh of their own, in which ways are found along edges.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;

use crate::charts::part_mesh::{PartMesh, Piece};
use crate::charts::patchwork::next;
use crate::flatten::{Border, harmonic};
use crate::mesh::NONE;

/// Faces and how they hang together. Its vertices are those of its piece, its half-edges the part's.
pub struct Net<'a> {
    /// The part.
    pub mesh: &'a PartMesh<'a>,
    /// The faces, cut open.
    pub piece: Piece,
    /// What bounds them.
    pub border: Border,
    /// Half-edges of the part that leave each vertex and are no border.
    out: Vec<Vec<u32>>,
    /// How many half-edges lead nowhere.
    open: usize,
    /// One of the part's corners that are each vertex, by the half-edge that leaves there.
    pub corner: Vec<u32>,
}

impl<'a> Net<'a> {
    /// The net of some faces (ascending) over edges that `glued` lets through.
    pub fn new(mesh: &'a PartMesh<'a>, faces: Vec<u32>, glued: impl Fn(u32) -> bool) -> Self {
        let inner = |h: u32| {
            let t = mesh.twin[h as usize];
            t != NONE && glued(h.min(t))
        };
        let piece = mesh.cut_open_where(faces, inner);
        let mut out = vec![Vec::new(); piece.disk.positions.len()];
        let mut corner = vec![NONE; out.len()];
        let mut open = 0;
        for (&f, triangle) in piece.faces.iter().zip(&piece.disk.triangles) {
            for (h, &v) in (3 * f..).zip(triangle) {
                corner[v as usize] = h;
                if inner(h) && piece.faces.binary_search(&(mesh.twin[h as usize] / 3)).is_ok() {
                    out[v as usize].push(h);
                } else {
                    open += 1;
                }
            }
        }
        let border = Border::of(&piece.disk);
        Self { mesh, piece, border, out, open, corner }
    }

    /// Whether it is connected and manifold and has as many borders and such a Euler characteristic. Where an
    /// edge is open and both of its ends are closed about it, as where twins were parted, it is none of that.
    pub fn is(&self, borders: usize, euler: i64) -> bool {
        let Border { loops, manifold, pieces, .. } = &self.border;
        let slit = self.open != loops.iter().map(Vec::len).sum::<usize>();
        *manifold && !slit && *pieces == 1 && loops.len() == borders && self.border.euler == euler
    }

    /// The vertex from which a half-edge of the part leaves; `None` where its face is not one of the net's.
    pub fn from(&self, h: u32) -> Option<u32> {
        let face = self.piece.faces.binary_search(&(h / 3)).ok()?;
        Some(self.piece.disk.triangles[face][h as usize % 3])
    }

    /// The vertex to which a half-edge of the net leads.
    pub fn to(&self, h: u32) -> Option<u32> {
        self.from(next(h))
    }

    /// Where a vertex is.
    pub fn position(&self, v: u32) -> DVec3 {
        self.piece.disk.positions[v as usize]
    }

    /// How many vertices there are.
    pub fn len(&self) -> usize {
        self.piece.disk.positions.len()
    }

    /// The harmonic function of the values given at some vertices.
    pub fn harmonic(&self, given: impl IntoIterator<Item = (u32, f64)>) -> Option<Vec<f64>> {
        let mut values = vec![None; self.len()];
        given.into_iter().for_each(|(v, value)| values[v as usize] = Some(value));
        harmonic(&self.piece.disk, &values).ok()
    }

    /// The cheapest ways from some vertices: how much each vertex costs and the half-edge by which it is
    /// reached, until the first of the goals.
    pub fn ways(
        &self,
        from: &[u32],
        goals: &[u32],
        cost: impl Fn(u32, [u32; 2]) -> f64,
    ) -> Ways<'_, 'a> {
        let mut goal = vec![false; self.len()];
        goals.iter().for_each(|&v| goal[v as usize] = true);
        let mut ways = Ways {
            net: self,
            cost: vec![f64::INFINITY; self.len()],
            by: vec![NONE; self.len()],
            reached: None,
        };
        let mut heap = BinaryHeap::new();
        for &v in from {
            ways.cost[v as usize] = 0.0;
            heap.push((Reverse(0.0f64.to_bits()), Reverse(v)));
        }
        while let Some((Reverse(bits), Reverse(v))) = heap.pop() {
            let spent = f64::from_bits(bits);
            if ways.cost[v as usize] < spent {
                continue;
            }
            if goal[v as usize] {
                ways.reached = Some(v);
                break;
            }
            for &h in &self.out[v as usize] {
                let Some(w) = self.to(h) else { continue };
                let total = spent + cost(h, [v, w]);
                if total < ways.cost[w as usize] {
                    ways.cost[w as usize] = total;
                    ways.by[w as usize] = h;
                    heap.push((Reverse(total.to_bits()), Reverse(w)));
                }
            }
        }
        ways
    }
}

/// Cheapest ways over a net.
pub struct Ways<'n, 'a> {
    net: &'n Net<'a>,
    /// What each vertex costs; infinite where none leads to it, or none was looked for.
    pub cost: Vec<f64>,
    by: Vec<u32>,
    /// The goal that was reached first.
    pub reached: Option<u32>,
}

impl Ways<'_, '_> {
    /// The half-edges of the way to a vertex, from its end to its start.
    pub fn to(&self, mut v: u32) -> Vec<u32> {
        let mut way = Vec::new();
        while self.by[v as usize] != NONE {
            let h = self.by[v as usize];
            way.push(h);
            let Some(from) = self.net.from(h) else { break };
            v = from;
        }
        way
    }

    /// Where a vertex's way comes from last.
    pub fn by(&self, v: u32) -> Option<u32> {
        (self.by[v as usize] != NONE).then_some(self.by[v as usize])
    }
}
