//! A bottle: a body, a neck and a cap, sometimes with a grip.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::SynthPart;
use super::solid::{Detail, cylinder, lathe, tube};

pub(super) fn parts(rng: &mut ChaCha8Rng, detail: Detail) -> Vec<SynthPart> {
    let radius = rng.random_range(0.03..0.05);
    let height = rng.random_range(0.12..0.24);
    let shoulder = rng.random_range(0.2..0.9) * radius;
    let neck = rng.random_range(0.28..0.5) * radius;
    let reach = rng.random_range(0.3..1.6) * radius;
    let waist = rng.random_range(0.0..0.15);
    let sides = detail.of(16.0, 9);

    let n = detail.of(8.0, 3);
    let mut body = vec![DVec2::ZERO, DVec2::new(0.9 * radius, 0.0)];
    body.extend((0..=n).map(|i| {
        let t = i as f64 / n as f64;
        DVec2::new(radius * (1.0 - waist * (PI * t).sin().powi(2)), 0.1 * radius + t * height)
    }));
    let top = height + 0.1 * radius;
    let m = detail.of(4.0, 2);
    body.extend((1..=m).map(|i| {
        let (sin, cos) = (0.5 * PI * i as f64 / m as f64).sin_cos();
        DVec2::new(neck + (radius - neck) * cos, top + shoulder * sin)
    }));
    body.push(DVec2::new(0.0, top + shoulder));
    let mut parts = vec![SynthPart::new("body", lathe(&body, sides))];

    let foot = top + 0.9 * shoulder;
    let round = detail.of(10.0, 7);
    let pipe = cylinder(neck, reach + 0.1 * shoulder, 0.0, round, detail.of(3.0, 1));
    parts.push(SynthPart::new("neck", pipe.shifted(DVec3::Y * foot)));
    let tall = rng.random_range(0.25..0.6) * radius;
    let cap = cylinder(1.18 * neck, tall, 0.1 * neck, round, detail.of(2.0, 1));
    parts.push(SynthPart::new("cap", cap.shifted(DVec3::Y * (foot + reach - 0.3 * tall))));
    if rng.random_bool(0.3) {
        let k = detail.of(10.0, 5);
        let path: Vec<DVec3> = (0..=k)
            .map(|i| {
                let t = i as f64 / k as f64;
                let x = 0.93 * radius * (1.0 - waist) + 0.6 * radius * (PI * t).sin().powf(0.7);
                DVec3::new(x, height * (0.35 + 0.45 * t), 0.0)
            })
            .collect();
        parts.push(SynthPart::new("handle", tube(&path, |_| 0.16 * radius, detail.of(6.0, 6))));
    }
    parts
}
