//! The triangle surface that the solvers work on. Half-edge `h = 3 f + k` runs from corner `k` of
//! face `f` to corner `(k + 1) % 3`. Vertices stand in the lexicographic order of their positions, faces
//! in that of their vertices; how the file has them is the [`Telling`](super::Telling)'s.

use glam::DVec3;

use super::DisjointSets;
use crate::contract::Repairs;

/// "No half-edge", "no face".
pub const NONE: u32 = u32::MAX;

/// A dihedral angle above this (radians) is a crease (paper 2.1.1: 30°).
pub const CREASE: f64 = std::f64::consts::PI / 6.0;

/// Where a face comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct FaceOrigin {
    /// Its number in the file, over all primitives; the first, where several stand at its place.
    pub face: u32,
    /// Index into `Scene::primitives`.
    pub primitive: u32,
    /// Material of the primitive, or [`NONE`].
    pub material: u32,
    /// Shell: faces that are connected by the file's own vertices, nothing welded but what was split for the
    /// sake of an attribute. What the author kept apart has another one.
    pub shell: u32,
}

/// A conditioned triangle surface.
#[derive(Debug, Clone, Default)]
pub struct Surface {
    /// Welded vertex positions, world units; from a corner of the object where it lies far from the origin.
    pub positions: Vec<DVec3>,
    /// Welded vertex triples, the least vertex first, consistently wound. Length: faces.
    pub triangles: Vec<[u32; 3]>,
    /// The half-edge on the other side, running the other way, or [`NONE`] at a border. At an edge
    /// of more than two faces the flattest pairs are twins. Length: 3 × faces.
    pub twin: Vec<u32>,
    /// Unit normals. Length: faces.
    pub normals: Vec<DVec3>,
    /// Areas, world units squared. Length: faces.
    pub areas: Vec<f64>,
    /// Another face at the same place, or [`NONE`]: the other side of a sheet or of a wall, or one of another
    /// material or label. Length: faces.
    pub sheet_mate: Vec<u32>,
    /// Of a cap, the face whose edge it closes, else [`NONE`]. A cap is a face without a counterpart in the file,
    /// at a vertex that lies on an edge (a T-junction), thin as a thousandth of that edge. Length: faces, or 0
    /// where there are none.
    pub closes: Vec<u32>,
    /// Whether each half-edge is a seam of the texture coordinates that the file came with. Length:
    /// 3 × faces, or 0 where there are none.
    pub existing_seams: Vec<bool>,
    /// Where each face comes from. Length: faces.
    pub origins: Vec<FaceOrigin>,
    /// Given labels, −1 unknown. Length: faces.
    pub labels: Option<Vec<i32>>,
    /// Name of each primitive of the scene, for naming parts.
    pub names: Vec<String>,
    /// Diagonal of the bounding box, world units (1 for a point).
    pub diagonal: f64,
    /// What was repaired.
    pub repairs: Repairs,
}

impl Surface {
    /// Number of faces.
    pub fn face_count(&self) -> usize {
        self.triangles.len()
    }

    /// Whether a face is a cap, which no file has.
    pub fn is_cap(&self, face: u32) -> bool {
        self.closes.get(face as usize).is_some_and(|&closed| closed != NONE)
    }

    /// For each cap the first face of the file whose edge it closes.
    pub fn closed_faces(&self) -> Vec<u64> {
        let closed = self.closes.iter().filter(|f| **f != NONE);
        closed.map(|&f| u64::from(self.origins[f as usize].face)).collect()
    }

    /// Values of the file's faces in the order of this surface.
    pub fn from_file_order<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.origins.iter().map(|origin| values[origin.face as usize]).collect()
    }

    /// Positions of a face's corners.
    pub fn corners(&self, face: usize) -> [DVec3; 3] {
        self.triangles[face].map(|v| self.positions[v as usize])
    }

    /// Centroid of a face.
    pub fn centroid(&self, face: usize) -> DVec3 {
        let [a, b, c] = self.corners(face);
        (a + b + c) / 3.0
    }

    /// First vertex of a half-edge.
    pub fn from(&self, h: u32) -> u32 {
        self.triangles[h as usize / 3][h as usize % 3]
    }

    /// Second vertex of a half-edge.
    pub fn to(&self, h: u32) -> u32 {
        self.triangles[h as usize / 3][(h as usize % 3 + 1) % 3]
    }

    /// Length of a half-edge, world units.
    pub fn length(&self, h: u32) -> f64 {
        self.positions[self.from(h) as usize].distance(self.positions[self.to(h) as usize])
    }

    /// Signed dihedral angle at a half-edge, radians: 0 where flat, positive where the surface is
    /// convex, negative where it is concave; 0 at a border.
    pub fn dihedral(&self, h: u32) -> f64 {
        let t = self.twin[h as usize];
        if t == NONE {
            return 0.0;
        }
        let (n, m) = (self.normals[h as usize / 3], self.normals[t as usize / 3]);
        let edge = self.positions[self.to(h) as usize] - self.positions[self.from(h) as usize];
        n.cross(m).dot(edge.normalize_or_zero()).atan2(n.dot(m))
    }

    /// Whether the two faces at a half-edge meet at more than 30° (paper, Eq. 1).
    pub fn is_crease(&self, h: u32) -> bool {
        self.dihedral(h).abs() > CREASE
    }

    /// The same where these faces are turned over, whole components of them. Length: faces.
    pub fn turned(mut self, faces: &[bool]) -> Self {
        // Half-edge k of [a, b, c] runs along half-edge 2 − k of [a, c, b].
        let there = |h: u32| match h {
            h if h == NONE || !faces[h as usize / 3] => h,
            h => h - h % 3 + 2 - h % 3,
        };
        for f in (0..faces.len()).filter(|&f| faces[f]) {
            self.triangles[f].swap(1, 2);
            self.normals[f] = -self.normals[f];
            self.twin.swap(3 * f, 3 * f + 2);
            if !self.existing_seams.is_empty() {
                self.existing_seams.swap(3 * f, 3 * f + 2);
            }
        }
        self.twin.iter_mut().for_each(|t| *t = there(*t));
        self
    }

    /// The connected components as meshes of their own: a vertex at which several fans of faces meet (where
    /// components touch, at bow ties) is one vertex a fan. Positions, and a triangle a face.
    pub fn sheets(&self) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let mut corners = DisjointSets::new(3 * self.face_count());
        let next = |h: u32| 3 * (h / 3) + (h + 1) % 3;
        for (h, &t) in (0u32..).zip(&self.twin).filter(|(_, t)| **t != NONE) {
            corners.join(h, next(t));
            corners.join(next(h), t);
        }
        let mut number = vec![NONE; 3 * self.face_count()];
        let mut positions = Vec::with_capacity(self.positions.len());
        let triangles = (0u32..)
            .zip(&self.triangles)
            .map(|(f, triangle)| {
                [0, 1, 2].map(|k| {
                    let root = corners.root(3 * f + k) as usize;
                    if number[root] == NONE {
                        number[root] = positions.len() as u32;
                        positions.push(self.positions[triangle[k as usize] as usize]);
                    }
                    number[root]
                })
            })
            .collect();
        (positions, triangles)
    }

    /// Connected components over the twins that `joined` lets through: of each face the lowest face of its own.
    pub fn components(&self, joined: impl Fn(u32) -> bool) -> Vec<u32> {
        let mut sets = DisjointSets::new(self.face_count());
        for (h, &t) in (0u32..).zip(&self.twin) {
            if t != NONE && h < t && joined(h) {
                sets.join(h / 3, t / 3);
            }
        }
        (0..self.face_count() as u32).map(|f| sets.root(f)).collect()
    }

    /// Total area of the faces, world units squared.
    pub fn area(&self) -> f64 {
        self.areas.iter().sum()
    }
}
