//! The proxy put together: what is left of dense components in the place of their faces, and all else as it
//! is.

use std::sync::Arc;

use glam::DVec3;

use super::dense::Dense;
use super::{EXISTING, Place, Proxy};
use crate::mesh::{NONE, Surface};

/// A proxy in the making. Vertices and faces have the fine surface's numbers until it is finished.
pub struct Builder<'a> {
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
    pub fn new(
        surface: &'a Surface,
        positions: Vec<DVec3>,
        corners: Vec<[u32; 3]>,
        features: Vec<u8>,
    ) -> Self {
        let mut places = vec![Place::default(); positions.len()];
        for (f, t) in (0u32..).zip(&corners) {
            for (k, &v) in t.iter().enumerate() {
                let mut weights = [0.0; 3];
                weights[k] = 1.0;
                places[v as usize] = Place { face: f, weights };
            }
        }
        let count = surface.face_count();
        Self {
            triangles: corners.clone(),
            twin: surface.twin.clone(),
            left: vec![true; count],
            collapsed: vec![false; count],
            existing: surface.existing_seams.clone(),
            face: (0..count as u32).collect(),
            surface,
            positions,
            corners,
            features,
            places,
        }
    }

    /// What is left of a component takes its place.
    pub fn put(&mut self, dense: &Dense) {
        let Dense { faces, vertices, collapsed, .. } = dense;
        let half_edge = |h: u32| match h {
            NONE => NONE,
            h => 3 * faces[h as usize / 3] + h % 3,
        };
        for (i, &f) in faces.iter().enumerate() {
            self.left[f as usize] = collapsed.alive[i];
            self.collapsed[f as usize] = true;
            self.face[f as usize] = faces[dense.face[i] as usize];
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

    /// Number faces and vertices anew.
    pub fn finish(self) -> Proxy {
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
            // What was collapsed stands where nothing else does.
            mate => match self.collapsed[f as usize] || self.collapsed[mate as usize] {
                true => NONE,
                false => number[mate as usize],
            },
        };
        let coarse = Surface {
            twin: half_edges().map(|h| half_edge(self.twin[h])).collect(),
            normals: triangles.iter().map(|t| cross(t).normalize_or_zero()).collect(),
            areas: triangles.iter().map(|t| 0.5 * cross(t).length()).collect(),
            sheet_mate: left_of.iter().map(mate).collect(),
            closes: Vec::new(),
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
            face: self.face.into_iter().map(|f| number[f as usize]).collect(),
            places: places.map(|p| Place { face: number[p.face as usize], ..p }).collect(),
            left_of,
            corners: self.corners,
            features: self.features,
        }
    }
}
