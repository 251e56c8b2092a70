//! A small appliance: a rounded body on feet, with slots' frames or a door, a lever, buttons and
//! knobs. Feet and slots are mostly the body's, as PartNet has them.

use glam::{DVec2, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::SynthPart;
use super::outline::RoundedRectangle;
use super::solid::{Detail, Rim, board, cylinder, slab};

pub(super) fn parts(rng: &mut ChaCha8Rng, detail: Detail) -> Vec<SynthPart> {
    let half = DVec3::new(
        rng.random_range(0.12..0.2),
        rng.random_range(0.07..0.12),
        rng.random_range(0.07..0.13),
    );
    let soft = rng.random_range(0.012..0.03);
    let feet = rng.random_range(0.010..0.02);
    let cells = [detail.of(9.0, 6), detail.of(7.0, 6)];
    let inner = DVec2::new(half.x - soft, half.z - soft);
    let outline = RoundedRectangle { half: inner, radius: 0.6 * soft, cells };
    let sheet = |y: f64| {
        move |u: f64, v: f64| {
            let p = outline.at(u, v);
            DVec3::new(p.x, y, -p.y)
        }
    };
    let share = soft / (2.0 * half.y);
    let rims = [
        Rim { rise: 0.4 * share, out: 0.7 * soft },
        Rim { rise: 1.5 * share, out: soft },
        Rim { rise: 1.0 - 1.5 * share, out: soft },
        Rim { rise: 1.0 - 0.4 * share, out: 0.7 * soft },
    ];
    let top = feet + 2.0 * half.y;
    let mut body = slab(cells, sheet(top), sheet(feet), &rims);
    let (own_slots, own_feet) = (rng.random_bool(0.25), rng.random_bool(0.25));
    let mut parts = Vec::new();
    let front = half.z;
    if rng.random_bool(0.5) {
        for (i, side) in [-1.0, 1.0].into_iter().enumerate() {
            let slot = board(
                DVec3::new(0.75 * half.x, 0.006, 0.16 * half.z),
                [detail.of(8.0, 4), detail.of(1.0, 1)],
            )
            .shifted(DVec3::new(0.0, top + 0.002, side * 0.38 * half.z));
            if own_slots {
                parts.push(SynthPart::new(format!("slot_{}", i + 1), slot));
            } else {
                body = body.and(slot);
            }
        }
        let lever = board(DVec3::new(0.012, 0.007, 0.025), [1, 2]).shifted(DVec3::new(
            half.x + 0.004,
            feet + 1.3 * half.y,
            0.0,
        ));
        parts.push(SynthPart::new("lever", lever));
    } else {
        let door = board(
            DVec3::new(0.68 * half.x, 0.008, 0.72 * half.y),
            [detail.of(6.0, 3), detail.of(4.0, 2)],
        )
        .map(|p| DVec3::new(p.x, -p.z, p.y))
        .shifted(DVec3::new(-0.22 * half.x, feet + half.y, front + 0.002));
        parts.push(SynthPart::new("door", door));
        let bar = board(DVec3::new(0.5 * half.x, 0.006, 0.012), [detail.of(5.0, 3), 1])
            .shifted(DVec3::new(-0.22 * half.x, feet + 1.55 * half.y, front + 0.014));
        parts.push(SynthPart::new("handle", bar));
    }
    let knobs = rng.random_range(1..=3usize);
    for i in 0..knobs {
        let y = feet + half.y * (0.5 + 0.5 * i as f64);
        let at = DVec3::new(0.72 * half.x, y, front - 0.006);
        let knob =
            cylinder(0.14 * half.x, 0.026, 0.003, detail.of(9.0, 7), 1).along(at, at + DVec3::Z);
        parts.push(SynthPart::new(format!("knob_{}", i + 1), knob));
    }
    let buttons = rng.random_range(0..=4usize);
    for i in 0..buttons {
        let x = half.x * (0.35 - 0.18 * i as f64);
        let at = DVec3::new(x, feet + 0.22 * half.y, front + 0.001);
        let button = board(DVec3::new(0.06 * half.x, 0.06 * half.y, 0.004), [1, 1]).shifted(at);
        parts.push(SynthPart::new(format!("button_{}", i + 1), button));
    }
    // Plates and trims that are the body's: a base tray, a band, a name plate.
    if rng.random_bool(0.5) {
        let tray = board(DVec3::new(0.93 * half.x, 0.006, 0.9 * half.z), [detail.of(6.0, 4), 3]);
        body = body.and(tray.shifted(DVec3::Y * (feet + 0.001)));
    }
    for _ in 0..rng.random_range(0..4) {
        let size = DVec3::new(
            half.x * rng.random_range(0.05..0.3),
            half.y * rng.random_range(0.03..0.1),
            0.003,
        );
        let side = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
        let at = DVec3::new(
            half.x * rng.random_range(-0.5..0.5),
            feet + half.y * rng.random_range(0.3..1.7),
            side * front,
        );
        body = body.and(board(size, [detail.of(2.0, 1), 1]).shifted(at));
    }
    let corners = [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
    for (i, (sx, sz)) in corners.into_iter().enumerate() {
        let at = DVec3::new(sx * 0.72 * half.x, 0.0, sz * 0.68 * half.z);
        let foot = cylinder(0.012, feet + 0.006, 0.0, detail.of(6.0, 6), 1).shifted(at);
        if own_feet {
            parts.push(SynthPart::new(format!("foot_{}", i + 1), foot));
        } else {
            body = body.and(foot);
        }
    }
    parts.insert(0, SynthPart::new("body", body));
    parts
}
