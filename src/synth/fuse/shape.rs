//! From voxels to the shape: the quads' centres are put on the union, then each vertex where the
//! tangent planes at the centres around it meet, in the least-squares sense, held near their mean.
//! Sharp edges come out sharp and the rest even (Ohtake and Belyaev, "Dual/primal mesh optimization
//! for polygonized implicit surfaces", 2002, doi:10.1145/566282.566308).

use glam::{DMat3, DVec3};

use super::distance::Near;
use crate::synth::solid::smallest_angle;

/// Rounds of fitting.
const ROUNDS: usize = 12;
/// Weight of staying near the mean.
const HOLD: f64 = 0.08;

/// Move the vertices onto the union.
pub(super) fn fit(positions: &mut [DVec3], quads: &[[u32; 4]], near: &Near, spacing: f64) {
    for _ in 0..ROUNDS {
        let planes: Vec<Option<(DVec3, DVec3)>> = quads
            .iter()
            .map(|q| {
                let centre = q.iter().map(|&v| positions[v as usize]).sum::<DVec3>() / 4.0;
                near.closest(centre).map(|c| (c.point, c.normal))
            })
            .collect();
        let mut around: Vec<Vec<(DVec3, DVec3)>> = vec![vec![]; positions.len()];
        for (quad, plane) in quads.iter().zip(&planes) {
            for &v in quad {
                around[v as usize].extend(plane);
            }
        }
        for (p, planes) in positions.iter_mut().zip(&around) {
            if planes.is_empty() {
                continue;
            }
            let n = planes.len() as f64;
            let mean = planes.iter().map(|x| x.0).sum::<DVec3>() / n;
            let (mut left, mut right) = (DMat3::from_diagonal(DVec3::splat(HOLD)), DVec3::ZERO);
            for &(q, normal) in planes {
                let outer =
                    DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
                left += outer * (1.0 / n);
                right += normal * (normal.dot(q - mean) / n);
            }
            // Positive definite by HOLD.
            let step = left.inverse() * right;
            *p = mean + step.clamp_length_max(0.7 * spacing);
        }
    }
}

/// Two triangles for each quad, along the diagonal that leaves the larger smallest angle.
pub(super) fn split(positions: &[DVec3], quads: &[[u32; 4]]) -> Vec<[u32; 3]> {
    let angle = |t: [u32; 3]| {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        smallest_angle(a, b, c)
    };
    let halves = |&[a, b, c, d]: &[u32; 4]| {
        let (one, two) = ([[a, b, c], [a, c, d]], [[a, b, d], [b, c, d]]);
        let worst = |pair: &[[u32; 3]; 2]| angle(pair[0]).min(angle(pair[1]));
        if worst(&two) > worst(&one) { two } else { one }
    };
    quads.iter().flat_map(halves).collect()
}
