//! A faucet: a base, a bent spout and one or two levers or wheels.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DVec2, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::SynthPart;
use super::solid::{Detail, board, cylinder, lathe, tube};

pub(super) fn parts(rng: &mut ChaCha8Rng, detail: Detail) -> Vec<SynthPart> {
    let radius = rng.random_range(0.018..0.028);
    let tall = rng.random_range(0.06..0.12);
    let pipe = rng.random_range(0.45..0.75) * radius;
    let rise = rng.random_range(0.02..0.18);
    let reach = rng.random_range(0.10..0.18);
    let two = rng.random_bool(0.4);
    let wheel = rng.random_bool(0.35);
    let round = detail.of(12.0, 8);

    let marks = [
        (0.0, 0.0),
        (1.4 * radius, 0.0),
        (1.4 * radius, 0.06 * tall),
        (radius, 0.14 * tall),
        (0.92 * radius, tall),
        (0.6 * radius, 1.08 * tall),
        (0.0, 1.1 * tall),
    ];
    let profile: Vec<DVec2> = marks.iter().map(|&(r, y)| DVec2::new(r, y)).collect();
    let mut parts = vec![SynthPart::new("base", lathe(&profile, round))];

    // Up, over in an arc, and down to the mouth.
    let bend = 0.5 * reach;
    let n = detail.of(16.0, 8);
    let curve = |t: f64| {
        let (sin, cos) = (2.0 * FRAC_PI_2 * t).sin_cos();
        DVec3::new(0.0, 0.9 * tall + rise + 0.8 * bend * sin, bend * (1.0 - cos))
    };
    let mut path = vec![DVec3::new(0.0, 0.8 * tall, 0.0)];
    path.extend((0..=n).map(|i| curve(i as f64 / n as f64)));
    path.push(curve(1.0) - DVec3::Y * (0.3 * rise + 0.01));
    parts.push(SynthPart::new("spout", tube(&path, |_| pipe, detail.of(9.0, 6))));

    let stems = if two { vec![-1.0, 1.0] } else { vec![1.0] };
    for (i, side) in stems.into_iter().enumerate() {
        let out = if two { 2.4 * radius } else { 1.5 * radius };
        let y = 0.6 * tall;
        let stem = cylinder(0.45 * radius, out, 0.0, detail.of(8.0, 6), detail.of(2.0, 1))
            .along(DVec3::new(side * 0.5 * radius, y, 0.0), DVec3::new(side * 9.0, y, 0.0));
        parts.push(SynthPart::new(format!("stem_{}", i + 1), stem));
        let end = DVec3::new(side * (0.4 * radius + out), y, 0.0);
        let handle = if wheel {
            let lobes = 4.0;
            cylinder(radius, 0.5 * radius, 0.08 * radius, detail.of(16.0, 12), 1)
                .map(|p| {
                    let swell = 1.0 + 0.12 * (lobes * p.x.atan2(p.z)).cos();
                    DVec3::new(p.x * swell, p.y, p.z * swell)
                })
                .along(end, end + DVec3::X * side)
        } else {
            let lever = DVec3::new(0.22 * radius, 0.12 * radius, 1.1 * radius);
            let turn = glam::DQuat::from_rotation_x(-TAU * 0.03);
            board(lever, [1, detail.of(4.0, 3)])
                .map(|p| end + turn * (p + DVec3::Z * (0.7 * radius)))
        };
        parts.push(SynthPart::new(format!("handle_{}", i + 1), handle));
    }
    parts
}
