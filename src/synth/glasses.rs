//! Glasses: two rims with or without lenses, a bridge, hinges and bent temples.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::SynthPart;
use super::outline::squircle;
use super::solid::{Detail, board, hoop, lathe, tube};

pub(super) fn parts(rng: &mut ChaCha8Rng, detail: Detail) -> Vec<SynthPart> {
    let half = DVec2::new(rng.random_range(0.021..0.028), rng.random_range(0.015..0.022));
    let apart = half.x + rng.random_range(0.008..0.011);
    let wire = rng.random_range(0.0012..0.0024);
    let power = rng.random_range(2.0..4.0);
    let long = rng.random_range(0.11..0.14);
    let lenses = rng.random_bool(0.6);
    let mut parts = Vec::new();
    let n = detail.of(20.0, 12);
    for (i, side) in [-1.0, 1.0].into_iter().enumerate() {
        let at = |k: usize| {
            let (sin, cos) = (TAU * k as f64 / n as f64).sin_cos();
            let m = sin.abs().max(cos.abs());
            let p = squircle(cos / m, sin / m, power);
            DVec3::new(side * apart + half.x * p.x, half.y * p.y, 0.0)
        };
        let path: Vec<DVec3> = (0..n).map(at).collect();
        let rim = hoop(&path, DVec3::Z, wire, detail.of(5.0, 5));
        parts.push(SynthPart::new(format!("rim_{}", i + 1), rim));
        if lenses {
            let thick = 0.5 * wire;
            let marks = [(0.0, -thick), (1.0, -thick), (1.0, thick), (0.0, thick)];
            let profile: Vec<DVec2> = marks.iter().map(|&(r, y)| DVec2::new(r, y)).collect();
            let lens = lathe(&profile, n).map(|p| {
                let m = p.x.abs().max(p.z.abs()).max(1e-9);
                let reach = p.x.hypot(p.z);
                let q = squircle(p.x / m, p.z / m, power) * reach;
                DVec3::new(side * apart + half.x * q.x, -half.y * q.y, p.y)
            });
            parts.push(SynthPart::new(format!("lens_{}", i + 1), lens));
        }
    }
    let gap = apart - half.x;
    let k = detail.of(6.0, 4);
    let arch = rng.random_range(0.1..0.5) * half.y;
    let bridge: Vec<DVec3> = (0..=k)
        .map(|i| 2.0 * i as f64 / k as f64 - 1.0)
        .map(|t| DVec3::new(t * (gap + wire), 0.25 * half.y + arch * (1.0 - t * t), 0.0))
        .collect();
    parts.push(SynthPart::new("bridge", tube(&bridge, |_| wire, detail.of(5.0, 5))));
    let outer = apart + half.x;
    let drop = rng.random_range(0.02..0.04);
    let m = detail.of(14.0, 7);
    for (i, side) in [-1.0, 1.0].into_iter().enumerate() {
        let y = 0.3 * half.y;
        let hinge = board(DVec3::new(2.4 * wire, 1.6 * wire, 1.8 * wire), [1, 1])
            .shifted(DVec3::new(side * (outer + 1.2 * wire), y, -0.6 * wire));
        parts.push(SynthPart::new(format!("hinge_{}", i + 1), hinge));
        let path: Vec<DVec3> = (0..=m)
            .map(|j| {
                let t = j as f64 / m as f64;
                let ear = (t - 0.72).max(0.0) / 0.28;
                let x = outer + 1.6 * wire - 0.004 * t;
                DVec3::new(side * x, y - drop * ear * ear, -wire - t * long)
            })
            .collect();
        let temple = tube(&path, |t| wire * (0.9 + 0.4 * t), detail.of(5.0, 5));
        parts.push(SynthPart::new(format!("temple_{}", i + 1), temple));
    }
    parts
}
