//! A suitcase or safe: two shells that meet at a band, a handle, latches, wheels or feet.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DQuat, DVec2, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::SynthPart;
use super::outline::RoundedRectangle;
use super::solid::{Detail, Rim, board, cylinder, slab, tube};

pub(super) fn parts(rng: &mut ChaCha8Rng, detail: Detail) -> Vec<SynthPart> {
    let half = DVec3::new(
        rng.random_range(0.18..0.3),
        rng.random_range(0.06..0.12),
        rng.random_range(0.24..0.38),
    );
    let soft = rng.random_range(0.01..0.03);
    let cells = [detail.of(8.0, 6), detail.of(10.0, 6)];
    let inner = DVec2::new(half.x - soft, half.z - soft);
    let outline =
        RoundedRectangle { half: inner, radius: rng.random_range(0.5..1.5) * soft, cells };
    let sheet = |y: f64| {
        move |u: f64, v: f64| {
            let p = outline.at(u, v);
            DVec3::new(p.x, y, -p.y)
        }
    };
    let split = rng.random_range(0.1..0.6);
    let share = soft / ((1.0 - split) * half.y);
    let shell = |low: f64, high: f64, share: f64| {
        let rims = [
            Rim { rise: 0.4 * share, out: 0.7 * soft },
            Rim { rise: share, out: soft },
            Rim { rise: 1.0 - 0.02, out: soft },
        ];
        slab(cells, sheet(high), sheet(low), &rims)
    };
    // The lid is a base turned over; they overlap by a hair.
    let joint = split * half.y;
    let base = shell(-half.y, joint, soft / (half.y + joint));
    let lid =
        shell(-half.y, 0.002 - joint, share.min(0.45)).map(|p| DQuat::from_rotation_x(PI) * p);
    let mut halves = [base, lid];
    // Bands, corner caps and bumpers are the half's that they sit on.
    for (half_case, side) in halves.iter_mut().zip([-1.0, 1.0]) {
        let trims = rng.random_range(0..5);
        let mut all = std::mem::take(half_case);
        for i in 0..trims {
            let z = half.z * (0.35 * f64::from(i) - 0.7);
            let bar = board(DVec3::new(0.9 * half.x, 0.004, 0.02 * half.z), [detail.of(5.0, 4), 1]);
            all = all.and(bar.shifted(DVec3::new(0.0, side * half.y, z)));
        }
        if rng.random_bool(0.4) {
            for (x, z) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                let cap = board(DVec3::splat(0.9 * soft), [1, 1]);
                let (x, z) = (x * (half.x - 0.7 * soft), z * (half.z - 0.7 * soft));
                all = all.and(cap.shifted(DVec3::new(x, side * (half.y - 0.7 * soft), z)));
            }
        }
        *half_case = all;
    }
    let [base, lid] = halves;
    let mut parts = vec![SynthPart::new("base", base), SynthPart::new("lid", lid)];

    let wide = rng.random_range(0.05..0.09);
    let out = rng.random_range(0.02..0.04);
    let n = detail.of(10.0, 6);
    let path: Vec<DVec3> = (0..=n)
        .map(|i| PI * i as f64 / n as f64)
        .map(|a| DVec3::new(-wide * a.cos(), 0.0, half.z - 0.008 + out * a.sin().powf(0.5)))
        .collect();
    let mut handle = tube(&path, |_| 0.007, detail.of(6.0, 6));
    if rng.random_bool(0.5) {
        let pad = DVec3::new(0.011, 0.014, 0.008);
        for side in [-1.0, 1.0] {
            let end = board(pad, [1, 1]).shifted(DVec3::new(side * wide, 0.0, half.z));
            handle = handle.and(end);
        }
    }
    parts.push(SynthPart::new("handle", handle));
    for (i, side) in [-1.0, 1.0].into_iter().enumerate() {
        let latch = board(DVec3::new(0.016, 0.004, 0.025), [1, 1])
            .map(|p| DQuat::from_rotation_x(FRAC_PI_2) * p)
            .shifted(DVec3::new(side * 0.6 * half.x, joint, half.z + 0.001));
        parts.push(SynthPart::new(format!("latch_{}", i + 1), latch));
    }
    if rng.random_bool(0.7) {
        let corners = [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
        for (i, (sx, sy)) in corners.into_iter().enumerate() {
            let at = DVec3::new(sx * 0.75 * half.x - 0.012, sy * 0.6 * half.y, 0.012 - half.z);
            let wheel = cylinder(0.022, 0.024, 0.003, detail.of(9.0, 8), 1)
                .along(at - DVec3::Z * 0.02, at - DVec3::Z * 0.02 + DVec3::X);
            parts.push(SynthPart::new(format!("wheel_{}", i + 1), wheel));
        }
    }
    parts
}
