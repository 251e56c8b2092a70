//! A closed mesh brought down to fewer triangles by edge collapse: quadric errors (Garland and
//! Heckbert, "Surface simplification using quadric error metrics", 1997,
//! doi:10.1145/258734.258849), only where the mesh stays a manifold (link condition: the ends of the
//! edge share exactly two neighbours; Dey et al., "Topology preserving edge contraction", 1999),
//! no face turns over and no sliver appears. Rounds of collapses that do not touch each other
//! alternate with edge flips that raise the smallest angle where the surface is flat.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DMat3, DVec3};

use crate::synth::solid::smallest_angle;

/// Most rounds; each takes out up to a tenth of the faces.
const ROUNDS: usize = 80;
/// Collapses keep every angle above this (radians) or above what it was.
const SLIVER: f64 = 0.17;
/// How much an edge's length counts beside the error: prefers to take out short edges.
const EVENNESS: f64 = 1e-4;
/// Faces may turn by about 40° (cosine).
const TURN: f64 = 0.75;

/// The sum of squared distances to planes, by area: xᵀ A x − 2 b·x + c.
#[derive(Debug, Clone, Copy)]
struct Quadric {
    a: DMat3,
    b: DVec3,
    c: f64,
}

impl Quadric {
    const NONE: Self = Self { a: DMat3::ZERO, b: DVec3::ZERO, c: 0.0 };

    fn plane(normal: DVec3, point: DVec3, weight: f64) -> Self {
        let d = normal.dot(point);
        let a = DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z) * weight;
        Self { a, b: weight * d * normal, c: weight * d * d }
    }

    fn plus(self, other: Self) -> Self {
        Self { a: self.a + other.a, b: self.b + other.b, c: self.c + other.c }
    }

    fn error(&self, x: DVec3) -> f64 {
        (x.dot(self.a * x) - 2.0 * self.b.dot(x) + self.c).max(0.0)
    }

    /// The place of least error near `x`: a step that a little weight on staying keeps short where
    /// the planes leave it open.
    fn best_near(&self, x: DVec3) -> DVec3 {
        let hold = 1e-3 * (self.a.x_axis.x + self.a.y_axis.y + self.a.z_axis.z).max(1e-300);
        let held = self.a + DMat3::from_diagonal(DVec3::splat(hold));
        x + held.inverse() * (self.b - self.a * x)
    }
}

/// Decimate to about `wanted` triangles (never below what shape and topology allow).
pub(super) fn decimate(
    mut positions: Vec<DVec3>,
    mut triangles: Vec<[u32; 3]>,
    wanted: usize,
) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut quadrics = vec![Quadric::NONE; positions.len()];
    for t in &triangles {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        let cross = (b - a).cross(c - a);
        let q = Quadric::plane(cross.normalize_or_zero(), a, 0.5 * cross.length());
        for &v in t {
            quadrics[v as usize] = quadrics[v as usize].plus(q);
        }
    }
    for round in 0..ROUNDS {
        if round % 5 == 0 {
            flip(&positions, &mut triangles);
        }
        let surplus = triangles.len().saturating_sub(wanted) / 2;
        let before = triangles.len();
        triangles = collapse(&mut positions, &mut quadrics, triangles, surplus);
        // Give up where a round takes out next to nothing.
        if surplus == 0 || before - triangles.len() < 2 + before / 2000 {
            break;
        }
    }
    flip(&positions, &mut triangles);
    compact(&positions, triangles)
}

fn corners(positions: &[DVec3], t: &[u32; 3]) -> [DVec3; 3] {
    t.map(|v| positions[v as usize])
}

fn normal(positions: &[DVec3], t: &[u32; 3]) -> DVec3 {
    let [a, b, c] = corners(positions, t);
    (b - a).cross(c - a).normalize_or_zero()
}

fn angle(positions: &[DVec3], t: &[u32; 3]) -> f64 {
    let [a, b, c] = corners(positions, t);
    smallest_angle(a, b, c)
}

/// Collapse the cheapest edges, at most `most` of them, no two in one neighbourhood.
fn collapse(
    positions: &mut [DVec3],
    quadrics: &mut [Quadric],
    mut triangles: Vec<[u32; 3]>,
    most: usize,
) -> Vec<[u32; 3]> {
    let mut fans: Vec<Vec<u32>> = vec![vec![]; positions.len()];
    let mut edges = vec![];
    for (f, t) in (0u32..).zip(&triangles) {
        for k in 0..3 {
            fans[t[k] as usize].push(f);
            let (u, v) = (t[k], t[(k + 1) % 3]);
            if u > v {
                continue;
            }
            let q = quadrics[u as usize].plus(quadrics[v as usize]);
            let (p, r) = (positions[u as usize], positions[v as usize]);
            let at = q.best_near(0.5 * (p + r));
            let length = p.distance_squared(r);
            edges.push((q.error(at) + EVENNESS * length * length, u, v, at));
        }
    }
    edges.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    edges.truncate(edges.len() / 3);
    let mut touched = vec![false; positions.len()];
    let mut gone = vec![false; triangles.len()];
    let mut left = most.min(triangles.len() / 20);
    for (_, u, v, at) in edges {
        if left == 0 {
            break;
        }
        let ring = |x: u32| -> BTreeSet<u32> {
            let around = fans[x as usize].iter().flat_map(|&f| triangles[f as usize]);
            around.filter(|&w| w != x).collect()
        };
        let (ring_u, ring_v) = (ring(u), ring(v));
        if ring_u.union(&ring_v).any(|&w| touched[w as usize])
            || ring_u.intersection(&ring_v).count() != 2
        {
            continue;
        }
        let around =
            fans[u as usize].iter().chain(&fans[v as usize]).map(|&f| triangles[f as usize]);
        let kept: Vec<[u32; 3]> = around.filter(|t| !(t.contains(&u) && t.contains(&v))).collect();
        let before: Vec<(DVec3, f64)> =
            kept.iter().map(|t| (normal(positions, t), angle(positions, t))).collect();
        let worst = before.iter().map(|b| b.1).fold(SLIVER, f64::min);
        let (old_u, old_v) = (positions[u as usize], positions[v as usize]);
        positions[u as usize] = at;
        positions[v as usize] = at;
        let sound = kept
            .iter()
            .zip(&before)
            .all(|(t, (n, _))| n.dot(normal(positions, t)) > TURN && angle(positions, t) >= worst);
        if !sound {
            positions[u as usize] = old_u;
            positions[v as usize] = old_v;
            continue;
        }
        quadrics[u as usize] = quadrics[u as usize].plus(quadrics[v as usize]);
        for &f in &fans[v as usize] {
            let t = &mut triangles[f as usize];
            gone[f as usize] |= t.contains(&u);
            for w in t.iter_mut().filter(|w| **w == v) {
                *w = u;
            }
        }
        for w in ring_u.into_iter().chain(ring_v) {
            touched[w as usize] = true;
        }
        left -= 1;
    }
    let mut gone = gone.into_iter();
    triangles.retain(|_| !gone.next().unwrap_or(false));
    triangles
}

/// One sweep of flips over edges between nearly coplanar faces.
fn flip(positions: &[DVec3], triangles: &mut [[u32; 3]]) {
    let mut across: BTreeMap<(u32, u32), usize> = BTreeMap::new();
    for (f, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            across.insert((t[k], t[(k + 1) % 3]), f);
        }
    }
    let edges: Vec<(u32, u32)> = across.keys().copied().filter(|e| e.0 < e.1).collect();
    let third = |t: &[u32; 3], a: u32, b: u32| t.iter().copied().find(|&v| v != a && v != b);
    for (a, b) in edges {
        let (Some(&f), Some(&g)) = (across.get(&(a, b)), across.get(&(b, a))) else { continue };
        let (Some(c), Some(d)) = (third(&triangles[f], a, b), third(&triangles[g], a, b)) else {
            continue;
        };
        if across.contains_key(&(c, d)) || across.contains_key(&(d, c)) {
            continue;
        }
        let (one, two) = ([c, a, d], [d, b, c]);
        let flat = normal(positions, &triangles[f]).dot(normal(positions, &triangles[g])) > 0.97
            && normal(positions, &one).dot(normal(positions, &two)) > 0.97
            && normal(positions, &one).dot(normal(positions, &triangles[f])) > 0.9;
        let better = angle(positions, &one).min(angle(positions, &two))
            > angle(positions, &triangles[f]).min(angle(positions, &triangles[g]));
        if !(flat && better) {
            continue;
        }
        across.remove(&(a, b));
        across.remove(&(b, a));
        triangles[f] = one;
        triangles[g] = two;
        for (f, t) in [(f, one), (g, two)] {
            for k in 0..3 {
                across.insert((t[k], t[(k + 1) % 3]), f);
            }
        }
    }
}

/// Drop the vertices that no triangle uses.
fn compact(positions: &[DVec3], triangles: Vec<[u32; 3]>) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut number = vec![u32::MAX; positions.len()];
    let mut kept = vec![];
    let mut rename = |v: u32| {
        if number[v as usize] == u32::MAX {
            number[v as usize] = kept.len() as u32;
            kept.push(positions[v as usize]);
        }
        number[v as usize]
    };
    let triangles = triangles.into_iter().map(|t| t.map(&mut rename)).collect();
    (kept, triangles)
}
