//! The patches of a part while they are joined to charts: who owns which face, which edges are
//! closed, and where each corner lies in the plane. Every chart is a disk at every moment.

use glam::DVec2;

use super::part_mesh::PartMesh;
use crate::mesh::NONE;

/// Charts in the making.
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
        Self { mesh, chart_of, glued, uv, faces }
    }

    /// The next half-edge of the loop that a chart's border half-edge belongs to.
    pub fn next_on_border(&self, h: u32) -> u32 {
        let mut n = next(h);
        while self.glued[n as usize] {
            n = next(self.mesh.twin[n as usize]);
        }
        n
    }

    /// The border of a chart as one loop of half-edges, starting at its lowest. Every chart is a
    /// disk, so that there is one loop.
    pub fn border(&self, chart: u32) -> Vec<u32> {
        let open = |&h: &u32| !self.glued[h as usize];
        let mut corners = self.faces[chart as usize].iter().flat_map(|&f| 3 * f..3 * f + 3);
        let Some(first) = corners.find(open) else { return Vec::new() };
        let mut border = vec![first];
        let mut h = self.next_on_border(first);
        while h != first {
            border.push(h);
            h = self.next_on_border(h);
        }
        border
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
