//! Cylinders and cones (paper 2.3.1): finding the side of a tube in a part, its axis and radius,
//! and the one axial cut that opens it.
//!
//! Axis `a` and offset `c` minimise Σ A w (n·a − c)² with w = 1/(1 + ((n·a − c)/0.1)²), reweighted
//! 20 times, so that caps drop out. On the lateral faces q⊥ − x₀ = (r₀ + r₁ z) m is solved for x₀,
//! r₀ and r₁ by least squares (q the position, m the normal's unit part across a, z along a).

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::TAU;

use glam::{DMat3, DVec2, DVec3};

use crate::charts::limits::cost::edge_cost;
use crate::charts::part_mesh::PartMesh;
use crate::charts::patchwork::next;
use crate::mesh::{NONE, least_eigenvector};

/// Lateral faces have |n·a| below this.
const LATERAL: f64 = 0.5;
/// Least share of a part's area that is lateral.
const LATERAL_SHARE: f64 = 0.6;
/// Largest rms radial residual over the mean radius.
const RESIDUAL: f64 = 0.08;
/// Largest gap between neighbouring lateral normals: prisms of up to 7 sides are no cylinders.
const GAP: f64 = 50.0 / 360.0 * TAU;
/// Least angle that the normals cover.
const COVERAGE: f64 = 270.0 / 360.0 * TAU;
/// Least height over mean radius.
const SLENDERNESS: f64 = 1.0;

/// A fitted tube.
#[derive(Debug, Clone, PartialEq)]
pub struct Tube {
    /// Point on the axis at the lowest lateral height.
    pub origin: DVec3,
    /// Unit axis.
    pub axis: DVec3,
    /// Radius at the origin; negative where the surface faces inwards.
    pub radius: f64,
    /// Change of radius along the axis.
    pub taper: f64,
    /// Local faces of the side, ascending.
    pub lateral: Vec<u32>,
}

/// Fit a tube to a part, if it is one.
pub fn fit(mesh: &PartMesh) -> Option<Tube> {
    let total: f64 = (0..mesh.len()).map(|f| mesh.area(f)).sum();
    let axis = axis(mesh)?;
    let across = axis.any_orthonormal_vector();
    let (x, y) = (across, axis.cross(across));
    let lateral: Vec<u32> = (0..mesh.len() as u32)
        .filter(|&f| mesh.normal(f as usize).dot(axis).abs() < LATERAL)
        .collect();
    let area: f64 = lateral.iter().map(|&f| mesh.area(f as usize)).sum();
    if lateral.len() < 8 || area < LATERAL_SHARE * total {
        return None;
    }
    // Every corner of a lateral face is a sample of weight area/3, with its face's normal.
    let flat = |p: DVec3| DVec2::new(p.dot(x), p.dot(y));
    let samples: Vec<(DVec2, f64, DVec2, f64)> = lateral
        .iter()
        .flat_map(|&f| {
            let m = flat(mesh.normal(f as usize)).normalize_or_zero();
            let weight = mesh.area(f as usize) / 3.0;
            let corners = mesh.surface.corners(mesh.faces[f as usize] as usize);
            let center = (corners[0] + corners[1] + corners[2]) / 3.0;
            // The chord's middle stands for the face: its normal is the circle's there.
            corners.map(|p| (flat(center), p.dot(axis), m, weight))
        })
        .collect();
    let (low, high) = samples
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), s| (l.min(s.1), h.max(s.1)));
    let (center, radius, taper) = solve(&samples, low)?;
    let height = high - low;
    let mean = (radius + 0.5 * taper * height).abs();
    let (mut residual, mut weight) = (0.0, 0.0);
    for &(q, z, m, w) in &samples {
        residual += w * (q - center - (radius + taper * (z - low)) * m).length_squared();
        weight += w;
    }
    let slim = height >= SLENDERNESS * mean;
    // A cone may not pass through its tip.
    let open = radius * (radius + taper * height) > 0.0;
    if !(residual / weight).sqrt().is_finite()
        || (residual / weight).sqrt() > RESIDUAL * mean
        || !slim
        || !open
        || !wraps(samples.iter().map(|s| s.2))
    {
        return None;
    }
    let origin = x * center.x + y * center.y + axis * low;
    Some(Tube { origin, axis, radius, taper, lateral })
}

/// The direction to which the normals keep one angle, robustly.
fn axis(mesh: &PartMesh) -> Option<DVec3> {
    let mut weights: Vec<f64> = (0..mesh.len()).map(|f| mesh.area(f)).collect();
    let mut axis = DVec3::ZERO;
    for _ in 0..20 {
        let total: f64 = weights.iter().sum();
        if total <= 0.0 {
            return None;
        }
        let mean = (0..mesh.len()).map(|f| mesh.normal(f) * weights[f]).sum::<DVec3>() / total;
        let mut spread = DMat3::ZERO;
        for (f, &w) in weights.iter().enumerate() {
            let d = mesh.normal(f) - mean;
            spread += DMat3::from_cols(d * d.x, d * d.y, d * d.z) * (w / total);
        }
        axis = least_eigenvector(spread);
        let offset = mean.dot(axis);
        for (f, w) in weights.iter_mut().enumerate() {
            let off = (mesh.normal(f).dot(axis) - offset) / 0.1;
            *w = mesh.area(f) / (1.0 + off * off);
        }
    }
    axis.is_finite().then_some(axis)
}

/// Centre, radius at `low` and taper by least squares: four unknowns, normal equations.
fn solve(samples: &[(DVec2, f64, DVec2, f64)], low: f64) -> Option<(DVec2, f64, f64)> {
    let mut normal = [[0.0; 5]; 4];
    for &(q, z, m, w) in samples {
        let z = z - low;
        for (row, rhs) in [([1.0, 0.0, m.x, m.x * z], q.x), ([0.0, 1.0, m.y, m.y * z], q.y)] {
            for i in 0..4 {
                for j in 0..4 {
                    normal[i][j] += w * row[i] * row[j];
                }
                normal[i][4] += w * row[i] * rhs;
            }
        }
    }
    // Gauss elimination with partial pivots.
    for i in 0..4 {
        let pivot = (i..4).max_by(|&a, &b| normal[a][i].abs().total_cmp(&normal[b][i].abs()))?;
        normal.swap(i, pivot);
        if normal[i][i].abs() < 1e-300 {
            return None;
        }
        for r in 0..4 {
            if r != i {
                let factor = normal[r][i] / normal[i][i];
                let row = normal[i];
                normal[r].iter_mut().zip(row).for_each(|(x, y)| *x -= factor * y);
            }
        }
    }
    let x = |i: usize| normal[i][4] / normal[i][i];
    Some((DVec2::new(x(0), x(1)), x(2), x(3)))
}

/// Whether directions go round far enough, without a large gap.
fn wraps(directions: impl Iterator<Item = DVec2>) -> bool {
    let mut angles: Vec<f64> = directions.map(|m| m.y.atan2(m.x)).collect();
    angles.sort_by(f64::total_cmp);
    let Some((&first, &last)) = angles.first().zip(angles.last()) else { return false };
    let mut gaps: Vec<f64> = angles.windows(2).map(|w| w[1] - w[0]).collect();
    gaps.push(first + TAU - last);
    gaps.sort_by(f64::total_cmp);
    let largest = gaps[gaps.len() - 1];
    let second = if gaps.len() > 1 { gaps[gaps.len() - 2] } else { 0.0 };
    // One gap may be the opening of a tube that does not close; the others may not.
    TAU - largest >= COVERAGE && second <= GAP
}

/// The cheapest axial path (local half-edges on one side) from one border loop of a tube's side to
/// another, or `None` where the side has not exactly two loops and so is open already or is cut
/// some other way. Steps across the axis cost three times as much as steps along it.
pub fn axial_cut(mesh: &PartMesh, side: &[u32], axis: DVec3) -> Option<Vec<u32>> {
    let mut inside = vec![false; mesh.len()];
    side.iter().for_each(|&f| inside[f as usize] = true);
    let across = |h: u32| {
        let t = mesh.twin[h as usize];
        (t != NONE && inside[t as usize / 3]).then_some(t)
    };
    // Loops of border half-edges.
    let mut loop_of = vec![NONE; mesh.twin.len()];
    let mut loops = 0;
    for seed in side.iter().flat_map(|&f| 3 * f..3 * f + 3) {
        if across(seed).is_some() || loop_of[seed as usize] != NONE {
            continue;
        }
        let mut h = seed;
        loop {
            loop_of[h as usize] = loops;
            h = next(h);
            while let Some(t) = across(h) {
                h = next(t);
            }
            if h == seed {
                break;
            }
        }
        loops += 1;
    }
    if loops != 2 {
        return None;
    }
    let vertex = |h: u32| mesh.surface.from(mesh.surface_half_edge(h));
    let position = |v: u32| mesh.surface.positions[v as usize];
    // Dijkstra over vertices from loop 0 to loop 1.
    let mut goal = std::collections::BTreeSet::new();
    let mut best = std::collections::BTreeMap::new();
    let mut out: std::collections::BTreeMap<u32, Vec<u32>> = std::collections::BTreeMap::new();
    let mut heap = BinaryHeap::new();
    for h in side.iter().flat_map(|&f| 3 * f..3 * f + 3) {
        match loop_of[h as usize] {
            0 => {
                for v in [vertex(h), vertex(next(h))] {
                    best.insert(v, (0.0, NONE));
                    heap.push((Reverse(0.0f64.to_bits()), Reverse(v)));
                }
            }
            1 => {
                goal.insert(vertex(h));
                goal.insert(vertex(next(h)));
            }
            _ => out.entry(vertex(h)).or_default().push(h),
        }
    }
    while let Some((Reverse(bits), Reverse(v))) = heap.pop() {
        let distance = f64::from_bits(bits);
        if best.get(&v).is_some_and(|b| b.0 < distance) {
            continue;
        }
        if goal.contains(&v) {
            let mut path = Vec::new();
            let mut v = v;
            while let Some(&(_, h)) = best.get(&v).filter(|b| b.1 != NONE) {
                path.push(h);
                v = vertex(h);
            }
            return (!path.is_empty()).then_some(path);
        }
        for &h in out.get(&v).map_or(&[][..], Vec::as_slice) {
            let w = vertex(next(h));
            let along = (position(w) - position(v)).normalize_or_zero().dot(axis).abs();
            let d = distance + edge_cost(mesh, h) * (3.0 - 2.0 * along);
            if best.get(&w).is_none_or(|b| d < b.0) {
                best.insert(w, (d, h));
                heap.push((Reverse(d.to_bits()), Reverse(w)));
            }
        }
    }
    None
}
