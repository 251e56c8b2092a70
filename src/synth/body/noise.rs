//! Noise as of a scanner: each vertex moves by a Gaussian drawn from the seed, by the method of Box
//! and Muller (1958), doi:10.1214/aoms/1177706645.

use std::f64::consts::TAU;

use clap::ValueEnum;
use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Which way noise moves a vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum NoiseKind {
    /// Along its normal.
    #[default]
    Normal,
    /// In all directions alike.
    Isotropic,
}

/// Move the vertices; `deviation` is the standard deviation (of each coordinate, where isotropic) in
/// mean edge lengths.
pub(super) fn add(
    positions: &mut [DVec3],
    triangles: &[[u32; 3]],
    kind: NoiseKind,
    deviation: f64,
    seed: u64,
) {
    if deviation == 0.0 {
        return;
    }
    let scale = deviation * mean_edge(positions, triangles);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut spare = None;
    let mut gaussian = || {
        spare.take().unwrap_or_else(|| {
            // In (0, 1]: the logarithm of nought is not wanted.
            let radius = (-2.0 * (1.0 - rng.random::<f64>()).ln()).sqrt();
            let (sin, cos) = (TAU * rng.random::<f64>()).sin_cos();
            spare = Some(radius * sin);
            radius * cos
        })
    };
    match kind {
        NoiseKind::Normal => {
            let normals = normals(positions, triangles);
            for (p, n) in positions.iter_mut().zip(normals) {
                *p += scale * gaussian() * n;
            }
        }
        NoiseKind::Isotropic => {
            for p in positions {
                *p += scale * DVec3::new(gaussian(), gaussian(), gaussian());
            }
        }
    }
}

/// Unit normals of the vertices, weighted by area.
pub(super) fn normals(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; positions.len()];
    for t in triangles {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        let n = (b - a).cross(c - a);
        for v in t {
            normals[*v as usize] += n;
        }
    }
    normals.into_iter().map(|n| n.normalize_or(DVec3::Y)).collect()
}

/// Mean length of the edges of a closed mesh: each stands in two triangles.
pub(super) fn mean_edge(positions: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    let at = |v: u32| positions[v as usize];
    let round = |t: &[u32; 3]| (0..3).map(|k| at(t[k]).distance(at(t[(k + 1) % 3]))).sum::<f64>();
    triangles.iter().map(round).sum::<f64>() / (3 * triangles.len()).max(1) as f64
}
