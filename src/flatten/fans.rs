//! The faces and vertices around the vertices of a disk, and steps of one vertex: what the methods that go vertex
//! by vertex have in common.

use std::collections::HashSet;

use glam::DVec2;

use super::{Disk, UvMap};

/// The faces around each vertex.
pub struct Fans {
    starts: Vec<u32>,
    /// Face and corner, 3 f + k.
    corners: Vec<u32>,
}

impl Fans {
    pub fn of(disk: &Disk) -> Self {
        let mut starts = vec![0u32; disk.positions.len() + 1];
        for &v in disk.triangles.iter().flatten() {
            starts[v as usize + 1] += 1;
        }
        for v in 0..disk.positions.len() {
            starts[v + 1] += starts[v];
        }
        let mut next = starts.clone();
        let mut corners = vec![0; 3 * disk.triangles.len()];
        for (i, &v) in disk.triangles.iter().flatten().enumerate() {
            corners[next[v as usize] as usize] = i as u32;
            next[v as usize] += 1;
        }
        Self { starts, corners }
    }

    /// Corners 3 f + k at a vertex.
    pub fn at(&self, v: usize) -> &[u32] {
        &self.corners[self.starts[v] as usize..self.starts[v + 1] as usize]
    }
    /// Vertices within so many rings of faces of others, with their ring, nearest first.
    pub fn around(&self, disk: &Disk, of: &[u32], rings: u32) -> Vec<(u32, u32)> {
        let mut seen: HashSet<u32> = HashSet::new();
        let mut patch: Vec<(u32, u32)> =
            of.iter().filter(|&&v| seen.insert(v)).map(|&v| (v, 0)).collect();
        let mut at = 0;
        while at < patch.len() && patch[at].1 < rings {
            let (v, ring) = patch[at];
            at += 1;
            for w in self.at(v as usize).iter().flat_map(|&c| disk.triangles[c as usize / 3]) {
                if seen.insert(w) {
                    patch.push((w, ring + 1));
                }
            }
        }
        patch
    }
}

/// Move a vertex by a step that is halved until the map is better; it stays where none is.
pub fn shortened(
    uv: &mut UvMap,
    v: usize,
    step: DVec2,
    halvings: u32,
    is_better: impl Fn(&UvMap) -> bool,
) {
    let from = uv[v];
    let mut length = 1.0;
    for _ in 0..halvings {
        uv[v] = from + length * step;
        if is_better(uv) {
            return;
        }
        length *= 0.5;
    }
    uv[v] = from;
}
