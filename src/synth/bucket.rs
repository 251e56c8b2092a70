//! A bucket or basket: a body with a wall, a rolled rim, ears and a bail. PartNet has two parts, container
//! and handle, so mostly the rim and the ears are the body's, sometimes the ears the bail's.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::SynthPart;
use super::solid::{Detail, Solid, cylinder, hoop, tube, vessel};

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
    let mut body = vessel(&outer, wall, 1.5 * wall, sides);
    let (own_rim, own_ears) = (rng.random_bool(0.3), rng.random_range(0..3));
    // Hoops round the wall, staves' bands, are the body's.
    for _ in 0..rng.random_range(0..3) {
        let t = rng.random_range(0.1..0.8);
        let r = radius * (taper + (1.0 - taper) * t);
        let band = hoop(&circle(r, t * height, sides), DVec3::Y, 0.5 * wall, detail.of(5.0, 5));
        body = body.and(band);
    }
    let mut parts = Vec::new();
    let path = circle(radius - 0.3 * wall, height, sides);
    let rim = hoop(&path, DVec3::Y, 0.9 * wall, detail.of(6.0, 6));
    if own_rim {
        parts.push(SynthPart::new("rim", rim));
    } else {
        body = body.and(rim);
    }
    let mut held = Solid::default();
    let y = height - rng.random_range(0.02..0.04);
    for (i, side) in [-1.0, 1.0].into_iter().enumerate() {
        let from = DVec3::new(side * 0.93 * radius, y, 0.0);
        let ear = cylinder(0.016, 0.16 * radius + 0.012, 0.002, detail.of(9.0, 6), 1)
            .along(from, from + DVec3::X * side);
        match own_ears {
            0 => parts.push(SynthPart::new(format!("ear_{}", i + 1), ear)),
            1 => body = body.and(ear),
            _ => held = held.and(ear),
        }
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
    let mut handle = tube(&bail, |_| wire, detail.of(5.0, 5)).and(held);
    if rng.random_bool(0.4) {
        // A grip about the middle of the bail.
        let third = m / 3;
        handle = handle.and(tube(&bail[third..=m - third], |_| 2.0 * wire, detail.of(6.0, 6)));
    }
    parts.push(SynthPart::new("handle", handle));
    parts.insert(0, SynthPart::new("body", body));
    parts
}

fn circle(radius: f64, y: f64, sides: usize) -> Vec<DVec3> {
    let at = |k: usize| {
        let (sin, cos) = (TAU * k as f64 / sides as f64).sin_cos();
        DVec3::new(radius * cos, y, -radius * sin)
    };
    (0..sides).map(at).collect()
}
