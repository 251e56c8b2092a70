//! The faces of one part with adjacency of their own: local face `i` is surface face `faces[i]`,
//! local half-edge `3 i + k` its k-th. Everything in this module works on local numbers, so that a
//! part costs what its own faces cost.

use glam::DVec3;

use crate::flatten::Disk;
use crate::mesh::{DisjointSets, NONE, Numbers, Surface};

/// A part as a mesh.
pub struct PartMesh<'a> {
    /// The surface it is a part of.
    pub surface: &'a Surface,
    /// Surface faces, ascending.
    pub faces: Vec<u32>,
    /// Local half-edge across, or [`NONE`] where the part ends. Length: 3 × faces.
    pub twin: Vec<u32>,
    /// Ambient visibility of the surface's faces, where it is known.
    pub visibility: Option<&'a [f32]>,
}

/// Faces cut open into a mesh of their own.
#[derive(Clone)]
pub struct Piece {
    /// Local faces, ascending, in the order of the disk's triangles.
    pub faces: Vec<u32>,
    /// The mesh.
    pub disk: Disk,
    /// Surface vertex of each disk vertex.
    pub vertices: Vec<u32>,
}

impl<'a> PartMesh<'a> {
    /// The mesh of some faces of a surface (ascending, usable).
    pub fn new(surface: &'a Surface, faces: Vec<u32>) -> Self {
        let mut twin = vec![NONE; 3 * faces.len()];
        for (i, &f) in faces.iter().enumerate() {
            for k in 0..3 {
                let t = surface.twin[3 * f as usize + k];
                if t != NONE
                    && let Ok(j) = faces.binary_search(&(t / 3))
                {
                    twin[3 * i + k] = 3 * j as u32 + t % 3;
                }
            }
        }
        Self { surface, faces, twin, visibility: None }
    }

    /// The same, told how well each face of the surface is seen.
    pub fn seen(self, visibility: Option<&'a [f32]>) -> Self {
        Self { visibility, ..self }
    }

    /// Number of faces.
    pub fn len(&self) -> usize {
        self.faces.len()
    }

    /// The surface's half-edge.
    pub fn surface_half_edge(&self, h: u32) -> u32 {
        3 * self.faces[h as usize / 3] + h % 3
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// Unit normal of a local face.
    pub fn normal(&self, face: usize) -> DVec3 {
        self.surface.normals[self.faces[face] as usize]
    }

    /// Area of a local face.
    pub fn area(&self, face: usize) -> f64 {
        self.surface.areas[self.faces[face] as usize]
    }

    /// Length of a local half-edge.
    pub fn length(&self, h: u32) -> f64 {
        self.surface.length(self.surface_half_edge(h))
    }

    /// Connected components of some local faces over the edges that `joined` lets through; each
    /// ascending, in order of their first face.
    pub fn components(&self, faces: &[u32], joined: impl Fn(u32) -> bool) -> Vec<Vec<u32>> {
        let mut of = vec![NONE; self.len()];
        faces.iter().for_each(|&f| of[f as usize] = NONE - 1);
        let mut pieces = Vec::new();
        let mut stack = Vec::new();
        for &seed in faces {
            if of[seed as usize] != NONE - 1 {
                continue;
            }
            let id = pieces.len() as u32;
            let mut piece = Vec::new();
            of[seed as usize] = id;
            stack.push(seed);
            while let Some(f) = stack.pop() {
                piece.push(f);
                for h in 3 * f..3 * f + 3 {
                    let t = self.twin[h as usize];
                    if t != NONE && of[t as usize / 3] == NONE - 1 && joined(h) {
                        of[t as usize / 3] = id;
                        stack.push(t / 3);
                    }
                }
            }
            piece.sort_unstable();
            pieces.push(piece);
        }
        pieces
    }

    /// Cut some local faces (ascending) open into a mesh: two corners are one vertex where a chain
    /// of `glued` edges connects them.
    pub fn cut_open(&self, faces: Vec<u32>, glued: &[bool]) -> Piece {
        self.cut_open_where(faces, |h| glued[h as usize])
    }

    /// Like [`cut_open`](Self::cut_open), asking of each half-edge that is lower than its twin whether it
    /// is glued.
    pub fn cut_open_where(&self, faces: Vec<u32>, glued: impl Fn(u32) -> bool) -> Piece {
        let mut sets = DisjointSets::new(3 * faces.len());
        let places = Numbers::of(&faces);
        for (i, &f) in faces.iter().enumerate() {
            for k in 0..3u32 {
                let h = 3 * f + k;
                let t = self.twin[h as usize];
                if t == NONE || t < h || !glued(h) {
                    continue;
                }
                let (i, j, l) = (i as u32, places.get(t / 3), t % 3);
                if j == NONE {
                    continue;
                }
                sets.join(3 * i + k, 3 * j + (l + 1) % 3);
                sets.join(3 * i + (k + 1) % 3, 3 * j + l);
            }
        }
        let mut number = vec![NONE; 3 * faces.len()];
        let mut positions = Vec::new();
        let mut vertices = Vec::new();
        let mut triangles = Vec::with_capacity(faces.len());
        for (i, &f) in faces.iter().enumerate() {
            let triangle = self.surface.triangles[self.faces[f as usize] as usize];
            triangles.push([0, 1, 2].map(|k| {
                let root = sets.root((3 * i + k) as u32) as usize;
                if number[root] == NONE {
                    number[root] = positions.len() as u32;
                    positions.push(self.surface.positions[triangle[k] as usize]);
                    vertices.push(triangle[k]);
                }
                number[root]
            }));
        }
        Piece { faces, disk: Disk::new(positions, triangles), vertices }
    }
}
