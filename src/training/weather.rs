//! What scanning, sculpting and remeshing do to a body: edges and valleys are rounded, the surface is
//! rough, triangles are small. A classifier that has only seen clean unions looks for sharp valleys.

use std::collections::HashMap;

use glam::DVec3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::synth::FusedBody;

/// Chance that a body is weathered.
const WEATHERED: f64 = 0.6;

/// Most triangles of a body that is divided further.
const MOST: usize = 8000;

/// Weather a body, or leave it as it is.
pub fn weather(body: &mut FusedBody, rng: &mut ChaCha8Rng) {
    if !rng.random_bool(WEATHERED) {
        return;
    }
    if body.triangles.len() < MOST && rng.random_bool(0.6) {
        divide(body);
    }
    let rounds = rng.random_range(0..8);
    let strength = rng.random_range(0.2..0.6);
    for _ in 0..rounds {
        smooth(body, strength);
    }
    if rng.random_bool(0.4) {
        let edge = mean_edge(body);
        let rough = edge * rng.random_range(0.0..0.06);
        for p in &mut body.positions {
            *p += DVec3::from(std::array::from_fn(|_| rng.random_range(-1.0..1.0) * rough));
        }
    }
}

/// Every triangle in four.
fn divide(body: &mut FusedBody) {
    let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
    let FusedBody { positions, triangles, labels } = body;
    let mut middle = |a: u32, b: u32| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            positions.push(0.5 * (positions[a as usize] + positions[b as usize]));
            positions.len() as u32 - 1
        })
    };
    let mut finer = Vec::with_capacity(4 * triangles.len());
    for &[a, b, c] in triangles.iter() {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    *triangles = finer;
    *labels = labels.iter().flat_map(|&l| [l; 4]).collect();
}

/// Vertices move towards the mean of their neighbours (Laplacian smoothing).
fn smooth(body: &mut FusedBody, strength: f64) {
    let mut sums = vec![(DVec3::ZERO, 0.0); body.positions.len()];
    for t in &body.triangles {
        for k in 0..3 {
            let (a, b) = (t[k] as usize, t[(k + 1) % 3]);
            sums[a].0 += body.positions[b as usize];
            sums[a].1 += 1.0;
        }
    }
    for (p, (sum, count)) in body.positions.iter_mut().zip(sums).filter(|(_, s)| s.1 > 0.0) {
        *p = p.lerp(sum / count, strength);
    }
}

fn mean_edge(body: &FusedBody) -> f64 {
    let at = |v: u32| body.positions[v as usize];
    let sum: f64 = body.triangles.iter().map(|t| at(t[0]).distance(at(t[1]))).sum();
    sum / body.triangles.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn weathering_keeps_labels_and_connections() {
        let object = crate::synth::embellished(crate::synth::SynthKind::Table, 2);
        let fused = crate::synth::fused(object, 2000).fused.unwrap();
        for seed in 0..6 {
            let mut body = fused.clone();
            weather(&mut body, &mut ChaCha8Rng::seed_from_u64(seed));
            assert_eq!(body.labels.len(), body.triangles.len());
            assert!(body.positions.iter().all(|p| p.is_finite()));
            let vertices = body.positions.len() as u32;
            assert!(body.triangles.iter().flatten().all(|&v| v < vertices));
            // Closed bodies stay closed: V − E + F does not change, E = 3F/2.
            let euler = |b: &FusedBody| b.positions.len() as i64 - b.triangles.len() as i64 / 2;
            assert_eq!(euler(&body), euler(&fused));
        }
    }
}
