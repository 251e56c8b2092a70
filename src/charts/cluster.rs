//! Faces into patches by bottom-up agglomeration: two neighbouring patches merge while the spread
//! of their normals stays small, cheapest merge first (after Garland, Willmott & Heckbert 2001,
//! "Hierarchical face clustering on polygonal surfaces"; doi:10.1145/364338.364345). A patch whose
//! normals lie in a cone projects to a plane without a flip, so that it always has a start map.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;

use super::part_mesh::PartMesh;
use crate::contract::{Canceled, Run};
use crate::mesh::NONE;

/// Largest spread of a patch, 1 − |ΣA n|/ΣA. A spherical cap of half-angle 45° has 0.146.
const SPREAD: f64 = 0.146;

/// Least cosine between a face's normal and its patch's mean normal.
const CONE: f64 = 0.25;

/// One cluster while it grows.
#[derive(Clone)]
struct Cluster {
    vector: DVec3,
    area: f64,
    version: u32,
    faces: Vec<u32>,
    neighbours: Vec<u32>,
}

/// Give every local face that has no patch yet ([`NONE`]) one, numbered from `first` on in order of
/// first face. Returns the number after the last.
pub fn cluster(
    mesh: &PartMesh,
    patch_of: &mut [u32],
    first: u32,
    run: &Run,
) -> Result<u32, Canceled> {
    let n = mesh.len();
    let free = |f: usize| patch_of[f] == NONE;
    let mut clusters: Vec<Cluster> = (0..n)
        .map(|f| Cluster {
            vector: mesh.normal(f) * mesh.area(f),
            area: mesh.area(f),
            version: 0,
            faces: vec![f as u32],
            neighbours: (0..3)
                .map(|k| mesh.twin[3 * f + k])
                .filter(|&t| t != NONE && free(f) && free(t as usize / 3))
                .map(|t| t / 3)
                .collect(),
        })
        .collect();
    let mut owner: Vec<u32> = (0..n as u32).collect();
    let mut heap = BinaryHeap::new();
    for f in 0..n as u32 {
        for &g in &clusters[f as usize].neighbours.clone() {
            if f < g {
                push(&mut heap, &clusters, f, g);
            }
        }
    }
    let mut steps = 0u32;
    while let Some(Reverse((_, a, b, va, vb))) = heap.pop() {
        steps += 1;
        if steps.is_multiple_of(4096) {
            run.cancel.check()?;
        }
        let (ca, cb) = (&clusters[a as usize], &clusters[b as usize]);
        if ca.version != va || cb.version != vb || !in_cone(mesh, ca, cb) {
            continue;
        }
        // The larger absorbs the smaller.
        let (keep, gone) = if ca.faces.len() >= cb.faces.len() { (a, b) } else { (b, a) };
        let absorbed = std::mem::replace(
            &mut clusters[gone as usize],
            Cluster {
                vector: DVec3::ZERO,
                area: 0.0,
                version: u32::MAX,
                faces: vec![],
                neighbours: vec![],
            },
        );
        absorbed.faces.iter().for_each(|&f| owner[f as usize] = keep);
        let kept = &mut clusters[keep as usize];
        kept.vector += absorbed.vector;
        kept.area += absorbed.area;
        kept.version += 1;
        kept.faces.extend(absorbed.faces);
        kept.neighbours.extend(absorbed.neighbours);
        kept.neighbours.iter_mut().for_each(|g| *g = owner[*g as usize]);
        kept.neighbours.sort_unstable();
        kept.neighbours.dedup();
        kept.neighbours.retain(|&g| g != keep);
        for &g in &kept.neighbours.clone() {
            push(&mut heap, &clusters, keep.min(g), keep.max(g));
        }
    }
    let mut number = vec![NONE; n];
    let mut next = first;
    for (patch, &o) in patch_of.iter_mut().zip(&owner).filter(|(p, _)| **p == NONE) {
        if number[o as usize] == NONE {
            number[o as usize] = next;
            next += 1;
        }
        *patch = number[o as usize];
    }
    Ok(next)
}

type Entry = Reverse<(u64, u32, u32, u32, u32)>;

/// Offer a merge, unless the union would spread too far. Cost: the area-weighted spread that the
/// merge adds, which makes flat regions first and prefers small patches.
fn push(heap: &mut BinaryHeap<Entry>, clusters: &[Cluster], a: u32, b: u32) {
    let (ca, cb) = (&clusters[a as usize], &clusters[b as usize]);
    let area = ca.area + cb.area;
    let length = (ca.vector + cb.vector).length();
    if 1.0 - length / area > SPREAD {
        return;
    }
    let added = (ca.vector.length() + cb.vector.length() - length).max(0.0);
    heap.push(Reverse((added.to_bits(), a, b, ca.version, cb.version)));
}

/// Whether all faces of a union lie within the cone about its mean normal.
fn in_cone(mesh: &PartMesh, a: &Cluster, b: &Cluster) -> bool {
    let mean = (a.vector + b.vector).normalize_or_zero();
    let inside = |f: &u32| mesh.normal(*f as usize).dot(mean) > CONE;
    a.faces.iter().all(inside) && b.faces.iter().all(inside)
}
