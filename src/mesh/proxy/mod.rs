//! The proxy of a dense surface (docs/coarse_to_fine.md): each connected component of many faces collapsed
//! to few, the others as they are. It is what is sampled, segmented and cut; what is found there is carried
//! back over the record, which says where on the proxy each fine vertex and face lies.

mod builder;
mod collapse;
mod dense;
mod features;
mod place;
mod quadric;

use std::collections::BTreeMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::{NONE, Surface};
use crate::contract::{Canceled, Run};
use builder::{Builder, mirrored};
use dense::Dense;
use features::features;
pub use place::Place;

/// How many faces make a connected component dense, and how many its proxy has.
#[derive(Debug, Clone, Copy)]
pub struct ProxySize {
    /// Faces beyond which a component gets a proxy.
    pub dense: usize,
    /// Faces of the proxy.
    pub coarse: usize,
}

impl Default for ProxySize {
    fn default() -> Self {
        Self { dense: 100_000, coarse: 8_000 }
    }
}

/// The edge is a seam of the file's own texture coordinates.
const EXISTING: u8 = 2;

/// A coarse surface, and where the fine one lies on it.
#[derive(Debug)]
pub struct Proxy {
    /// The coarse surface.
    pub surface: Arc<Surface>,
    /// The fine face that each proxy face is left of. Length: proxy faces.
    pub left_of: Vec<u32>,
    /// Whether each proxy face belongs to a component that was collapsed. Length: proxy faces.
    pub collapsed: Vec<bool>,
    /// The proxy face that each fine face lies on; [`NONE`] for faces without area. Length: fine faces.
    pub face: Vec<u32>,
    /// Where each fine vertex lies. A vertex with several fans of faces counts once for each.
    pub places: Vec<Place>,
    /// The vertex (of `places`) of each fine corner. Length: fine faces.
    pub corners: Vec<[u32; 3]>,
    /// What the proxy keeps of each fine half-edge, 0 for nothing: it is a curve that no seam moves across.
    pub features: Vec<u8>,
}

/// The proxy of a surface; `None` where no component is dense.
pub fn proxy(surface: &Surface, size: ProxySize, run: &Run) -> Result<Option<Proxy>, Canceled> {
    let roots = surface.components(|_| true);
    let mut components: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for f in (0..surface.face_count() as u32).filter(|&f| surface.usable[f as usize]) {
        components.entry(roots[f as usize]).or_default().push(f);
    }
    components.retain(|_, faces| faces.len() > size.dense);
    if components.is_empty() {
        return Ok(None);
    }
    let features = features(surface);
    let (positions, corners) = surface.sheets();
    // Of two sheets that lie on each other the second copies the first.
    let copies = |faces: &[u32]| {
        let mate = surface.sheet_mate[faces[0] as usize];
        mate != NONE && roots[mate as usize] < roots[faces[0] as usize] && is_copy(surface, faces)
    };
    let (copies, sources): (Vec<Vec<u32>>, Vec<Vec<u32>>) =
        components.into_values().partition(|faces| copies(faces));
    let dense: Result<Vec<Dense>, Canceled> = sources
        .into_par_iter()
        .map(|faces| {
            Dense::new(surface, faces, (&positions, &corners), &features, size.coarse, run)
        })
        .collect();
    let mut builder = Builder::new(surface, positions, corners, features);
    for dense in dense? {
        builder.put(&dense);
    }
    for faces in copies {
        builder.copy(&faces);
    }
    Ok(Some(builder.finish()))
}

/// Whether every face has its mate on one other component, and neighbours have neighbours.
fn is_copy(surface: &Surface, faces: &[u32]) -> bool {
    let mate = |f: u32| surface.sheet_mate[f as usize];
    let edge = |h: u32| {
        let t = surface.twin[h as usize];
        let across = surface.twin[mirrored(surface, h) as usize];
        t == across || (t != NONE && across != NONE && mate(t / 3) == across / 3)
    };
    faces.iter().all(|&f| mate(f) != NONE && mate(mate(f)) == f)
        && faces.iter().flat_map(|&f| 3 * f..3 * f + 3).all(edge)
}

#[cfg(test)]
mod tests;
