//! The proxy of a dense surface (docs/coarse_to_fine.md): each connected component of many faces collapsed
//! to few, the others as they are. It is what is sampled, segmented and cut; what is found there is carried
//! back over the record, which says where on the proxy each fine vertex and face lies.

mod collapse;
mod features;
mod place;
mod quadric;

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::{DisjointSets, NONE, Surface};
use crate::contract::{Canceled, Run};
use collapse::{Collapsed, Sheet, collapse};
use features::features;

use place::Locator;
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
    let mut sets = DisjointSets::new(surface.face_count());
    for (h, &t) in (0u32..).zip(&surface.twin).filter(|(_, t)| **t != NONE) {
        sets.join(h / 3, t / 3);
    }
    let roots: Vec<u32> = (0..surface.face_count() as u32).map(|f| sets.root(f)).collect();
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

/// The half-edge of its face's mate that runs along a half-edge the other way.
fn mirrored(surface: &Surface, h: u32) -> u32 {
    let (mate, end) = (surface.sheet_mate[h as usize / 3], surface.to(h));
    let triangle = surface.triangles[mate as usize];
    3 * mate + triangle.iter().position(|&v| v == end).unwrap_or(0) as u32
}

/// A component that was collapsed; its faces and vertices have numbers of their own.
struct Dense {
    faces: Vec<u32>,
    vertices: Vec<u32>,
    collapsed: Collapsed,
    /// The face that each of its faces lies on.
    face: Vec<u32>,
    /// Where each of its vertices lies.
    places: Vec<Place>,
}

impl Dense {
    fn new(
        surface: &Surface,
        faces: Vec<u32>,
        (positions, corners): (&[DVec3], &[[u32; 3]]),
        features: &[u8],
        coarse: usize,
        run: &Run,
    ) -> Result<Self, Canceled> {
        let mut vertices: Vec<u32> = faces.iter().flat_map(|&f| corners[f as usize]).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let local = |v: u32| vertices.binary_search(&v).unwrap_or(0) as u32;
        let across = |h: u32| match surface.twin[h as usize] {
            NONE => NONE,
            t => faces.binary_search(&(t / 3)).map_or(NONE, |g| 3 * g as u32 + t % 3),
        };
        let half_edges = || faces.iter().flat_map(|&f| 3 * f..3 * f + 3);
        // Quadrics are exact only near the origin.
        let centre = surface.centroid(faces[faces.len() / 2] as usize);
        let sheet = Sheet {
            positions: vertices.iter().map(|&v| positions[v as usize] - centre).collect(),
            triangles: faces.iter().map(|&f| corners[f as usize].map(local)).collect(),
            twin: half_edges().map(across).collect(),
            feature: half_edges().map(|h| features[h as usize]).collect(),
        };
        let fine = sheet.clone();
        let collapsed = collapse(sheet, coarse, &run.cancel)?;
        let (face, places) = locate(&fine, &collapsed);
        let mut collapsed = collapsed;
        collapsed.sheet.positions.iter_mut().for_each(|p| *p += centre);
        run.cancel.check()?;
        Ok(Self { faces, vertices, collapsed, face, places })
    }
}

/// The place of each face's middle (its face), and of each vertex, on what is left of a sheet.
fn locate(fine: &Sheet, collapsed: &Collapsed) -> (Vec<u32>, Vec<Place>) {
    let sheet = &collapsed.sheet;
    let normal = |t: &[u32; 3], positions: &[DVec3]| {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        (b - a).cross(c - a)
    };
    let normals: Vec<DVec3> =
        sheet.triangles.iter().map(|t| normal(t, &sheet.positions).normalize_or_zero()).collect();
    let locator = Locator { collapsed, normals: &normals };
    // Faces within one outline of features stay within it.
    let mut sets = DisjointSets::new(fine.triangles.len());
    for (h, &t) in (0u32..).zip(&fine.twin) {
        if t != NONE && fine.feature[h as usize] == 0 {
            sets.join(h / 3, t / 3);
        }
    }
    let within: Vec<u32> = (0..fine.triangles.len() as u32).map(|f| sets.root(f)).collect();
    let mut outwards = vec![DVec3::ZERO; fine.positions.len()];
    let mut inside = vec![NONE; fine.positions.len()];
    for (t, &of) in fine.triangles.iter().zip(&within) {
        let normal = normal(t, &fine.positions);
        for &v in t {
            outwards[v as usize] += normal;
            // Several outlines meet at a feature.
            inside[v as usize] = match inside[v as usize] {
                NONE => of,
                same if same == of => of,
                _ => NONE - 1,
            };
        }
    }
    let face = |(t, &of): (&[u32; 3], &u32)| {
        let middle = t.iter().map(|&v| fine.positions[v as usize]).sum::<DVec3>() / 3.0;
        let place =
            locator.find(t, middle, normal(t, &fine.positions), |f| within[f as usize] == of);
        place.map_or(NONE, |p| p.face)
    };
    let faces: Vec<u32> = fine.triangles.par_iter().zip(&within).map(face).collect();
    let place = |v: usize| {
        let allowed = |f: u32| inside[v] == NONE - 1 || within[f as usize] == inside[v];
        locator.find(&[v as u32], fine.positions[v], outwards[v], allowed).unwrap_or_default()
    };
    let places = (0..fine.positions.len()).into_par_iter().map(place).collect();
    (faces, places)
}

/// A proxy in the making. Vertices and faces have the fine surface's numbers until it is finished.
struct Builder<'a> {
    surface: &'a Surface,
    positions: Vec<DVec3>,
    corners: Vec<[u32; 3]>,
    features: Vec<u8>,
    triangles: Vec<[u32; 3]>,
    twin: Vec<u32>,
    left: Vec<bool>,
    collapsed: Vec<bool>,
    existing: Vec<bool>,
    face: Vec<u32>,
    places: Vec<Place>,
}

impl<'a> Builder<'a> {
    /// Everything as it is.
    fn new(
        surface: &'a Surface,
        positions: Vec<DVec3>,
        corners: Vec<[u32; 3]>,
        features: Vec<u8>,
    ) -> Self {
        let mut places = vec![Place::default(); positions.len()];
        for (f, t) in (0u32..).zip(&corners).filter(|(f, _)| surface.usable[*f as usize]) {
            for (k, &v) in t.iter().enumerate() {
                let mut weights = [0.0; 3];
                weights[k] = 1.0;
                places[v as usize] = Place { face: f, weights };
            }
        }
        let face = |(f, &usable): (u32, &bool)| if usable { f } else { NONE };
        Self {
            triangles: corners.clone(),
            twin: surface.twin.clone(),
            left: surface.usable.clone(),
            collapsed: vec![false; surface.face_count()],
            existing: surface.existing_seams.clone(),
            face: (0u32..).zip(&surface.usable).map(face).collect(),
            surface,
            positions,
            corners,
            features,
            places,
        }
    }

    /// What is left of a component takes its place.
    fn put(&mut self, dense: &Dense) {
        let Dense { faces, vertices, collapsed, .. } = dense;
        let half_edge = |h: u32| match h {
            NONE => NONE,
            h => 3 * faces[h as usize / 3] + h % 3,
        };
        for (i, &f) in faces.iter().enumerate() {
            self.left[f as usize] = collapsed.alive[i];
            self.collapsed[f as usize] = true;
            self.face[f as usize] = match dense.face[i] {
                NONE => NONE,
                on => faces[on as usize],
            };
            self.triangles[f as usize] = collapsed.sheet.triangles[i].map(|v| vertices[v as usize]);
            for k in 0..3 {
                let (h, at) = (3 * i + k, 3 * f as usize + k);
                self.twin[at] = half_edge(collapsed.sheet.twin[h]);
                if !self.existing.is_empty() {
                    self.existing[at] = collapsed.sheet.feature[h] & EXISTING != 0;
                }
            }
        }
        for (i, &v) in vertices.iter().enumerate() {
            self.positions[v as usize] = collapsed.sheet.positions[i];
            let Place { face, weights } = dense.places[i];
            self.places[v as usize] = Place { face: faces[face as usize], weights };
        }
    }

    /// A component gets what is left of the one that it lies on, turned over.
    fn copy(&mut self, faces: &[u32]) {
        let surface = self.surface;
        // Corner of the mate that lies where a corner of the face lies.
        let corner = |f: u32, k: usize| {
            let mate = surface.sheet_mate[f as usize];
            let vertex = surface.triangles[f as usize][k];
            surface.triangles[mate as usize].iter().position(|&v| v == vertex).unwrap_or(0)
        };
        for &f in faces {
            let mate = surface.sheet_mate[f as usize] as usize;
            self.left[f as usize] = self.left[mate];
            self.collapsed[f as usize] = true;
            let on = self.face[mate];
            self.face[f as usize] = if on == NONE { NONE } else { surface.sheet_mate[on as usize] };
            self.triangles[f as usize] = [0, 1, 2].map(|k| self.triangles[mate][corner(f, k)]);
            for k in 0..3 {
                let h = 3 * f + k as u32;
                let other = mirrored(surface, h) as usize;
                self.twin[h as usize] = match self.twin[other] {
                    NONE => NONE,
                    t => mirrored(surface, t),
                };
                if !self.existing.is_empty() {
                    self.existing[h as usize] = self.existing[other];
                }
                let place = self.places[self.corners[mate][corner(f, k)] as usize];
                let there = surface.sheet_mate[place.face as usize];
                let weights = [0, 1, 2].map(|j| place.weights[corner(there, j)]);
                self.places[self.corners[f as usize][k] as usize] = Place { face: there, weights };
            }
        }
    }

    /// Number faces and vertices anew.
    fn finish(self) -> Proxy {
        let Self { surface, left, positions, triangles, .. } = self;
        let left_of: Vec<u32> = (0..left.len() as u32).filter(|&f| left[f as usize]).collect();
        let mut number = vec![NONE; left.len()];
        (0u32..).zip(&left_of).for_each(|(i, &f)| number[f as usize] = i);
        let mut vertex = vec![NONE; positions.len()];
        let mut kept = Vec::new();
        let mut place = |v: u32| {
            if vertex[v as usize] == NONE {
                vertex[v as usize] = kept.len() as u32;
                kept.push(positions[v as usize]);
            }
            vertex[v as usize]
        };
        let triangles: Vec<[u32; 3]> =
            left_of.iter().map(|&f| triangles[f as usize].map(&mut place)).collect();
        let half_edge = |h: u32| match h {
            NONE => NONE,
            h => 3 * number[h as usize / 3] + h % 3,
        };
        let half_edges = || left_of.iter().flat_map(|&f| 3 * f as usize..3 * f as usize + 3);
        let cross = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| kept[v as usize]);
            (b - a).cross(c - a)
        };
        let mate = |&f: &u32| match surface.sheet_mate[f as usize] {
            NONE => NONE,
            mate => {
                // Only of what is a copy, or stands as it is.
                let mate = number[mate as usize];
                let own = &triangles[number[f as usize] as usize];
                let same = mate != NONE && own.iter().all(|v| triangles[mate as usize].contains(v));
                let as_is = !self.collapsed[f as usize];
                if mate != NONE && (same || as_is) { mate } else { NONE }
            }
        };
        let number_of = |f: u32| if f == NONE { NONE } else { number[f as usize] };
        let coarse = Surface {
            twin: half_edges().map(|h| half_edge(self.twin[h])).collect(),
            reversed: left_of.iter().map(|&f| surface.reversed[f as usize]).collect(),
            usable: vec![true; left_of.len()],
            normals: triangles.iter().map(|t| cross(t).normalize_or_zero()).collect(),
            areas: triangles.iter().map(|t| 0.5 * cross(t).length()).collect(),
            sheet_mate: left_of.iter().map(mate).collect(),
            existing_seams: match self.existing.is_empty() {
                true => Vec::new(),
                false => half_edges().map(|h| self.existing[h]).collect(),
            },
            origins: left_of.iter().map(|&f| surface.origins[f as usize]).collect(),
            labels: surface
                .labels
                .as_ref()
                .map(|labels| left_of.iter().map(|&f| labels[f as usize]).collect()),
            names: surface.names.clone(),
            diagonal: surface.diagonal,
            repairs: surface.repairs,
            positions: kept,
            triangles,
        };
        let places = self.places.into_iter();
        Proxy {
            surface: Arc::new(coarse),
            collapsed: left_of.iter().map(|&f| self.collapsed[f as usize]).collect(),
            face: self.face.into_iter().map(number_of).collect(),
            places: places.map(|p| Place { face: number_of(p.face), ..p }).collect(),
            left_of,
            corners: self.corners,
            features: self.features,
        }
    }
}

#[cfg(test)]
mod tests;
