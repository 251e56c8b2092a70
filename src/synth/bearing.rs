//! A machine part: a hub with a bore, flanges, a plate with bosses or feet, a shaft.

use std::f64::consts::TAU;

use glam::DVec3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::SynthPart;
use super::solid::{Detail, board, cylinder, hollow};

pub(super) fn parts(rng: &mut ChaCha8Rng, detail: Detail) -> Vec<SynthPart> {
    let radius = rng.random_range(0.03..0.05);
    let bore = rng.random_range(0.35..0.7) * radius;
    let length = rng.random_range(0.03..0.1);
    let round = detail.of(18.0, 12);
    let rows = detail.of(4.0, 2);
    let hub = hollow(radius, bore, length, round, rows);
    let mut parts = vec![SynthPart::new("hub", hub)];
    let flange = rng.random_range(1.3..2.0) * radius;
    let plate = rng.random_range(0.008..0.016);
    let ends = rng.random_range(1..=2usize);
    for i in 0..ends {
        let y = if i == 0 { -0.3 * plate } else { length - 0.7 * plate };
        let ring = hollow(flange, 0.97 * radius, plate, round, 1).shifted(DVec3::Y * y);
        parts.push(SynthPart::new(format!("flange_{}", i + 1), ring));
    }
    let bolts = rng.random_range(3..=6usize);
    for i in 0..bolts {
        let (sin, cos) = (TAU * i as f64 / bolts as f64).sin_cos();
        let at =
            DVec3::new(0.5 * (radius + flange) * cos, 0.3 * plate, 0.5 * (radius + flange) * sin);
        let size = 0.2 * (flange - radius);
        let bolt = cylinder(size, 0.9 * plate, 0.1 * size, detail.of(7.0, 6), 1).shifted(at);
        parts.push(SynthPart::new(format!("bolt_{}", i + 1), bolt));
    }
    if rng.random_bool(0.6) {
        let long = rng.random_range(1.3..2.6) * length;
        let shaft = cylinder(1.02 * bore, long, 0.08 * bore, round, rows)
            .shifted(DVec3::Y * (0.5 * (length - long)));
        parts.push(SynthPart::new("shaft", shaft));
    }
    if rng.random_bool(0.5) {
        let wide = rng.random_range(1.5..2.2) * flange;
        let foot = board(
            DVec3::new(wide, 0.010, 0.5 * length + 0.01),
            [detail.of(6.0, 3), detail.of(3.0, 2)],
        )
        .map(|p| DVec3::new(p.x, -p.z, p.y))
        .shifted(DVec3::new(0.0, 0.5 * length, -flange));
        parts.push(SynthPart::new("base", foot));
    }
    parts
}
