//! An airplane along z: a fuselage, two wings, a tail of three planes, engines under the wings or none.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::SynthPart;
use super::solid::{Cap, Detail, Solid, skin};

/// A wing from the root to the tip, a lens in section. Chords run along z.
fn wing(root: DVec3, tip: DVec3, chords: [f64; 2], thick: f64, detail: Detail) -> Solid {
    let stations = detail.of(6.0, 3);
    let around = detail.of(4.0, 3);
    let across = (tip - root).cross(DVec3::Z).normalize_or(DVec3::Y);
    let ring = |i: usize| -> Vec<DVec3> {
        let t = i as f64 / stations as f64;
        let (centre, chord) = (root.lerp(tip, t), chords[0] * (1.0 - t) + chords[1] * t);
        (0..2 * around)
            .map(|j| {
                let angle = PI * j as f64 / around as f64;
                let (sin, cos) = angle.sin_cos();
                centre + DVec3::Z * (0.5 * chord * cos) + across * (0.5 * thick * chord * sin)
            })
            .collect()
    };
    skin(&(0..=stations).map(ring).collect::<Vec<_>>(), Cap::Ladder)
}

/// A body along z: (z, height of the middle, half height, half width).
fn body(sections: &[[f64; 4]], sides: usize) -> Solid {
    let ring = |&[z, y, tall, wide]: &[f64; 4]| {
        let point = |j: usize| {
            let (sin, cos) = (TAU * j as f64 / sides as f64).sin_cos();
            DVec3::new(wide * cos, y + tall * sin, z)
        };
        (0..sides).map(point).collect()
    };
    skin(&sections.iter().map(ring).collect::<Vec<_>>(), Cap::Fan)
}

pub(super) fn parts(rng: &mut ChaCha8Rng, detail: Detail) -> Vec<SynthPart> {
    let radius = rng.random_range(0.05..0.08);
    let nose = rng.random_range(0.12..0.3);
    let tail = rng.random_range(0.25..0.45);
    let span = rng.random_range(0.35..0.6);
    let sweep = rng.random_range(-0.05..0.35) * span;
    let chord = rng.random_range(0.16..0.26);
    let rise = rng.random_range(-0.02..0.12) * span;
    let high = rng.random_range(-0.6..0.6) * radius;
    let n = detail.of(16.0, 8);
    let sections: Vec<[f64; 4]> = (0..=n)
        .map(|i| {
            let t = i as f64 / n as f64;
            let front = ((1.0 - t) / nose).min(1.0);
            let back = (t / tail).min(1.0);
            let size = radius
                * (0.15 + 0.85 * (1.0 - (1.0 - front).powi(2)).sqrt())
                * (0.2 + 0.8 * (1.0 - (1.0 - back).powi(2)));
            // The tail's upper side runs level.
            [t - 0.5, 0.6 * radius * (1.0 - back), size, size]
        })
        .collect();
    let mut parts = vec![SynthPart::new("fuselage", body(&sections, detail.of(14.0, 8)))];
    let thick = rng.random_range(0.10..0.16);
    let taper = rng.random_range(0.3..0.8);
    let jets = rng.random_range(0..=2usize);
    let along = rng.random_range(-0.02..0.1);
    for (i, side) in [-1.0, 1.0].into_iter().enumerate() {
        let root = DVec3::new(side * 0.5 * radius, high, along);
        let tip = DVec3::new(side * span, high + rise, along - sweep);
        let plane = wing(root, tip, [chord, taper * chord], thick, detail);
        parts.push(SynthPart::new(format!("wing_{}", i + 1), plane));
        for k in 0..jets {
            let t = (k + 1) as f64 / (jets + 1) as f64;
            let at = root.lerp(tip, t) - DVec3::Y * (0.3 * radius);
            let (r, l) = (0.42 * radius, 0.55 * chord);
            let shape = [[-0.6, 0.55], [-0.3, 0.9], [0.2, 1.0], [0.5, 0.8]];
            let engine: Vec<[f64; 4]> =
                shape.iter().map(|&[z, s]| [at.z + z * l, at.y, s * r, s * r]).collect();
            let engine = body(&engine, detail.of(9.0, 7)).shifted(DVec3::X * at.x);
            parts.push(SynthPart::new(format!("engine_{}", i * jets + k + 1), engine));
        }
    }
    let (z, y) = (-0.42, 0.55 * radius);
    let small = rng.random_range(0.3..0.45) * span;
    let top = rng.random_range(0.12..0.22);
    let high_tail = rng.random_bool(0.25);
    let level = if high_tail { y + 0.85 * top } else { y };
    for (i, side) in [-1.0, 1.0].into_iter().enumerate() {
        let root = DVec3::new(side * 0.004, level, z - if high_tail { 0.05 } else { 0.0 });
        let tip = DVec3::new(side * small, level + 0.1 * rise, root.z - 0.3 * sweep.max(0.02));
        let plane = wing(root, tip, [0.11, 0.06], thick, detail);
        parts.push(SynthPart::new(format!("stabilizer_{}", i + 1), plane));
    }
    let fin = wing(
        DVec3::new(0.0, y, z),
        DVec3::new(0.0, y + top, z - 0.06),
        [0.14, 0.07],
        thick,
        detail,
    );
    parts.push(SynthPart::new("fin", fin));
    parts
}
