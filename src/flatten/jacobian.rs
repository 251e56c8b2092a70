//! The measures of a map: singular values of its Jacobians and the symmetric Dirichlet energy
//! (Smith & Schaefer, "Bijective Parameterization with Free Boundaries", 2015, section 4), here
//! divided by 4 so that an isometry has energy 1.

use std::ops::Range;

use glam::{DMat2, DVec2};

use super::injective::{count_flips, is_positive};
use super::{Disk, UvMap};
use crate::tasks;

/// How far a map is from an isometry. Energies are symmetric Dirichlet energies, 1 for an isometry
/// and infinite where a triangle is flipped; all but `optimal` are taken after the map is scaled so
/// that its UV area equals the 3D area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapQuality {
    /// Area-weighted mean.
    pub mean: f64,
    /// Largest.
    pub max: f64,
    /// Area-weighted 95th percentile.
    pub p95: f64,
    /// Area-weighted mean at the scale that minimises it.
    pub optimal: f64,
    /// Triangles of positive 3D area that are flipped or flat in UV, by exact sign.
    pub flips: u64,
}

impl MapQuality {
    /// Whether there is nothing to gain: no flips, mean within 1e-4 and maximum within 1e-2 of an
    /// isometry.
    pub fn is_isometric(&self) -> bool {
        self.flips == 0 && self.mean - 1.0 <= 1e-4 && self.max - 1.0 <= 1e-2
    }
}

/// Singular values σ1 ≥ σ2 ≥ 0 of a 2×2 matrix, in closed form: the lengths of its conformal and
/// anticonformal parts are (σ1 ± σ2)/2 up to the sign of the determinant.
pub fn singular_values(j: DMat2) -> (f64, f64) {
    let (a, b, c, d) = (j.x_axis.x, j.y_axis.x, j.x_axis.y, j.y_axis.y);
    let conformal = (a + d).hypot(c - b);
    let anticonformal = (a - d).hypot(b + c);
    (0.5 * (conformal + anticonformal), 0.5 * (conformal - anticonformal).abs())
}

/// (σ1² + σ2² + σ1⁻² + σ2⁻²)/4 of one Jacobian; infinite when it does not preserve orientation.
pub fn symmetric_dirichlet(j: DMat2) -> f64 {
    let det = j.determinant();
    if det > 0.0 { 0.25 * square_sum(j) * (1.0 + 1.0 / (det * det)) } else { f64::INFINITY }
}

/// Derivative of [`symmetric_dirichlet`] by the entries of the Jacobian (det > 0), from
/// σ1⁻² + σ2⁻² = (σ1² + σ2²)/det².
pub fn symmetric_dirichlet_gradient(j: DMat2) -> DMat2 {
    let det = j.determinant();
    let squared = det * det;
    let cofactor =
        DMat2::from_cols(DVec2::new(j.y_axis.y, -j.y_axis.x), DVec2::new(-j.x_axis.y, j.x_axis.x));
    j * (0.5 * (1.0 + 1.0 / squared)) - cofactor * (0.5 * square_sum(j) / (squared * det))
}

/// σ1² + σ2².
fn square_sum(j: DMat2) -> f64 {
    j.x_axis.length_squared() + j.y_axis.length_squared()
}

/// √(UV area / 3D area): the scale of a map. Triangles without 3D area count for nothing.
pub fn scale(disk: &Disk, uv: &[DVec2]) -> f64 {
    let block = |faces: Range<usize>| {
        let (mut flat, mut solid) = (0.0, 0.0);
        for f in faces.filter(|&f| disk.areas[f] > 0.0) {
            flat += disk.uv_area(f, uv);
            solid += disk.areas[f];
        }
        (flat, solid)
    };
    let blocks = tasks::blocks("scale", disk.areas.len(), block);
    let (flat, solid) = blocks.into_iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x, b + y));
    (flat.max(0.0) / solid).sqrt()
}

/// The map scaled so that its UV area equals the 3D area; a map without area is left alone.
pub fn rescale(disk: &Disk, mut uv: UvMap) -> UvMap {
    let s = scale(disk, &uv);
    if s.is_finite() && s > 0.0 {
        uv.iter_mut().for_each(|p| *p /= s);
    }
    uv
}

/// Area-weighted sums of σ1² + σ2² and of σ1⁻² + σ2⁻², divided by the area: with t the scale of
/// the map, its mean energy is (t²·a + b/t²)/4, least at t⁴ = b/a.
fn dirichlet_sums(disk: &Disk, uv: &[DVec2]) -> (f64, f64) {
    let block = |faces: Range<usize>| {
        let mut sums = [0.0; 3];
        for f in faces.filter(|&f| disk.areas[f] > 0.0) {
            let (area, j) = (disk.areas[f], disk.jacobian(f, uv));
            let (squares, det) = (square_sum(j), j.determinant());
            sums[0] += area * squares;
            sums[1] += if det > 0.0 { area * squares / (det * det) } else { f64::INFINITY };
            sums[2] += area;
        }
        sums
    };
    let blocks = tasks::blocks("dirichlet", disk.areas.len(), block);
    let [forward, inverse, total] = blocks
        .into_iter()
        .fold([0.0; 3], |sums, block| std::array::from_fn(|k| sums[k] + block[k]));
    (forward / total, inverse / total)
}

/// The map scaled to where its mean symmetric Dirichlet energy is least; a map with flips is left
/// alone.
pub fn rescale_optimally(disk: &Disk, mut uv: UvMap) -> UvMap {
    let (forward, inverse) = dirichlet_sums(disk, &uv);
    let t = (inverse / forward).powf(0.25);
    if t.is_finite() && t > 0.0 {
        uv.iter_mut().for_each(|p| *p *= t);
    }
    uv
}

/// The mean of [`quality`] alone, but for the last digits: nothing is sorted. Infinite for a map with flips.
pub fn mean_energy(disk: &Disk, uv: &[DVec2]) -> f64 {
    if count_flips(disk, uv) > 0 {
        return f64::INFINITY;
    }
    let square = scale(disk, uv).powi(2);
    let (forward, inverse) = dirichlet_sums(disk, uv);
    let mean = 0.25 * (forward / square + inverse * square);
    if disk.area() <= 0.0 {
        return 1.0;
    }
    // An overflow in a hopeless triangle must not read as a number that can be compared.
    if mean.is_nan() { f64::INFINITY } else { mean }
}

/// Measure a map. A disk without area is an isometry.
pub fn quality(disk: &Disk, uv: &[DVec2]) -> MapQuality {
    let s = scale(disk, uv);
    let face = |f: usize| {
        let positive = is_positive(disk.triangles[f].map(|v| uv[v as usize]));
        let energy = symmetric_dirichlet(disk.jacobian(f, uv) * (1.0 / s));
        // An overflow in a hopeless triangle must not read as a number that can be compared.
        let energy = if positive && !energy.is_nan() { energy } else { f64::INFINITY };
        (energy, disk.areas[f], positive)
    };
    let all = tasks::fill("quality", disk.triangles.len(), face);
    let all = || all.iter().filter(|face| face.1 > 0.0);
    let flips = all().filter(|face| !face.2).count() as u64;
    let mut faces: Vec<(f64, f64)> = all().map(|&(energy, area, _)| (energy, area)).collect();
    if faces.is_empty() {
        return MapQuality { mean: 1.0, max: 1.0, p95: 1.0, optimal: 1.0, flips: 0 };
    }
    let total: f64 = faces.iter().map(|&(_, area)| area).sum();
    let mean = faces.iter().map(|&(energy, area)| energy * area).sum::<f64>() / total;
    faces.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut below = 0.0;
    let p95 = faces.iter().find(|&&(_, area)| {
        below += area;
        below >= 0.95 * total
    });
    let max = faces[faces.len() - 1].0;
    let (forward, inverse) = dirichlet_sums(disk, uv);
    let optimal = if flips == 0 { 0.5 * (forward * inverse).sqrt() } else { f64::INFINITY };
    MapQuality { mean, max, p95: p95.map_or(max, |&(energy, _)| energy), optimal, flips }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::samples;
    use proptest::prelude::*;

    fn matrix(e: [f64; 4]) -> DMat2 {
        DMat2::from_cols(DVec2::new(e[0], e[1]), DVec2::new(e[2], e[3]))
    }

    #[test]
    fn the_mean_alone_is_that_of_all_figures() {
        let disk = samples::barrel(9, 7);
        let mut uv = crate::flatten::tutte(&disk).unwrap();
        assert!((mean_energy(&disk, &uv) / quality(&disk, &uv).mean - 1.0).abs() < 1e-9);
        uv.iter_mut().for_each(|p| p.x = -p.x);
        assert_eq!(mean_energy(&disk, &uv), f64::INFINITY);
        assert_eq!(mean_energy(&Disk::new(vec![], vec![]), &[]), 1.0);
    }

    proptest! {
        #[test]
        fn singular_values_agree_with_trace_and_determinant(e in prop::array::uniform4(-3.0..3.0f64)) {
            let j = matrix(e);
            let (s1, s2) = singular_values(j);
            prop_assert!(s1 >= s2 && s2 >= 0.0);
            prop_assert!((s1 * s1 + s2 * s2 - square_sum(j)).abs() < 1e-9);
            prop_assert!((s1 * s2 - j.determinant().abs()).abs() < 1e-9);
        }

        #[test]
        fn gradient_agrees_with_finite_differences(e in prop::array::uniform4(-2.0..2.0f64)) {
            let j = matrix(e);
            prop_assume!(j.determinant() > 0.2);
            let gradient = symmetric_dirichlet_gradient(j).to_cols_array();
            for k in 0..4 {
                let energy = |h: f64| {
                    let mut moved = e;
                    moved[k] += h;
                    symmetric_dirichlet(matrix(moved))
                };
                let difference = (energy(1e-6) - energy(-1e-6)) / 2e-6;
                prop_assert!((difference - gradient[k]).abs() < 1e-5 * (1.0 + difference.abs()));
            }
        }
    }

    #[test]
    fn an_isometry_is_one_and_a_stretch_is_what_it_is() {
        let (disk, uv) = samples::plane(7, 5, 2.0, 1.0);
        let q = quality(&disk, &uv);
        assert!((q.mean - 1.0).abs() < 1e-12 && (q.max - 1.0).abs() < 1e-12 && q.is_isometric());
        // Doubling u: σ = (2, 1), so at the optimal scale t² = 1/2 the energy is ½√(5 · 1.25).
        let stretched: UvMap = uv.iter().map(|p| DVec2::new(2.0 * p.x, p.y)).collect();
        let q = quality(&disk, &stretched);
        assert!((q.optimal - 0.5 * (5.0f64 * 1.25).sqrt()).abs() < 1e-12);
        // At equal area σ = (√2, 1/√2): (2 + ½ + ½ + 2)/4.
        assert!((q.mean - 1.25).abs() < 1e-12 && (q.p95 - 1.25).abs() < 1e-12);
        assert!(!q.is_isometric());
    }

    #[test]
    fn a_mirrored_map_is_all_flips() {
        let (disk, uv) = samples::plane(3, 3, 1.0, 1.0);
        let mirrored: UvMap = uv.iter().map(|p| DVec2::new(-p.x, p.y)).collect();
        let q = quality(&disk, &mirrored);
        assert_eq!(q.flips as usize, disk.triangles.len());
        assert_eq!(q.mean, f64::INFINITY);
    }

    #[test]
    fn rescaling_reaches_equal_area_and_least_energy() {
        let (disk, uv) = samples::plane(3, 3, 1.0, 1.0);
        let big: UvMap = uv.iter().map(|p| DVec2::new(7.0 * p.x, 3.0 * p.y)).collect();
        let big = rescale(&disk, big);
        assert!((scale(&disk, &big) - 1.0).abs() < 1e-12);
        let big = rescale_optimally(&disk, big);
        let (a, b) = dirichlet_sums(&disk, &big);
        assert!(((a + b) / 4.0 - quality(&disk, &big).optimal).abs() < 1e-12);
    }
}
