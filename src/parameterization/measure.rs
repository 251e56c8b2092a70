//! Measures of a map that the trainer takes at every step, besides the losses: its energy, and what
//! makes the gradient of the losses that of the scaled map.

use glam::DVec2;

use crate::flatten::{Disk, scale, symmetric_dirichlet};

/// Area-weighted mean symmetric Dirichlet energy at equal area; infinite where a triangle is
/// flipped.
pub(super) fn energy(disk: &Disk, uv: &[DVec2]) -> f64 {
    let inverse = 1.0 / scale(disk, uv);
    let (mut sum, mut total) = (0.0, 0.0);
    for (f, &area) in disk.areas.iter().enumerate() {
        if area > 0.0 {
            sum += area * symmetric_dirichlet(disk.jacobian(f, uv) * inverse);
            total += area;
        }
    }
    let mean = if total > 0.0 { sum / total } else { 1.0 };
    if mean.is_nan() { f64::INFINITY } else { mean }
}

/// From the gradient of a loss of u/s with s held constant to that of the loss itself, s = √(Σ|A_uv|/
/// ΣA). Such a loss does not change when the map grows, so g·u = −s ∂L/∂s, and g − (g·u)∇s/s remains.
/// Without this the terms that pull inwards would shrink the map step by step, and with it the length
/// that a step of the optimiser is measured against.
pub(super) fn free_scale(disk: &Disk, uv: &[DVec2], gradient: &mut [DVec2]) {
    let growth: f64 = gradient.iter().zip(uv).map(|(g, u)| g.dot(*u)).sum();
    let areas = || (0..disk.triangles.len()).filter(|&f| disk.areas[f] > 0.0);
    let total: f64 = areas().map(|f| disk.uv_area(f, uv).abs()).sum();
    if total <= 0.0 || total.is_nan() {
        return;
    }
    // ∇s/s = ∇Σ|A_uv| / (2 Σ|A_uv|), and the gradient of an area by a corner is half the opposite
    // side, turned.
    for f in areas() {
        let t = disk.triangles[f].map(|v| v as usize);
        let factor = 0.25 * growth / total * disk.uv_area(f, uv).signum();
        for k in 0..3 {
            let side = uv[t[(k + 2) % 3]] - uv[t[(k + 1) % 3]];
            gradient[t[k]] -= factor * side.perp();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::LossForm;
    use crate::parameterization::losses::{Annealing, ChartTerms, LossContext, Term, TermValues};
    use crate::parameterization::scenes;

    fn dot(a: &TermValues, b: &TermValues) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    /// The derivative of the losses of u/s(u), by finite differences in f64. The scene has no flips, so
    /// s is smooth.
    #[test]
    fn the_freed_gradient_is_that_of_the_scaled_map() {
        let (disk, mut uv) = scenes::barrel(5, 4);
        uv.iter_mut().for_each(|u| *u *= 1.3);
        let context = LossContext { form: LossForm::Sound, ..Default::default() };
        let terms = ChartTerms::new(&disk, context);
        let weights = Term::ALL.map(Term::lambda);
        let at = Annealing::at(0.5);
        let value = |uv: &[DVec2]| {
            let mut unused = vec![DVec2::ZERO; uv.len()];
            dot(&weights, &terms.evaluate_sum(&weights, uv, terms.scale(uv), at, &mut unused))
        };
        let mut gradient = vec![DVec2::ZERO; uv.len()];
        terms.evaluate_sum(&weights, &uv, terms.scale(&uv), at, &mut gradient);
        free_scale(&disk, &uv, &mut gradient);
        let along: f64 = gradient.iter().zip(&uv).map(|(g, u)| g.dot(*u)).sum();
        assert!(along.abs() < 1e-9, "growing changes nothing: {along}");
        for v in 0..uv.len() {
            for axis in [DVec2::X, DVec2::Y] {
                let shifted = |h: f64| {
                    let mut moved = uv.clone();
                    moved[v] += h * axis;
                    value(&moved)
                };
                let want = (shifted(1e-5) - shifted(-1e-5)) / 2e-5;
                let got = gradient[v].dot(axis);
                assert!((got - want).abs() < 1e-5 * (1.0 + want.abs()), "{v}: {got} {want}");
            }
        }
    }
}
