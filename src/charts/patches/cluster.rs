//! Faces into patches by bottom-up agglomeration: two neighbouring patches merge while the spread
//! of their normals stays small, cheapest merge first (after Garland, Willmott & Heckbert 2001,
//! "Hierarchical face clustering on polygonal surfaces"; doi:10.1145/364338.364345). A patch whose
//! normals lie in a cone projects to a plane without a flip, so that it always has a start map.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;

use crate::charts::part_mesh::PartMesh;
use crate::contract::{Canceled, Run};
use crate::mesh::{DisjointSets, NONE};

/// Largest spread of a patch, 1 − |ΣA n|/ΣA. A spherical cap of half-angle 45° has 0.146.
const SPREAD: f64 = 0.146;

/// Least cosine between a face's normal and its patch's mean normal.
const CONE: f64 = 0.25;

/// One cluster while it grows.
#[derive(Clone)]
struct Cluster {
    vector: DVec3,
    area: f64,
    /// All its normals lie within this angle of its mean normal (an upper bound).
    reach: f64,
    version: u32,
    faces: Vec<u32>,
}

impl Cluster {
    fn axis(&self) -> DVec3 {
        self.vector.normalize_or_zero()
    }
}

/// Cost, the two faces at an edge, and the versions of their clusters when the cost was taken.
type Entry = Reverse<(u64, u32, u32, u32, u32)>;

/// Give every local face that has no patch yet ([`NONE`]) one, numbered from `first` on in order of
/// first face. Returns the number after the last.
pub fn cluster(
    mesh: &PartMesh,
    patch_of: &mut [u32],
    first: u32,
    run: &Run,
) -> Result<u32, Canceled> {
    let n = mesh.len();
    let single = |f: usize| Cluster {
        vector: mesh.normal(f) * mesh.area(f),
        area: mesh.area(f),
        reach: 0.0,
        version: 0,
        faces: vec![f as u32],
    };
    let mut clusters: Vec<Cluster> = (0..n).map(single).collect();
    let mut sets = DisjointSets::new(n);
    let mut heap: BinaryHeap<Entry> = BinaryHeap::new();
    for (h, &t) in mesh.twin.iter().enumerate().filter(|(h, t)| **t != NONE && *h < **t as usize) {
        let (f, g) = (h / 3, t as usize / 3);
        if patch_of[f] == NONE && patch_of[g] == NONE && f != g {
            push(&mut heap, &clusters, [f as u32, g as u32], [f as u32, g as u32]);
        }
    }
    let mut steps = 0u32;
    while let Some(Reverse((_, f, g, vf, vg))) = heap.pop() {
        steps += 1;
        if steps.is_multiple_of(4096) {
            run.cancel.check()?;
        }
        let (a, b) = (sets.root(f), sets.root(g));
        if a == b {
            continue;
        }
        let version = |c: u32| clusters[c as usize].version;
        if (version(a), version(b)) != (vf, vg) {
            // Costs rise as clusters grow: the edge waits for its turn at its new one.
            push(&mut heap, &clusters, [f, g], [a, b]);
            continue;
        }
        let Some(reach) = reach(mesh, &clusters[a as usize], &clusters[b as usize]) else {
            continue;
        };
        // The larger absorbs the smaller.
        let larger = clusters[a as usize].faces.len() >= clusters[b as usize].faces.len();
        let (keep, gone) = if larger { (a, b) } else { (b, a) };
        sets.hang(gone, keep);
        let faces = std::mem::take(&mut clusters[gone as usize].faces);
        let (vector, area) = (clusters[gone as usize].vector, clusters[gone as usize].area);
        let kept = &mut clusters[keep as usize];
        kept.vector += vector;
        kept.area += area;
        kept.reach = reach;
        kept.version += 1;
        kept.faces.extend(faces);
    }
    let mut number = vec![NONE; n];
    let mut next = first;
    for (f, patch) in patch_of.iter_mut().enumerate().filter(|(_, p)| **p == NONE) {
        let root = sets.root(f as u32) as usize;
        if number[root] == NONE {
            number[root] = next;
            next += 1;
        }
        *patch = number[root];
    }
    Ok(next)
}

/// Offer to join the clusters `[a, b]` across an edge, unless the union would spread too far. Cost:
/// the area-weighted spread that the union adds, which joins flat regions first and prefers small
/// patches.
fn push(heap: &mut BinaryHeap<Entry>, clusters: &[Cluster], [f, g]: [u32; 2], [a, b]: [u32; 2]) {
    let (ca, cb) = (&clusters[a as usize], &clusters[b as usize]);
    let area = ca.area + cb.area;
    let length = (ca.vector + cb.vector).length();
    if 1.0 - length / area > SPREAD {
        return;
    }
    let added = (ca.vector.length() + cb.vector.length() - length).max(0.0);
    heap.push(Reverse((added.to_bits(), f, g, ca.version, cb.version)));
}

/// How far the normals of a union are from its mean normal, if all lie within the cone about it. The
/// faces are looked at only where the bound that the two clusters carry is not enough.
fn reach(mesh: &PartMesh, a: &Cluster, b: &Cluster) -> Option<f64> {
    let mean = (a.vector + b.vector).normalize_or_zero();
    let bound = |c: &Cluster| c.reach + c.axis().angle_between(mean);
    let most = bound(a).max(bound(b));
    if most < CONE.acos() {
        return Some(most);
    }
    let cosine = |f: &u32| mesh.normal(*f as usize).dot(mean);
    let least = a.faces.iter().chain(&b.faces).map(cosine).fold(1.0, f64::min);
    (least > CONE).then(|| least.acos())
}
