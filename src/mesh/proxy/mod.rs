//! The proxy of a dense surface (docs/coarse_to_fine.md): each connected component of many faces collapsed
//! to few, the others as they are. It is what is sampled, segmented and cut; what is found there is carried
//! back over the record, which says where on the proxy each fine vertex and face lies.

mod builder;
mod collapse;
mod denoise;
mod dense;
mod features;
mod place;
mod quadric;

use std::collections::BTreeMap;
use std::sync::Arc;

use super::{NONE, Surface};
use crate::contract::{Canceled, Run};
use builder::Builder;
use dense::Dense;
use features::features;

use crate::tasks;
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
        Self { dense: 12_000, coarse: 8_000 }
    }
}

/// Faces of a rough component for each of its proxy at least, so that noise of single edges is gone.
const FEWER: usize = 6;

/// A component is rough where half of its edges bend by more than the angle of this 1 − cos (8°).
const ROUGH: f64 = 0.01;

/// Whether most edges of a component bend, as noise bends them: smooth shapes and flat ones do not.
fn is_rough(surface: &Surface, faces: &[u32]) -> bool {
    let bend = |h: u32| {
        let t = surface.twin[h as usize];
        let normal = |h: u32| surface.normals[h as usize / 3];
        (t != NONE && t > h).then(|| 1.0 - normal(h).dot(normal(t)))
    };
    let mut bends: Vec<f64> =
        faces.iter().flat_map(|&f| 3 * f..3 * f + 3).filter_map(bend).collect();
    let half = bends.len() / 2;
    half > 0 && *bends.select_nth_unstable_by(half, f64::total_cmp).1 > ROUGH
}

/// Faces that a proxy has at least for each hole and handle.
const FACES_A_HOLE: i64 = 150;

/// A component stays as it is where more than so many times the faces of a proxy are left.
const REACHED: f64 = 1.5;

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
    /// The proxy face that each fine face lies on. Length: fine faces.
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
    let roots = tasks::link("components", || surface.components(|_| true));
    let mut components: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for f in 0..surface.face_count() as u32 {
        components.entry(roots[f as usize]).or_default().push(f);
    }
    components.retain(|_, faces| faces.len() > size.dense);
    if components.is_empty() {
        return Ok(None);
    }
    let features = tasks::link("features", || features(surface));
    let (positions, corners) = surface.sheets();
    // Lace has no coarse form: too few faces would be left for each of its holes. Nor do many T-junctions, whose
    // caps are thinner than anything that a proxy keeps.
    components.retain(|_, faces| {
        let caps = faces.iter().filter(|&&f| surface.is_cap(f)).count() as i64;
        let holes = 2 - euler(surface, faces, &corners) + caps;
        holes * FACES_A_HOLE <= size.coarse as i64
    });
    if components.is_empty() {
        return Ok(None);
    }
    let collapse = |faces: Vec<u32>| {
        let rough = is_rough(surface, &faces);
        let coarse = if rough { size.coarse.min(faces.len() / FEWER) } else { size.coarse };
        let mut dense = Dense::new(surface, faces, (&positions, &corners), &features, coarse, run)?;
        if rough {
            denoise::denoise(&mut dense.collapsed);
        }
        Ok(dense)
    };
    let components: Vec<Vec<u32>> = components.into_values().collect();
    let dense: Result<Vec<Dense>, Canceled> =
        tasks::map_by_size("dense", components, Vec::len, collapse).into_iter().collect();
    // What could not be collapsed stays as it is.
    let reached = |dense: &Dense| {
        let left = dense.collapsed.alive.iter().filter(|alive| **alive).count();
        left as f64 <= REACHED * size.coarse as f64
    };
    let dense: Vec<Dense> = dense?.into_iter().filter(reached).collect();
    if dense.is_empty() {
        return Ok(None);
    }
    let mut builder = Builder::new(surface, positions, corners, features);
    Ok(Some(tasks::link("proxy", || {
        dense.iter().for_each(|dense| builder.put(dense));
        builder.finish()
    })))
}

/// Euler characteristic of a component.
fn euler(surface: &Surface, faces: &[u32], corners: &[[u32; 3]]) -> i64 {
    let mut vertices: Vec<u32> = faces.iter().flat_map(|&f| corners[f as usize]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let half_edges = faces.iter().flat_map(|&f| 3 * f..3 * f + 3);
    let once = |&h: &u32| surface.twin[h as usize] == NONE || surface.twin[h as usize] > h;
    vertices.len() as i64 - half_edges.filter(once).count() as i64 + faces.len() as i64
}

#[cfg(test)]
mod tests;
