//! Scissors or pliers, half open: two blades (jaws), each with a shank and a finger ring or a long grip,
//! and the screw through both.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::SynthPart;
use super::solid::{Detail, Rim, Solid, cylinder, hoop, slab, tube};

/// A flat blade from the screw at the origin to its point on the x axis.
fn blade(length: f64, wide: f64, thick: f64, blunt: f64, detail: Detail) -> Solid {
    let sheet = |y: f64| {
        move |u: f64, v: f64| {
            let t = 0.5 * (u + 1.0);
            let half = wide * (1.0 - (1.0 - blunt) * t.powi(2));
            DVec3::new(-0.6 * wide + t * (length + 0.6 * wide), y, -v * half)
        }
    };
    let cells = [detail.of(9.0, 4), detail.of(1.5, 1)];
    slab(cells, sheet(0.5 * thick), sheet(-0.5 * thick), &[Rim { rise: 0.5, out: 0.12 * thick }])
}

pub(super) fn parts(rng: &mut ChaCha8Rng, detail: Detail) -> Vec<SynthPart> {
    let pliers = rng.random_bool(0.4);
    let length = if pliers { rng.random_range(0.03..0.05) } else { rng.random_range(0.07..0.11) };
    let wide = rng.random_range(0.006..0.009);
    let thick = rng.random_range(0.003..0.005) * if pliers { 2.0 } else { 1.0 };
    let shank = rng.random_range(0.05..0.08);
    let open = rng.random_range(0.10..0.35_f64);
    let ring = rng.random_range(0.014..0.020);
    let wire = rng.random_range(0.0032..0.0045);
    let bow = rng.random_range(0.0..0.3);
    let mut parts = Vec::new();
    for (i, side) in [1.0, -1.0].into_iter().enumerate() {
        let turn = DQuat::from_rotation_y(side * open);
        let lift = DVec3::Y * (side * 0.42 * thick);
        let place = |s: Solid| s.map(|p| turn * p + lift);
        let blunt = if pliers { 0.55 } else { 0.12 };
        let metal = place(blade(length, wide, thick, blunt, detail));
        let jaw = if pliers { "jaw" } else { "blade" };
        parts.push(SynthPart::new(format!("{jaw}_{}", i + 1), metal));

        let reach = if pliers { 1.6 * shank } else { shank };
        let n = detail.of(8.0, 4);
        let spread = side * (wide + if pliers { 0.006 } else { ring });
        let arm = |t: f64| {
            let z = spread * (t + bow * (TAU * 0.5 * t).sin());
            DVec3::new(0.2 * wide - t * reach, 0.0, z)
        };
        let path: Vec<DVec3> = (0..=n).map(|k| arm(k as f64 / n as f64)).collect();
        let (from, to) = if pliers { (1.0, 1.5) } else { (1.0, 0.9) };
        let grip = tube(&path, |t| wire * (from + (to - from) * t), detail.of(6.0, 6));
        let name = if pliers { "handle" } else { "shank" };
        parts.push(SynthPart::new(format!("{name}_{}", i + 1), place(grip)));
        if !pliers {
            let end = arm(1.0) - DVec3::X * (0.8 * ring);
            let n = detail.of(14.0, 10);
            let loop_at = |k: usize| {
                let (sin, cos) = (TAU * k as f64 / n as f64).sin_cos();
                end + DVec3::new(1.15 * ring * cos, 0.0, -0.9 * ring * sin)
            };
            let path: Vec<DVec3> = (0..n).map(loop_at).collect();
            let bow = hoop(&path, DVec3::Y, wire, detail.of(6.0, 6));
            parts.push(SynthPart::new(format!("handle_{}", i + 1), place(bow)));
        }
    }
    let tall = 2.6 * thick;
    let screw = cylinder(0.55 * wide, tall, 0.08 * wide, detail.of(8.0, 6), 1);
    parts.push(SynthPart::new("screw", screw.shifted(DVec3::Y * (-0.5 * tall))));
    parts
}
