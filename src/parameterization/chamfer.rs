//! The paper's Chamfer distance (2.5): points of the surface, sent to UV by the map that ships and back
//! by the inverse mapper, against where they came from. 10,000 samples, in radii of the chart,
//! unsquared, the mean of both directions.

use burn::tensor::Tensor;
use glam::{DVec2, DVec3};
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;

use super::MapError;
use super::chart::Trainee;
use super::mapper::Layout;
use super::step::inverse_points;
use crate::device::{Device, Seeded};

/// Points of the surface.
const SAMPLES: usize = 10_000;

/// Chamfer distance of F_inv(u(P)) to P, `u` one entry a vertex of the chart. `None` where the chart
/// has no area or the inverse mapper makes no numbers.
pub(super) fn chamfer(
    chart: &Trainee,
    u: &[DVec2],
    layout: &Layout,
    parameters: &Tensor<2>,
    device: &Device,
) -> Result<Option<f64>, MapError> {
    let disk = chart.chart.disk;
    let step = disk.area() / SAMPLES as f64;
    if !(step > 0.0 && step.is_finite()) {
        return Ok(None);
    }
    let mut rng = Seeded::new(chart.chart.id, 0);
    let mut points: Vec<[f32; 3]> = Vec::with_capacity(SAMPLES);
    let mut uvs: Vec<f32> = Vec::with_capacity(2 * SAMPLES);
    let (mut sum, mut next) = (0.0, 0.5 * step);
    for (triangle, area) in disk.triangles.iter().zip(&disk.areas) {
        sum += area;
        let corners = triangle.map(|v| v as usize);
        while next < sum && points.len() < SAMPLES {
            next += step;
            // Uniform on the triangle (Turk, Graphics Gems, 1990).
            let (root, t) = (rng.unit_f64().sqrt(), rng.unit_f64());
            let weights = [1.0 - root, root * (1.0 - t), root * t];
            let mix = |k: usize| (corners[k], weights[k]);
            let p: DVec3 = [0, 1, 2].map(mix).iter().map(|&(v, w)| disk.positions[v] * w).sum();
            let q: DVec2 = [0, 1, 2].map(mix).iter().map(|&(v, w)| u[v] * w).sum();
            points.push(chart.frame.point(p));
            uvs.extend(chart.frame.uv(q));
        }
    }
    let back = inverse_points(&uvs, layout, parameters, device)?;
    if !back.iter().all(|x| x.is_finite()) {
        return Ok(None);
    }
    let back: Vec<[f32; 3]> = back.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
    let there = one_way(&points, &back);
    Ok(there.zip(one_way(&back, &points)).map(|(there, back)| 0.5 * (there + back)))
}

/// Mean distance of each point of `from` to the nearest of `to`; `None` where `to` cannot be searched.
fn one_way(from: &[[f32; 3]], to: &[[f32; 3]]) -> Option<f64> {
    let tree: ImmutableKdTree<f32, 3> = ImmutableKdTree::new_from_slice(to).ok()?;
    let nearest =
        |p: &[f32; 3]| tree.query(p).nearest_one::<SquaredEuclidean<f32>>().execute().distance;
    // Collected in order, then summed: the same at any number of threads.
    let distances: Vec<f32> = from.par_iter().map(nearest).collect();
    let sum: f64 = distances.iter().map(|&d| f64::from(d).sqrt()).sum();
    Some(sum / from.len().max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_way_is_the_mean_distance() {
        let from = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
        let to = [[0.0, 0.5, 0.0], [5.0, 5.0, 5.0]];
        let want = 0.5 * (0.5 + 1.25_f64.sqrt());
        assert!((one_way(&from, &to).unwrap() - want).abs() < 1e-6);
    }

    #[test]
    fn many_points_at_one_place_are_no_trouble() {
        let to = vec![[0.0; 3]; 10_000];
        assert!((one_way(&[[3.0, 4.0, 0.0]], &to).unwrap() - 5.0).abs() < 1e-6);
    }
}
