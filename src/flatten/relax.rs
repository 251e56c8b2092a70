//! Descent on the symmetric Dirichlet energy vertex by vertex, colour by colour: each vertex takes the projected Newton
//! step of its own faces (nonlinear Gauss–Seidel; Ortega & Rheinboldt 1970, 7.4), shortened until no face
//! flips and the energy falls. It needs no matrix and smooths what is short-waved in a few sweeps, which is
//! all that a map carried over from a coarser mesh leaves to do.

use glam::{DMat2, DVec2};

use super::colors::colors;
use super::fans::Fans;
use super::jacobian::{symmetric_dirichlet, symmetric_dirichlet_gradient};
use super::lscm::hat_gradients;
use super::model::Model;
use super::{Disk, UvMap};
use crate::contract::{Cancel, Canceled};
use crate::tasks;

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
    let fans = tasks::link("fans", || Fans::of(disk));
    let colors = tasks::link("colors", || colors(disk, &fans));
    for sweep in 0..sweeps {
        cancel.check()?;
        for i in 0..colors.len() {
            // Back and forth, so that no colour is favoured.
            let color = &colors[if sweep % 2 == 0 { i } else { colors.len() - 1 - i }];
            let moved = tasks::fill("sweep", color.len(), |i| {
                let v = color[i] as usize;
                stepped(disk, &uv, v, fans.at(v))
            });
            color.iter().zip(moved).for_each(|(&v, p)| uv[v as usize] = p);
        }
    }
    for _ in 0..ROUNDS {
        cancel.check()?;
        let is_strained = |&f: &usize| {
            disk.areas[f] > 0.0 && symmetric_dirichlet(disk.jacobian(f, &uv)) > STRAINED
        };
        let strained = tasks::blocks("strained", disk.triangles.len(), |faces| {
            faces.filter(is_strained).flat_map(|f| disk.triangles[f]).collect::<Vec<u32>>()
        });
        let strained = strained.concat();
        if strained.is_empty() {
            break;
        }
        let around = fans.around(disk, &strained, RINGS);
        for _ in 0..SWEEPS {
            for &(v, _) in &around {
                uv[v as usize] = stepped(disk, &uv, v as usize, fans.at(v as usize));
            }
        }
    }
    Ok(uv)
}

/// Energy of the faces around a vertex that lies at `at`.
fn energy(disk: &Disk, uv: &[DVec2], (v, at): (usize, DVec2), fan: &[u32]) -> f64 {
    let place = |w: u32| if w as usize == v { at } else { uv[w as usize] };
    let jacobian = |f: usize| {
        let [a, b, c] = disk.triangles[f].map(place);
        DMat2::from_cols(b - a, c - a) * disk.rest[f]
    };
    fan.iter()
        .map(|&c| c as usize / 3)
        .filter(|&f| disk.areas[f] > 0.0)
        .map(|f| disk.areas[f] * symmetric_dirichlet(jacobian(f)))
        .sum()
}

/// Where a vertex goes.
fn stepped(disk: &Disk, uv: &[DVec2], v: usize, fan: &[u32]) -> DVec2 {
    let from = uv[v];
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
            return from;
        }
        before += area * here;
        let hat = hat_gradients(&disk.rest[f])[k];
        gradient += symmetric_dirichlet_gradient(j) * hat * area;
        hessian += Model::newton(j).block(hat, hat) * area;
    }
    let direction = hessian.inverse() * -gradient;
    if !direction.is_finite() {
        return from;
    }
    let mut tries = (0..HALVINGS).map(|k| from + direction * 0.5f64.powi(k as i32));
    tries.find(|&at| energy(disk, uv, (v, at), fan) < before).unwrap_or(from)
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
