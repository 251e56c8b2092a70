//! The initial regions (`patch`), of which parts are sets: an over-segmentation of each authored component.
//! Edges are taken in order of what speaks against joining across them (Kruskal's order, as Felzenszwalb and
//! Huttenlocher 2004, doi:10.1023/B:VISI.0000022288.19776.77, take pixels), and the two regions at an edge
//! are joined up to a size; never over a sharp edge or out of an authored component.

use super::components::AuthoredComponents;
use super::evidence::Evidence;
use crate::mesh::{DisjointSets, NONE, Surface};

/// A region of several faces has at most this share of the area.
const MOST: f64 = 1.0 / 900.0;

/// How much the dihedral angle of an edge (radians) counts; a concave one counts twice.
const BEND: f64 = 1.0;

/// How much the step of the embedding counts.
const STEP: f64 = 0.6;

/// Faces are never joined over an edge that bends by this (radians) or more.
const SHARP: f64 = 0.6;

/// Initial region of each face, numbered from 0 in order of first face; [`NONE`] for faces without area.
pub fn patches(
    surface: &Surface,
    evidence: &Evidence,
    components: &AuthoredComponents,
) -> (Vec<u32>, usize) {
    let mut sets = DisjointSets::new(surface.face_count());
    let mut links: Vec<(f64, u32, u32)> = Vec::new();
    for (h, &t) in (0u32..).zip(&surface.twin).filter(|(h, t)| **t != NONE && h < *t) {
        let angle = surface.dihedral(h);
        if angle.abs() < SHARP {
            let bend = if angle < 0.0 { -2.0 * angle } else { angle };
            links.push((BEND * bend + STEP * step(evidence, h / 3, t / 3), h, t));
        }
    }
    links.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut areas = vec![0.0; surface.face_count()];
    for f in 0..surface.face_count() as u32 {
        areas[sets.root(f) as usize] += surface.areas[f as usize];
    }
    let most = MOST * areas.iter().sum::<f64>();
    for &(_, h, t) in &links {
        let (a, b) = (sets.root(h / 3), sets.root(t / 3));
        let whole = areas[a as usize] + areas[b as usize];
        if a != b && whole <= most && !components.differ(h, t) {
            let (keep, gone) = (a.min(b), a.max(b));
            sets.hang(gone, keep);
            areas[keep as usize] = whole;
        }
    }
    number(surface, &mut sets)
}

fn number(surface: &Surface, sets: &mut DisjointSets) -> (Vec<u32>, usize) {
    let mut number = vec![NONE; surface.face_count()];
    let mut count = 0;
    let patch = (0..surface.face_count() as u32).map(|f| {
        let root = sets.root(f) as usize;
        if number[root] == NONE {
            number[root] = count;
            count += 1;
        }
        number[root]
    });
    let patch = patch.collect();
    (patch, count as usize)
}

/// How far apart the embeddings of two faces are.
fn step(evidence: &Evidence, f: u32, g: u32) -> f64 {
    let row = |f: u32| &evidence.embedding[f as usize * evidence.width..][..evidence.width];
    row(f).iter().zip(row(g)).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>().sqrt()
}
