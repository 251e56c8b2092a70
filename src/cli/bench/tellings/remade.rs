//! Tellings with other vertices and faces: divided, moved, split, with more beside.

use std::collections::BTreeMap;

use glam::DVec3;

use super::mesh::PlainMesh;
use crate::device::Seeded;
use crate::mesh::DisjointSets;

/// The number that vertices at one place have in common: the first of them.
pub fn places(mesh: &PlainMesh) -> Vec<u32> {
    let mut first = BTreeMap::new();
    let key = |p: &DVec3| (*p + 0.0).to_array().map(f64::to_bits);
    (0u32..).zip(&mesh.positions).map(|(v, p)| *first.entry(key(p)).or_insert(v)).collect()
}

/// Each face in four.
pub fn in_four(mesh: &PlainMesh) -> PlainMesh {
    let mut positions = mesh.positions.clone();
    let mut middles = BTreeMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            positions.push(0.5 * (mesh.positions[a as usize] + mesh.positions[b as usize]));
            positions.len() as u32 - 1
        })
    };
    let mut faces = Vec::new();
    for (f, &[a, b, c]) in (0u32..).zip(&mesh.triangles) {
        let [x, y, z] = [middle(a, b), middle(b, c), middle(c, a)];
        faces.extend([[a, x, z], [b, y, x], [c, z, y], [x, y, z]].map(|t| (f, t)));
    }
    PlainMesh { positions, ..mesh.with(faces.into_iter()) }
}

/// One draw a place: a normal deviate a coordinate of 1e-4 of the diagonal, or so many times the shortest mean
/// edge of the faces around it, if that is less.
pub fn noisy(mesh: &PlainMesh, of_edges: f64, random: &mut Seeded) -> PlainMesh {
    let place = places(mesh);
    let mut shortest = vec![f64::INFINITY; mesh.positions.len()];
    for (f, t) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = mesh.corners(f);
        let mean = (a.distance(b) + b.distance(c) + c.distance(a)) / 3.0;
        for &v in t {
            let own = &mut shortest[place[v as usize] as usize];
            *own = own.min(mean);
        }
    }
    let most = 1e-4 * mesh.diagonal();
    // The sum of twelve uniform numbers is nearly normal.
    let mut normal = || (0..12).map(|_| random.unit_f64()).sum::<f64>() - 6.0;
    let by: Vec<DVec3> = shortest
        .iter()
        .map(|edge| most.min(of_edges * edge) * DVec3::new(normal(), normal(), normal()))
        .collect();
    let moved = place.iter().zip(&mesh.positions).map(|(&first, p)| *p + by[first as usize]);
    PlainMesh { positions: moved.collect(), ..mesh.clone() }
}

/// Edges that bend more are hard (cosine of 40°).
const HARD: f64 = 0.766;

/// The pairs of faces that share an edge of two of one primitive.
fn edges(mesh: &PlainMesh) -> BTreeMap<(u32, u32), Vec<u32>> {
    let mut edges: BTreeMap<(u32, u32), Vec<u32>> = BTreeMap::new();
    for (f, t) in (0u32..).zip(&mesh.triangles) {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            edges.entry((a.min(b), a.max(b))).or_default().push(f);
        }
    }
    edges
}

/// Vertices split at hard edges, with normals.
pub fn split(mesh: &PlainMesh) -> PlainMesh {
    let normal = |f: u32| {
        let [a, b, c] = mesh.corners(f as usize);
        (b - a).cross(c - a)
    };
    let mut corners = DisjointSets::new(3 * mesh.triangles.len());
    let corner = |f: u32, v: u32| {
        let k = mesh.triangles[f as usize].iter().position(|&w| w == v).unwrap_or(0);
        3 * f + k as u32
    };
    for ((a, b), faces) in edges(mesh) {
        if let [f, g] = faces[..]
            && normal(f).normalize_or_zero().dot(normal(g).normalize_or_zero()) >= HARD
        {
            for v in [a, b] {
                corners.join(corner(f, v), corner(g, v));
            }
        }
    }
    let roots: Vec<u32> = (0..3 * mesh.triangles.len() as u32).map(|c| corners.root(c)).collect();
    let mut sums: BTreeMap<u32, DVec3> = BTreeMap::new();
    for (c, &root) in (0u32..).zip(&roots) {
        *sums.entry(root).or_default() += normal(c / 3);
    }
    let vertex: BTreeMap<u32, u32> = sums.keys().copied().zip(0..).collect();
    let at = |c: u32| mesh.triangles[c as usize / 3][c as usize % 3] as usize;
    let of = |f: u32| [0, 1, 2].map(|k| roots[(3 * f + k) as usize]);
    let faces = || 0..mesh.triangles.len() as u32;
    PlainMesh {
        positions: sums.keys().map(|&c| mesh.positions[at(c)]).collect(),
        normals: faces().map(|f| of(f).map(|root| sums[&root].normalize_or_zero())).collect(),
        triangles: faces().map(|f| of(f).map(|root| vertex[&root])).collect(),
        ..mesh.clone()
    }
}

/// A tenth of the inner edges divided on one side only.
pub fn t_junctions(mesh: &PlainMesh, random: &mut Seeded) -> PlainMesh {
    let mut positions = mesh.positions.clone();
    let mut cut = vec![None; mesh.triangles.len()];
    for ((a, b), faces) in edges(mesh) {
        // The first of its faces is divided, if it is whole.
        if let [f, _] = faces[..]
            && random.unit_f64() < 0.1
            && cut[f as usize].is_none()
        {
            positions.push(0.5 * (mesh.positions[a as usize] + mesh.positions[b as usize]));
            cut[f as usize] = Some((a, b, positions.len() as u32 - 1));
        }
    }
    let mut faces = Vec::new();
    for (f, t) in (0u32..).zip(&mesh.triangles) {
        let Some((a, b, middle)) = cut[f as usize] else {
            faces.push((f, *t));
            continue;
        };
        for end in [a, b] {
            faces.push((f, t.map(|v| if v == end { middle } else { v })));
        }
    }
    PlainMesh { positions, ..mesh.with(faces.into_iter()) }
}

/// A face without area along a tenth of the edges.
pub fn slivers(mesh: &PlainMesh, random: &mut Seeded) -> PlainMesh {
    let mut told = mesh.clone();
    for ((a, b), faces) in edges(mesh) {
        if random.unit_f64() < 0.1 {
            let middle = told.positions.len() as u32;
            told.positions.push(0.5 * (mesh.positions[a as usize] + mesh.positions[b as usize]));
            told.triangles.push([a, middle, b]);
            told.primitive.push(mesh.primitive[faces[0] as usize]);
            told.source.push(None);
        }
    }
    told.with((0u32..).zip(told.triangles.iter().copied()))
}

/// Ten tiny triangles beside it.
pub fn islands(mesh: &PlainMesh, random: &mut Seeded) -> PlainMesh {
    let mut told = mesh.clone();
    let size = 1e-4 * mesh.diagonal();
    for _ in 0..10 {
        let f = (random.unit_f64() * mesh.triangles.len() as f64) as usize;
        let [a, b, c] = mesh.corners(f);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let at = (a + b + c) / 3.0 + 0.01 * mesh.diagonal() * normal;
        let first = told.positions.len() as u32;
        told.positions.extend([at, at + size * DVec3::X, at + size * DVec3::Y]);
        told.triangles.push([first, first + 1, first + 2]);
        told.primitive.push(mesh.primitive[f]);
        told.source.push(None);
    }
    told.with((0u32..).zip(told.triangles.iter().copied()))
}
