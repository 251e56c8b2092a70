//! What a training step sees of an example: other points of it, turned, scaled, roughened.

use glam::{DMat3, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::example::Example;
use crate::segmentation::point_mae::NetworkCloud;

/// Points that the network sees.
pub const SEEN: usize = 2048;

/// Chance that the thickness is withheld: open and double-sided meshes have none.
const BLIND: f64 = 0.25;

/// Deviation of the positions' noise, at most.
const ROUGH: f64 = 0.008;

/// Deviation of the normals' noise, at most.
const ROUGH_NORMALS: f64 = 0.15;

/// A cloud of [`SEEN`] points with their labels.
#[derive(Debug, Clone)]
pub struct View {
    /// The cloud.
    pub cloud: NetworkCloud,
    /// Part of each point, −1 unknown.
    pub part: Vec<i32>,
    /// Name of each point, −1 unknown.
    pub name: Vec<i32>,
}

/// The first points as they are: what validation sees.
pub fn plain(example: &Example) -> View {
    let indices: Vec<usize> = (0..SEEN).map(|i| i % example.len().max(1)).collect();
    take(example, &indices)
}

/// A random view.
pub fn augmented(example: &Example, rng: &mut ChaCha8Rng) -> View {
    let mut view = take(example, &draw(example, rng));
    let turn = rotation(rng);
    let stretch = DVec3::from(std::array::from_fn(|_| 1.2_f64.powf(rng.random_range(-1.0..1.0))));
    let rough = ROUGH * rng.random_range(0.0..1.0_f64).powi(2);
    let rough_normals = ROUGH_NORMALS * rng.random_range(0.0..1.0_f64);
    let blind = rng.random_bool(BLIND);
    // A stretch widens a body by its share along the normal.
    let cloud = &mut view.cloud;
    for i in 0..cloud.len() {
        let normal = DVec3::from(cloud.normals[i].map(f64::from));
        let position = DVec3::from(cloud.positions[i].map(f64::from));
        let widened = (normal * stretch).length();
        let noise = |rng: &mut ChaCha8Rng, by: f64| {
            DVec3::from(std::array::from_fn(|_| by * normal_draw(rng)))
        };
        let position = turn * (position * stretch) + noise(rng, rough);
        let normal = turn * (normal / stretch).normalize_or_zero() + noise(rng, rough_normals);
        cloud.positions[i] = position.as_vec3().to_array();
        cloud.normals[i] = normal.normalize_or_zero().as_vec3().to_array();
        let through = if blind { 0.0 } else { cloud.thickness[i] * widened as f32 };
        cloud.thickness[i] = through * (1.0 + 0.1 * normal_draw(rng) as f32);
    }
    cloud.normalise();
    view
}

fn take(example: &Example, indices: &[usize]) -> View {
    let cloud = &example.cloud;
    View {
        cloud: NetworkCloud {
            positions: indices.iter().map(|&i| cloud.positions[i]).collect(),
            normals: indices.iter().map(|&i| cloud.normals[i]).collect(),
            thickness: indices.iter().map(|&i| cloud.thickness[i]).collect(),
        },
        part: indices.iter().map(|&i| example.part[i]).collect(),
        name: indices.iter().map(|&i| example.name[i]).collect(),
    }
}

/// Evenly spread points, random ones, or random ones that thin out along a direction.
fn draw(example: &Example, rng: &mut ChaCha8Rng) -> Vec<usize> {
    let n = example.len().max(1);
    match rng.random_range(0..4) {
        0 | 1 => {
            // The farthest-first order, entered at a random place: still spread evenly.
            let most = n.saturating_sub(SEEN);
            let skipped = rng.random_range(0..=most / 8);
            (0..SEEN).map(|i| (i + skipped) % n).collect()
        }
        2 => (0..SEEN).map(|_| rng.random_range(0..n)).collect(),
        _ => {
            let axis = rng.random_range(0..3);
            let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
            let mut picked = Vec::with_capacity(SEEN);
            while picked.len() < SEEN {
                let i = rng.random_range(0..n);
                let along = f64::from(example.cloud.positions[i][axis]) * sign;
                if rng.random_range(0.0..1.0) < 0.6 + 0.4 * along {
                    picked.push(i);
                }
            }
            picked
        }
    }
}

/// Upright and turned about the vertical, lying on any side, or at any attitude.
fn rotation(rng: &mut ChaCha8Rng) -> DMat3 {
    let about = DMat3::from_rotation_y(rng.random_range(0.0..std::f64::consts::TAU));
    let quarter =
        DMat3::from_rotation_y(std::f64::consts::FRAC_PI_2 * f64::from(rng.random_range(0..4_u32)));
    match rng.random_range(0..10) {
        0..=2 => quarter,
        3..=5 => about,
        6..=8 => {
            let side = match rng.random_range(0..5) {
                0 => DMat3::from_rotation_x(std::f64::consts::FRAC_PI_2),
                1 => DMat3::from_rotation_x(-std::f64::consts::FRAC_PI_2),
                2 => DMat3::from_rotation_z(std::f64::consts::FRAC_PI_2),
                3 => DMat3::from_rotation_z(-std::f64::consts::FRAC_PI_2),
                _ => DMat3::from_rotation_x(std::f64::consts::PI),
            };
            side * quarter
        }
        _ => {
            let tilt = DMat3::from_rotation_x(rng.random_range(0.0..std::f64::consts::PI));
            DMat3::from_rotation_y(rng.random_range(0.0..std::f64::consts::TAU)) * tilt * about
        }
    }
}

/// Normally distributed (Box and Muller 1958, doi:10.1214/aoms/1177706645).
fn normal_draw(rng: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (rng.random_range(f64::MIN_POSITIVE..1.0), rng.random());
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    fn example() -> Example {
        let n = 3000;
        let at = |i: usize| i as f32 / n as f32;
        Example {
            cloud: NetworkCloud {
                positions: (0..n).map(|i| [at(i), 1.0 - at(i), at(i * 7 % n)]).collect(),
                normals: (0..n).map(|_| [0.0, 1.0, 0.0]).collect(),
                thickness: (0..n).map(|_| 0.1).collect(),
            },
            part: (0..n as i32).map(|i| i / 1000).collect(),
            name: vec![0; n],
            ..Default::default()
        }
    }

    #[test]
    fn a_view_is_normalised_and_keeps_its_labels() {
        let example = example();
        for seed in 0..20 {
            let view = augmented(&example, &mut ChaCha8Rng::seed_from_u64(seed));
            assert_eq!((view.cloud.len(), view.part.len(), view.name.len()), (SEEN, SEEN, SEEN));
            let far = |p: &[f32; 3]| p.iter().map(|x| x * x).sum::<f32>();
            let most = view.cloud.positions.iter().map(far).fold(0.0, f32::max);
            assert!((most - 1.0).abs() < 1e-4);
            for part in 0..3 {
                assert!(view.part.contains(&part), "{seed}: part {part} is gone");
            }
        }
    }

    #[test]
    fn rotations_keep_lengths_and_handedness() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for _ in 0..100 {
            let turn = rotation(&mut rng);
            assert!((turn.determinant() - 1.0).abs() < 1e-9);
            assert!(((turn * DVec3::new(1.0, 2.0, 3.0)).length() - 14f64.sqrt()).abs() < 1e-9);
        }
    }
}
