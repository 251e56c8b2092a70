//! Where welded components touch: authored objects are often one component a board, and a part may be
//! several boards.

use kiddo::{ImmutableKdTree, SquaredEuclidean};

use crate::mesh::{NONE, Surface};
use crate::sampling::PointCloud;

/// Points of two welded components nearer than this share of the diagonal touch.
const REACH: f64 = 0.01;

/// Points that are looked at.
const POINTS: usize = 20_000;

/// Two places that touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Faces, the smaller first.
    pub faces: (u32, u32),
    /// Length that it stands for, world units.
    pub length: f64,
}

/// Contacts between faces of different welded components (`body`: one number a face).
pub fn contacts(surface: &Surface, cloud: &PointCloud, body: &[u32]) -> Vec<Contact> {
    let first = cloud.faces.first().map(|&f| body[f as usize]);
    if cloud.faces.iter().all(|&f| Some(body[f as usize]) == first) {
        return Vec::new();
    }
    let count = cloud.len().min(POINTS);
    let picked: Vec<u32> = (0..count).map(|i| (i * cloud.len() / count) as u32).collect();
    let at: Vec<[f64; 3]> =
        picked.iter().map(|&i| cloud.positions[i as usize].to_array()).collect();
    let Ok(tree) = ImmutableKdTree::<f64, 3>::new_from_slice(&at) else { return Vec::new() };
    let spacing = (surface.area() / count as f64).sqrt();
    let reach = REACH * surface.diagonal;
    let mut found = Vec::new();
    for (i, &p) in picked.iter().enumerate() {
        let face = cloud.faces[p as usize];
        let near = tree.query(&at[i]).within::<SquaredEuclidean<f64>>(reach * reach).execute();
        // The nearest of each other component.
        let mut seen: Vec<u32> = Vec::new();
        for hit in near.iter().take(64) {
            let other = cloud.faces[picked[hit.item as usize] as usize];
            let own = body[other as usize];
            if own == body[face as usize] || own == NONE || seen.contains(&own) {
                continue;
            }
            seen.push(own);
            let faces = (face.min(other), face.max(other));
            found.push(Contact { faces, length: 0.5 * spacing });
        }
    }
    found.sort_by_key(|c| c.faces);
    found.dedup_by(|a, b| {
        let same = a.faces == b.faces;
        if same {
            b.length += a.length;
        }
        same
    });
    found
}
