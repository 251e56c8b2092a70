//! Descent on the symmetric Dirichlet energy vertex by vertex: each vertex in turn takes the projected Newton
//! step of its own faces (nonlinear Gauss–Seidel; Ortega & Rheinboldt 1970, 7.4), shortened until no face
//! flips and the energy falls. It needs no matrix and smooths what is short-waved in a few sweeps, which is
//! all that a map carried over from a coarser mesh leaves to do.

use glam::{DMat2, DVec2};

use super::fans::{Fans, shortened};
use super::jacobian::{symmetric_dirichlet, symmetric_dirichlet_gradient};
use super::lscm::hat_gradients;
use super::model::Model;
use super::{Disk, UvMap};
use crate::contract::{Cancel, Canceled};

/// Times that a step is halved before the vertex stays.
const HALVINGS: u32 = 4;

/// Energy of a face beyond which its surroundings are swept on.
const STRAINED: f64 = 5.0;

/// Times that it is looked for strained faces, the rings around them, and the sweeps over these.
const ROUNDS: u32 = 12;
const RINGS: u32 = 2;
const SWEEPS: u32 = 4;

/// Sweep over all vertices, and on about faces that are strained. A map without flips stays without; others are
/// improved where they can be. The map is taken as it is scaled.
pub fn relax(disk: &Disk, mut uv: UvMap, sweeps: u32, cancel: &Cancel) -> Result<UvMap, Canceled> {
    let fans = Fans::of(disk);
    for sweep in 0..sweeps {
        cancel.check()?;
        // Back and forth, so that no direction is favoured.
        for i in 0..uv.len() {
            let v = if sweep % 2 == 0 { i } else { uv.len() - 1 - i };
            step(disk, &mut uv, v, fans.at(v));
        }
    }
    for _ in 0..ROUNDS {
        cancel.check()?;
        let strained: Vec<u32> = (0..disk.triangles.len())
            .filter(|&f| disk.areas[f] > 0.0)
            .filter(|&f| symmetric_dirichlet(disk.jacobian(f, &uv)) > STRAINED)
            .flat_map(|f| disk.triangles[f])
            .collect();
        if strained.is_empty() {
            break;
        }
        let around = fans.around(disk, &strained, RINGS);
        for _ in 0..SWEEPS {
            for &(v, _) in &around {
                step(disk, &mut uv, v as usize, fans.at(v as usize));
            }
        }
    }
    Ok(uv)
}

fn energy(disk: &Disk, uv: &[DVec2], fan: &[u32]) -> f64 {
    fan.iter()
        .map(|&c| c as usize / 3)
        .filter(|&f| disk.areas[f] > 0.0)
        .map(|f| disk.areas[f] * symmetric_dirichlet(disk.jacobian(f, uv)))
        .sum()
}

fn step(disk: &Disk, uv: &mut UvMap, v: usize, fan: &[u32]) {
    let (mut gradient, mut hessian, mut before) = (DVec2::ZERO, DMat2::ZERO, 0.0);
    for &c in fan {
        let (f, k) = (c as usize / 3, c as usize % 3);
        let area = disk.areas[f];
        if area <= 0.0 {
            continue;
        }
        let j = disk.jacobian(f, uv);
        let here = symmetric_dirichlet(j);
        if !here.is_finite() {
            return;
        }
        before += area * here;
        let hat = hat_gradients(&disk.rest[f])[k];
        gradient += symmetric_dirichlet_gradient(j) * hat * area;
        hessian += Model::newton(j).block(hat, hat) * area;
    }
    let direction = hessian.inverse() * -gradient;
    if !direction.is_finite() {
        return;
    }
    shortened(uv, v, direction, HALVINGS, |uv| energy(disk, uv, fan) < before);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::{count_flips, quality, samples};

    #[test]
    fn short_waves_are_gone_after_a_few_sweeps() {
        let (disk, flat) = samples::plane(20, 20, 1.0, 1.0);
        let shaken: UvMap = flat
            .iter()
            .enumerate()
            .map(|(i, p)| p + 0.012 * DVec2::from_angle((i * i) as f64))
            .collect();
        let before = quality(&disk, &shaken);
        let uv = relax(&disk, shaken, 6, &Cancel::default()).unwrap();
        let after = quality(&disk, &uv);
        assert!(count_flips(&disk, &uv) == 0);
        assert!(after.mean - 1.0 < 0.05 * (before.mean - 1.0), "{before:?} {after:?}");
    }

    #[test]
    fn an_isometry_stays() {
        let (disk, flat) = samples::plane(5, 5, 1.0, 1.0);
        let uv = relax(&disk, flat.clone(), 3, &Cancel::default()).unwrap();
        assert!(uv.iter().zip(&flat).all(|(p, q)| p.distance(*q) < 1e-12));
    }
}
