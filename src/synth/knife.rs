//! A kitchen knife along x: a blade that thins to its edge and point, a bolster, a swelling handle
//! and rivets. y points from the edge to the spine.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DQuat, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::SynthPart;
use super::solid::{Cap, Detail, Solid, cylinder, skin};

/// The blade from x = `start` to its point: flat sides down to the bevel line, then the bevel.
fn blade(start: f64, length: f64, height: f64, detail: Detail) -> Solid {
    let n = detail.of(14.0, 6);
    let mut rings = vec![];
    for i in 0..n {
        let t = i as f64 / n as f64;
        let x = start + t * length;
        // The spine drops to the point late, the edge rises in a long belly.
        let spine = 0.5 * height * (1.0 - 1.1 * t.powi(4));
        let edge = -0.5 * height * (1.0 - 0.9 * t.powi(5));
        let half = 0.0019 * (1.0 - 0.75 * t);
        let tall = spine - edge;
        let pieces = detail.of(3.0, 2);
        let mut ring = vec![];
        // Down one side, over the edge, up the other.
        for side in [1.0, -1.0] {
            let mut column: Vec<DVec3> = (0..=pieces)
                .map(|k| {
                    let s = 0.72 * k as f64 / pieces as f64;
                    DVec3::new(x, spine - s * tall, side * half * (1.0 - 0.25 * s))
                })
                .collect();
            if side > 0.0 {
                column.push(DVec3::new(x, edge, 0.0));
            } else {
                column.reverse();
            }
            ring.extend(column);
        }
        rings.push(ring);
    }
    rings.push(vec![DVec3::new(start + length, -0.055 * height, 0.0)]);
    skin(&rings, Cap::Ladder)
}

/// A solid along x with elliptic cross-sections: (x, centre y, half height, half width).
fn elliptic(sections: &[(f64, f64, f64, f64)], sides: usize) -> Solid {
    let ring = |&(x, y, tall, wide): &(f64, f64, f64, f64)| {
        let point = |j: usize| {
            let (sin, cos) = (TAU * j as f64 / sides as f64).sin_cos();
            DVec3::new(x, y + tall * cos, wide * sin)
        };
        (0..sides).map(point).collect()
    };
    skin(&sections.iter().map(ring).collect::<Vec<_>>(), Cap::Fan)
}

pub(super) fn parts(rng: &mut ChaCha8Rng, detail: Detail) -> Vec<SynthPart> {
    let length = rng.random_range(0.16..0.22);
    let height = rng.random_range(0.036..0.046);
    let handle = rng.random_range(0.105..0.125);
    let swell = rng.random_range(0.8..1.2);
    let rivets: usize = rng.random_range(2..=3);

    let mut parts = vec![SynthPart::new("blade", blade(-0.004, length, height, detail))];

    let sides = detail.of(11.0, 8);
    // The bolster reaches over the heel of the blade and into the handle.
    let collar = [
        (-0.018, 0.0, 0.0150, 0.0088),
        (-0.012, 0.0, 0.0162, 0.0098),
        (-0.004, 0.0, 0.0150, 0.0080),
        (0.004, 0.0, 0.0130, 0.0050),
        (0.008, 0.0, 0.0118, 0.0038),
    ];
    parts.push(SynthPart::new("bolster", elliptic(&collar, sides)));

    let n = detail.of(9.0, 5);
    let mut sections: Vec<_> = (0..=n)
        .map(|i| {
            let t = i as f64 / n as f64;
            let bulge = (t * FRAC_PI_2 * 2.0).sin();
            let droop = -0.006 * swell * t * t;
            let tall = 0.0132 + 0.0022 * swell * bulge + 0.0016 * t;
            (-0.014 - handle * t, droop, tall, 0.0088 + 0.0018 * bulge)
        })
        .collect();
    // A rounded butt.
    if let Some(&(x, y, tall, wide)) = sections.last() {
        sections.push((x - 0.0035, y, 0.90 * tall, 0.88 * wide));
        sections.push((x - 0.0055, y, 0.66 * tall, 0.62 * wide));
    }
    sections.reverse();
    parts.push(SynthPart::new("handle", elliptic(&sections, sides)));

    for i in 0..rivets {
        let t = (i as f64 + 0.7) / (rivets as f64 + 0.4);
        let half = 0.0092 + 0.0018 * (t * FRAC_PI_2 * 2.0).sin();
        let rivet = cylinder(0.0036, 2.0 * half, 0.0007, detail.of(8.0, 6), detail.of(1.5, 1))
            .shifted(DVec3::new(0.0, -half, 0.0))
            .map(|p| DQuat::from_rotation_x(FRAC_PI_2) * p)
            .shifted(DVec3::new(-0.014 - handle * t, -0.006 * swell * t * t, 0.0));
        parts.push(SynthPart::new(format!("rivet_{}", i + 1), rivet));
    }
    parts
}
