//! A cup or mug: a body with a wall, straight, bellied or flared, none to two handles, sometimes a foot
//! or a saucer.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::SynthPart;
use super::solid::{Detail, lathe, tube, vessel};

pub(super) fn parts(rng: &mut ChaCha8Rng, detail: Detail) -> Vec<SynthPart> {
    let radius = rng.random_range(0.034..0.052);
    let height = rng.random_range(0.06..0.13);
    let wall = rng.random_range(0.004..0.007);
    let belly = rng.random_range(-0.12..0.25);
    let flare = rng.random_range(-0.15..0.35);
    let handles = rng.random_range(0..=6).min(2usize);
    let goblet = rng.random_bool(0.25);

    let n = detail.of(9.0, 4);
    let at = |t: f64| radius * (1.0 + flare * (t - 0.5) + belly * (PI * t).sin());
    let outer: Vec<DVec2> =
        (0..=n).map(|i| i as f64 / n as f64).map(|t| DVec2::new(at(t), t * height)).collect();
    let lift = if goblet { rng.random_range(0.3..0.8) * height } else { 0.0 };
    let sides = detail.of(18.0, 10);
    let up = DVec3::Y * lift;
    let body = vessel(&outer, wall, 1.3 * wall, sides).shifted(up);
    let mut parts = vec![SynthPart::new("body", body)];

    let thick = rng.random_range(0.0045..0.008);
    let out = rng.random_range(0.45..0.85) * radius;
    let (low, high) = (rng.random_range(0.12..0.3), rng.random_range(0.7..0.9));
    let m = detail.of(12.0, 6);
    for i in 0..handles {
        let side = if i == 0 { 1.0 } else { -1.0 };
        let path: Vec<DVec3> = (0..=m)
            .map(|k| {
                let t = k as f64 / m as f64;
                let y = low + (high - low) * t;
                // Ends within the wall.
                let x = at(y) - 0.6 * wall + (out + thick) * (PI * t).sin().powf(0.7);
                DVec3::new(side * x, lift + y * height, 0.0)
            })
            .collect();
        let handle = tube(&path, |_| thick, detail.of(7.0, 6));
        parts.push(SynthPart::new(format!("handle_{}", i + 1), handle));
    }
    if goblet {
        let foot = rng.random_range(0.7..1.1) * radius;
        let stem = rng.random_range(0.12..0.25) * radius;
        let marks = [
            (0.0, 0.0),
            (foot, 0.0),
            (foot, 0.05 * lift),
            (0.5 * (foot + stem), 0.12 * lift),
            (stem, 0.3 * lift),
            (stem, 0.8 * lift),
            (1.5 * stem, lift + 0.4 * wall),
            (0.0, lift + 0.6 * wall),
        ];
        let profile: Vec<DVec2> = marks.iter().map(|&(r, y)| DVec2::new(r, y)).collect();
        parts.push(SynthPart::new("foot", lathe(&profile, sides)));
    }
    parts
}
