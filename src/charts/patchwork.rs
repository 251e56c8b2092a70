//! The patches of a part while they are joined to charts: who owns which face, which edges are
//! closed, and where each corner lies in the plane.

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::DVec2;

use super::chart::StartKind;
use super::limits::extent::{Extent, extent};
use super::limits::fit::Fit;
use super::limits::known::Known;
use super::part_mesh::{PartMesh, Piece};
use crate::flatten::{UvMap, quality};
use crate::mesh::NONE;

/// Charts in the making.
#[derive(Clone)]
pub struct Patchwork<'a> {
    /// The part.
    pub mesh: &'a PartMesh<'a>,
    /// Chart of each local face.
    pub chart_of: Vec<u32>,
    /// Whether a local half-edge is closed. Length: 3 × faces.
    pub glued: Vec<bool>,
    /// Where each corner lies. Length: 3 × faces.
    pub uv: Vec<DVec2>,
    /// Faces of each chart, ascending; empty for one that was absorbed.
    pub faces: Vec<Vec<u32>>,
    /// Border of each chart as loops of half-edges, each starting at its lowest: one, and one more for
    /// each hole.
    pub rims: Vec<Vec<Vec<u32>>>,
    /// How far each chart's map reaches.
    pub extent: Vec<Extent>,
    /// How each chart's map was made.
    pub kind: Vec<StartKind>,
    /// Area of each chart.
    pub area: Vec<f64>,
    /// Symmetric Dirichlet energy of each chart over an isometry's, times its area.
    pub energy: Vec<f64>,
    /// What came of unions; clones share it.
    pub known: Arc<Known>,
}

impl<'a> Patchwork<'a> {
    /// Charts from their faces' numbers and the closed edges; the maps are yet to be set.
    pub fn new(mesh: &'a PartMesh<'a>, chart_of: Vec<u32>, glued: Vec<bool>) -> Self {
        let count = chart_of.iter().max().map_or(0, |&m| m as usize + 1);
        let mut faces = vec![Vec::new(); count];
        for (f, &c) in chart_of.iter().enumerate() {
            faces[c as usize].push(f as u32);
        }
        let uv = vec![DVec2::ZERO; 3 * mesh.len()];
        let area = faces.iter().map(|f| f.iter().map(|&f| mesh.area(f as usize)).sum()).collect();
        let (extent, energy) = (vec![Extent::default(); count], vec![0.0; count]);
        let (kind, rims) = (vec![StartKind::Weld; count], vec![Vec::new(); count]);
        let known = Arc::default();
        Self { mesh, chart_of, glued, uv, faces, rims, extent, kind, area, energy, known }
    }

    /// Put a chart's map in place.
    pub fn place(&mut self, chart: u32, piece: &Piece, fit: &Fit) {
        for (&f, triangle) in piece.faces.iter().zip(&piece.disk.triangles) {
            for (k, &v) in triangle.iter().enumerate() {
                self.uv[3 * f as usize + k] = fit.uv[v as usize];
            }
        }
        self.rims[chart as usize] = self.borders(chart);
        self.extent[chart as usize] = extent(&fit.uv);
        self.kind[chart as usize] = fit.kind;
        self.energy[chart as usize] = fit.energy * self.area[chart as usize];
    }

    /// The map of a piece of the patchwork.
    pub fn map_of(&self, piece: &Piece) -> UvMap {
        let mut uv = vec![DVec2::ZERO; piece.disk.positions.len()];
        for (&f, triangle) in piece.faces.iter().zip(&piece.disk.triangles) {
            for (k, &v) in triangle.iter().enumerate() {
                uv[v as usize] = self.uv[3 * f as usize + k];
            }
        }
        uv
    }

    /// A chart comes to own a piece's faces, with its map.
    pub fn take(&mut self, chart: u32, piece: &Piece, fit: &Fit) {
        piece.faces.iter().for_each(|&f| self.chart_of[f as usize] = chart);
        self.faces[chart as usize].clone_from(&piece.faces);
        self.area[chart as usize] = piece.disk.area();
        self.place(chart, piece, fit);
    }

    /// A chart falls into pieces that keep its map: the first stays chart `chart`, the others get new
    /// numbers. Returns the numbers. Each piece must lie within the chart and be connected.
    pub fn divide(&mut self, chart: u32, pieces: Vec<Vec<u32>>) -> Vec<u32> {
        let mut numbers = vec![chart];
        for (k, faces) in pieces.iter().enumerate() {
            if k > 0 {
                numbers.push(self.faces.len() as u32);
                self.faces.push(Vec::new());
                self.rims.push(Vec::new());
                self.extent.push(Extent::default());
                self.kind.push(StartKind::Weld);
                self.area.push(0.0);
                self.energy.push(0.0);
            }
            faces.iter().for_each(|&f| self.chart_of[f as usize] = numbers[k]);
        }
        for h in pieces.iter().flatten().flat_map(|&f| 3 * f..3 * f + 3) {
            let t = self.mesh.twin[h as usize];
            self.glued[h as usize] &=
                t != NONE && self.chart_of[h as usize / 3] == self.chart_of[t as usize / 3];
        }
        for (&number, faces) in numbers.iter().zip(pieces) {
            let piece = self.mesh.cut_open(faces, &self.glued);
            let uv = self.map_of(&piece);
            let energy = quality(&piece.disk, &uv).mean - 1.0;
            self.take(number, &piece, &Fit { uv, energy, kind: StartKind::Weld });
        }
        numbers
    }

    /// Chart `gone` becomes part of `keep`.
    pub fn absorb(&mut self, keep: u32, gone: u32) {
        let faces = std::mem::take(&mut self.faces[gone as usize]);
        faces.iter().for_each(|&f| self.chart_of[f as usize] = keep);
        self.faces[keep as usize].extend(faces);
        self.faces[keep as usize].sort_unstable();
        self.rims[gone as usize].clear();
        self.area[keep as usize] += std::mem::take(&mut self.area[gone as usize]);
        self.extent[gone as usize] = Extent::default();
        self.energy[gone as usize] = 0.0;
    }

    /// The next half-edge of the loop that a chart's border half-edge belongs to.
    pub fn next_on_border(&self, h: u32) -> u32 {
        let mut n = next(h);
        while self.glued[n as usize] {
            n = next(self.mesh.twin[n as usize]);
        }
        n
    }

    /// The border of a chart's map as polygons, in the order of its rims.
    pub fn outline(&self, chart: u32) -> impl Iterator<Item = Vec<DVec2>> {
        let rims = &self.rims[chart as usize];
        rims.iter().map(|ring| ring.iter().map(|&h| self.uv[h as usize]).collect())
    }

    fn borders(&self, chart: u32) -> Vec<Vec<u32>> {
        let mut loops: Vec<Vec<u32>> = Vec::new();
        let mut seen = BTreeSet::new();
        for first in self.faces[chart as usize].iter().flat_map(|&f| 3 * f..3 * f + 3) {
            if self.glued[first as usize] || seen.contains(&first) {
                continue;
            }
            let mut ring = vec![first];
            let mut h = self.next_on_border(first);
            while h != first {
                ring.push(h);
                h = self.next_on_border(h);
            }
            seen.extend(ring.iter().copied());
            loops.push(ring);
        }
        loops
    }

    /// The chart on the other side of a border half-edge.
    pub fn across(&self, h: u32) -> Option<u32> {
        let t = self.mesh.twin[h as usize];
        (t != NONE).then(|| self.chart_of[t as usize / 3])
    }

    /// Close or open the edges of a path.
    pub fn set_glued(&mut self, path: &[u32], closed: bool) {
        for &h in path {
            self.glued[h as usize] = closed;
            self.glued[self.mesh.twin[h as usize] as usize] = closed;
        }
    }
}

/// The half-edge after `h` in its face.
pub fn next(h: u32) -> u32 {
    3 * (h / 3) + (h % 3 + 1) % 3
}
