//! Tutte's embedding (Tutte, "How to Draw a Graph", 1963) with mean value weights (Floater, "Mean
//! Value Coordinates", 2003): the boundary on a circle by arc length, every other vertex at a
//! positive average of its neighbours. Injective for every disk (Floater, "One-to-one piecewise
//! linear mappings over triangulations", 2003), as far as double precision reaches.

use glam::DVec2;

use super::border::Border;
use super::harmonic::{Weights, equal_weights, mean_value_weights, spread};
use super::injective::count_flips;
use super::jacobian::rescale;
use super::{Disk, FlattenError, UvMap};

/// Map a disk to a circle, scaled to the 3D area. Where mean value weights are too uneven for
/// double precision, equal weights are tried. Errors when the triangles are no disk or neither
/// choice has come out without flips.
pub fn tutte(disk: &Disk) -> Result<UvMap, FlattenError> {
    let border = Border::of(disk);
    let [ring] = &border.loops[..] else { return Err(FlattenError::NotADisk) };
    if !border.is_disk() || ring.len() < 3 {
        return Err(FlattenError::NotADisk);
    }
    for weights in [mean_value_weights(disk), equal_weights(disk)] {
        let uv = rescale(disk, embed(disk, ring, &weights)?);
        if count_flips(disk, &uv) == 0 {
            return Ok(uv);
        }
    }
    Err(FlattenError::NoValidMap)
}

fn embed(disk: &Disk, ring: &[u32], weights: &Weights) -> Result<UvMap, FlattenError> {
    let mut uv = circle(disk, ring);
    let mut fixed = vec![false; uv.len()];
    ring.iter().for_each(|&v| fixed[v as usize] = true);
    spread(&mut uv, &fixed, weights)?;
    Ok(uv)
}

/// The boundary on the unit circle by arc length; edges without length get a little.
fn circle(disk: &Disk, ring: &[u32]) -> UvMap {
    let at = |k: usize| disk.positions[ring[k % ring.len()] as usize];
    let lengths: Vec<f64> = (0..ring.len()).map(|k| at(k).distance(at(k + 1))).collect();
    let whole: f64 = lengths.iter().sum();
    let least = if whole > 0.0 { 1e-4 * whole / ring.len() as f64 } else { 1.0 };
    let total: f64 = lengths.iter().map(|l| l.max(least)).sum();
    let mut uv = vec![DVec2::ZERO; disk.positions.len()];
    let mut walked = 0.0;
    for (&v, length) in ring.iter().zip(&lengths) {
        uv[v as usize] = DVec2::from_angle(std::f64::consts::TAU * walked / total);
        walked += length.max(least);
    }
    uv
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::{certify, samples};
    use glam::DVec3;
    use proptest::prelude::*;

    /// A triangulation made by putting each point into a triangle of the ones before (every
    /// valence occurs, slivers too), lifted to random heights.
    fn stacked(points: &[(usize, f64, f64, f64)]) -> Disk {
        let mut positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
        let mut triangles = vec![[0u32, 1, 2]];
        for &(which, a, b, height) in points {
            let f = which % triangles.len();
            let [i, j, k] = triangles[f];
            let [p, q, r] = triangles[f].map(|v| positions[v as usize].truncate());
            let (a, b) = if a + b < 1.0 { (a, b) } else { (1.0 - a, 1.0 - b) };
            let new = positions.len() as u32;
            positions.push((p + (q - p) * a + (r - p) * b).extend(height));
            triangles[f] = [i, j, new];
            triangles.extend([[j, k, new], [k, i, new]]);
        }
        Disk::new(positions, triangles)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn noisy_height_fields_never_flip(seed in prop::collection::vec(-1.0..1.0f64, 81)) {
            let disk = samples::bent(8, 8, |x, y| {
                let k = (8.0 * y).round() as usize * 9 + (8.0 * x).round() as usize;
                DVec3::new(x, y, seed[k])
            });
            prop_assert!(certify(&disk, &tutte(&disk).unwrap()).is_injective());
        }

        #[test]
        fn random_triangulations_never_flip(
            points in prop::collection::vec((0usize..1000, 0.05..0.95f64, 0.05..0.95f64, -0.3..0.3f64), 1..24),
        ) {
            let disk = stacked(&points);
            prop_assert!(certify(&disk, &tutte(&disk).unwrap()).is_injective());
        }
    }

    #[test]
    fn needles_do_not_break_it() {
        let disk = samples::bent(20, 20, |x, y| DVec3::new(x, 1e-9 * y, x * x));
        assert!(certify(&disk, &tutte(&disk).unwrap()).is_injective());
    }

    #[test]
    fn what_is_no_disk_is_refused() {
        let triangles = vec![[0, 1, 2], [0, 3, 4]];
        let disk =
            Disk::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y], triangles);
        assert_eq!(tutte(&disk), Err(FlattenError::NotADisk));
    }
}
