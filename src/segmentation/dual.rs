//! The dual graph of a surface: faces are nodes, shared edges are links. The weight of a link is
//! what it costs to have a boundary there: ℓ·exp(−κ·concavity), so that boundaries are short and lie
//! in concave creases (the minima rule).

use crate::mesh::{NONE, Surface};

/// How strongly concavity (radians) draws boundaries.
const KAPPA: f64 = 4.0;

/// A convex crease draws them too, this much less.
const CONVEX: f64 = 0.25;

/// Links of each face, in compressed rows.
pub struct DualGraph {
    starts: Vec<u32>,
    links: Vec<(u32, f64)>,
}

impl DualGraph {
    /// The graph of a surface's faces. Weights are in units of the mean edge length; a
    /// face and its mate are linked, so that they get one label.
    pub fn new(surface: &Surface) -> Self {
        let mut pairs: Vec<(u32, u32, f64)> = Vec::with_capacity(surface.twin.len());
        let (mut total, mut count) = (0.0, 0usize);
        for (h, &t) in surface.twin.iter().enumerate().filter(|(_, t)| **t != NONE) {
            let h = h as u32;
            let angle = surface.dihedral(h);
            let bend = if angle < 0.0 { -angle } else { CONVEX * angle };
            let length = surface.length(h);
            total += length;
            count += 1;
            pairs.push((h / 3, t / 3, length * (-KAPPA * bend).exp()));
        }
        let mean = if count > 0 { total / count as f64 } else { 1.0 };
        pairs.iter_mut().for_each(|p| p.2 /= mean);
        for (f, &m) in surface.sheet_mate.iter().enumerate().filter(|(_, m)| **m != NONE) {
            pairs.push((f as u32, m, 3.0));
        }
        pairs.sort_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)));
        let mut starts = vec![0u32; surface.face_count() + 1];
        pairs.iter().for_each(|p| starts[p.0 as usize + 1] += 1);
        for f in 0..surface.face_count() {
            starts[f + 1] += starts[f];
        }
        Self { starts, links: pairs.into_iter().map(|(_, g, w)| (g, w)).collect() }
    }

    /// Number of faces.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Neighbours of a face, with the cost of a boundary between.
    pub fn links(&self, face: u32) -> &[(u32, f64)] {
        let (a, b) = (self.starts[face as usize], self.starts[face as usize + 1]);
        &self.links[a as usize..b as usize]
    }
}
