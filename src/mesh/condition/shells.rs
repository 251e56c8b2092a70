//! Shells: what the file's own vertices hold together. A vertex that was split for the sake of a normal, a
//! texture coordinate or a colour holds all the same, and so does every one if most faces are in shells of but a
//! few: a soup says nothing of what belongs together. And solids: shells that lie on each other for the most
//! part are the two sides of one thing, or copies of it.

use std::collections::BTreeMap;

use super::file::FileFaces;
use super::pairing::EdgeGroups;
use super::places::Places;
use crate::mesh::{DisjointSets, Scene};

/// Faces that the shell of half of the faces has at least where shells mean something.
const SOUP: usize = 8;

/// Share of the smaller of two shells that lies on the other from which on they are one solid.
const ONE: f64 = 0.98;

/// Shell and solid of each face of the file.
pub struct Shells {
    /// Shell of each, numbered in order of first face.
    pub shell: Vec<u32>,
    /// The first shell of its solid.
    pub solid: Vec<u32>,
}

impl Shells {
    /// Find them. `groups`: the edges of the places.
    pub fn of(scene: &Scene, file: &FileFaces, places: &Places, groups: &EdgeGroups) -> Self {
        let mut sets = DisjointSets::new(file.source.len());
        for t in &file.triangles {
            sets.join(t[0], t[1]);
            sets.join(t[1], t[2]);
        }
        let vertex = |c: u32| file.triangles[c as usize / 3][c as usize % 3];
        for group in groups.iter() {
            if let [a, b] = *group {
                let ends = ends(file, places, a, b);
                let primitive = |c: u32| file.origins[c as usize / 3].primitive;
                let in_one = primitive(ends[0].0) == primitive(ends[0].1);
                if in_one && ends.iter().any(|&(v, w)| is_explained(scene, file, v, w)) {
                    ends.iter().for_each(|&(v, w)| {
                        sets.join(vertex(v), vertex(w));
                    });
                }
            }
        }
        let mut counts: BTreeMap<u32, usize> = BTreeMap::new();
        for t in &file.triangles {
            *counts.entry(sets.root(t[0])).or_default() += 1;
        }
        let few: usize = counts.into_values().filter(|&count| count < SOUP).sum();
        if 2 * few > file.triangles.len() {
            for group in groups.iter() {
                for pair in group.windows(2) {
                    for (v, w) in ends(file, places, pair[0], pair[1]) {
                        sets.join(vertex(v), vertex(w));
                    }
                }
            }
            // What stands at one place belongs to one.
            for instances in places.iter() {
                let at = |i: usize| file.triangles[instances[i].face as usize][0];
                (1..instances.len()).for_each(|i| {
                    sets.join(at(0), at(i));
                });
            }
        }
        let mut number = BTreeMap::new();
        let shell: Vec<u32> = file
            .triangles
            .iter()
            .map(|t| {
                let next = number.len() as u32;
                *number.entry(sets.root(t[0])).or_insert(next)
            })
            .collect();
        let solid = solids(file, places, &shell, number.len());
        Self { shell, solid }
    }
}

/// The solid of each face: shells that lie on each other are one.
fn solids(file: &FileFaces, places: &Places, shell: &[u32], count: usize) -> Vec<u32> {
    let mut area = vec![0.0; count];
    let mut common: BTreeMap<(u32, u32), f64> = BTreeMap::new();
    for instances in places.iter() {
        let [a, b, c] = file.corners(instances[0].face as usize);
        let own = 0.5 * (b - a).cross(c - a).length();
        let mut here: Vec<u32> = instances.iter().map(|i| shell[i.face as usize]).collect();
        here.sort_unstable();
        here.dedup();
        for (i, &s) in here.iter().enumerate() {
            area[s as usize] += own;
            here[..i].iter().for_each(|&r| *common.entry((r, s)).or_default() += own);
        }
    }
    let mut sets = DisjointSets::new(count);
    for ((r, s), common) in common {
        if common >= ONE * area[r as usize].min(area[s as usize]) {
            sets.join(r, s);
        }
    }
    shell.iter().map(|&s| sets.root(s)).collect()
}

/// The corners (3 times the face of the file, and which) at both ends of an edge, on the faces of two
/// half-edges of places.
fn ends(file: &FileFaces, places: &Places, a: u32, b: u32) -> [(u32, u32); 2] {
    let face = |h: u32| places.instances(h as usize / 3)[0];
    let (f, g) = (face(a), face(b));
    let edge = [0, 1].map(|k| f.vertices[(a as usize % 3 + k) % 3]);
    let corner = |face: u32, vertex: u32| {
        let k = file.welded[face as usize].iter().position(|&v| v == vertex).unwrap_or(0);
        3 * face + k as u32
    };
    edge.map(|vertex| (corner(f.face, vertex), corner(g.face, vertex)))
}

/// Whether two corners of one primitive at one place have vertices that differ in something besides: then that is
/// why they are two.
fn is_explained(scene: &Scene, file: &FileFaces, c: u32, d: u32) -> bool {
    let primitive = &scene.primitives[file.origins[c as usize / 3].primitive as usize];
    let corner = |c: u32| {
        let (origin, k) = (&file.origins[c as usize / 3], c as usize % 3);
        let vertex = file.triangles[c as usize / 3][k];
        (vertex, (origin.face - file.first_face(origin.primitive)) as usize, k)
    };
    let ((v, f, k), (w, g, l)) = (corner(c), corner(d));
    let [a, b] = [v, w].map(|v| file.source[v as usize].1);
    v != w
        && primitive.attributes.iter().any(|attribute| {
            match (attribute.index(f, k, a), attribute.index(g, l, b)) {
                (Some(i), Some(j)) if i != j => {
                    let value = |i, n| attribute.values.value(i, n);
                    (0..attribute.values.width()).any(|n| value(i, n) != value(j, n))
                }
                (Some(_), Some(_)) | (None, None) => false,
                _ => true,
            }
        })
}
