//! A vase: a turned body with a wall, often on a foot, with a collar and none to two handles.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::SynthPart;
use super::profile::turned;
use super::solid::{Detail, lathe, tube, vessel};

pub(super) fn parts(rng: &mut ChaCha8Rng, detail: Detail) -> Vec<SynthPart> {
    let height = rng.random_range(0.18..0.4);
    let belly = rng.random_range(0.22..0.42) * height;
    let foot = rng.random_range(0.35..0.7) * belly;
    let neck = rng.random_range(0.25..0.65) * belly;
    let lip = neck * rng.random_range(1.05..1.7);
    let (wide, narrow) = (rng.random_range(0.3..0.6), rng.random_range(0.72..0.85));
    let wall = f64::min(0.16 * neck, 0.03 * height);
    let sides = detail.of(18.0, 10);

    let marks = [
        DVec2::new(foot, 0.0),
        DVec2::new(belly, wide * height),
        DVec2::new(neck, narrow * height),
        DVec2::new(lip, height),
    ];
    let outer = turned(&marks, detail.of(14.0, 5));
    let mut parts = vec![SynthPart::new("body", vessel(&outer, wall, 1.5 * wall, sides))];

    if rng.random_bool(0.6) {
        let (tall, spread) = (rng.random_range(0.04..0.12) * height, rng.random_range(1.0..1.4));
        let marks = [
            (0.0, -tall),
            (spread * foot, -tall),
            (spread * foot, -0.8 * tall),
            (0.9 * foot, -0.3 * tall),
            (0.9 * foot, 0.5 * wall),
            (0.0, 0.5 * wall),
        ];
        let profile: Vec<DVec2> = marks.iter().map(|&(r, y)| DVec2::new(r, y)).collect();
        parts.push(SynthPart::new("foot", lathe(&profile, sides)));
    }
    let handles = rng.random_range(0..=2usize);
    let (low, high) = (wide + 0.08, narrow + 0.1);
    let at = |t: f64| {
        let after = outer.iter().position(|p| p.y >= t * height).unwrap_or(outer.len() - 1).max(1);
        let (p, q) = (outer[after - 1], outer[after]);
        p.lerp(q, ((t * height - p.y) / (q.y - p.y)).clamp(0.0, 1.0)).x
    };
    let m = detail.of(14.0, 7);
    for i in 0..handles {
        let side = if i == 0 { 1.0 } else { -1.0 };
        let path: Vec<DVec3> = (0..=m)
            .map(|k| {
                let t = k as f64 / m as f64;
                let ends = at(low) * (1.0 - t) + at(high) * t - 0.5 * wall;
                let out = 0.55 * belly * (PI * t).sin().powf(0.7);
                DVec3::new(side * (ends + out), height * (low + (high - low) * t), 0.0)
            })
            .collect();
        let thick = rng.random_range(0.018..0.03) * height;
        let handle = tube(&path, |_| thick, detail.of(6.0, 6));
        parts.push(SynthPart::new(format!("handle_{}", i + 1), handle));
    }
    parts
}
