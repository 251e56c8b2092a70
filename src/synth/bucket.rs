//! A bucket or basket: a body with a wall, a rolled rim, ears and a bail.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::SynthPart;
use super::solid::{Detail, cylinder, hoop, tube, vessel};

pub(super) fn parts(rng: &mut ChaCha8Rng, detail: Detail) -> Vec<SynthPart> {
    let radius = rng.random_range(0.12..0.17);
    let height = rng.random_range(0.18..0.32);
    let taper = rng.random_range(0.65..0.95);
    let wall = rng.random_range(0.006..0.010);
    let n = detail.of(6.0, 3);
    let outer: Vec<DVec2> = (0..=n)
        .map(|i| i as f64 / n as f64)
        .map(|t| DVec2::new(radius * (taper + (1.0 - taper) * t), t * height))
        .collect();
    let sides = detail.of(20.0, 12);
    let mut parts = vec![SynthPart::new("body", vessel(&outer, wall, 1.5 * wall, sides))];
    let path: Vec<DVec3> = (0..sides)
        .map(|k| {
            let (sin, cos) = (TAU * k as f64 / sides as f64).sin_cos();
            DVec3::new((radius - 0.3 * wall) * cos, height, -(radius - 0.3 * wall) * sin)
        })
        .collect();
    parts.push(SynthPart::new("rim", hoop(&path, DVec3::Y, 0.9 * wall, detail.of(6.0, 6))));
    let y = height - rng.random_range(0.02..0.04);
    for (i, side) in [-1.0, 1.0].into_iter().enumerate() {
        let from = DVec3::new(side * 0.93 * radius, y, 0.0);
        let ear = cylinder(0.016, 0.16 * radius + 0.012, 0.002, detail.of(9.0, 6), 1)
            .along(from, from + DVec3::X * side);
        parts.push(SynthPart::new(format!("ear_{}", i + 1), ear));
    }
    let tilt = rng.random_range(0.0..0.5 * PI);
    let wire = rng.random_range(0.004..0.006);
    let reach = radius * 1.05 + 0.005;
    let m = detail.of(18.0, 9);
    let bail: Vec<DVec3> = (0..=m)
        .map(|k| {
            let (sin, cos) = (PI * k as f64 / m as f64).sin_cos();
            let up = 1.05 * reach * sin;
            DVec3::new(reach * cos, y + up * tilt.cos(), up * tilt.sin())
        })
        .collect();
    parts.push(SynthPart::new("handle", tube(&bail, |_| wire, detail.of(5.0, 5))));
    parts
}
