//! A bed: a frame on legs, a soft mattress, pillows, a headboard and sometimes a footboard.

use glam::{DVec2, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::SynthPart;
use super::outline::RoundedRectangle;
use super::profile::{LEGS, marks, turned};
use super::solid::{Detail, Rim, Solid, board, lathe, slab};

/// A cushion of these half sizes, its middle raised by `puff`.
fn cushion(half: DVec3, round: f64, puff: f64, detail: Detail) -> Solid {
    let ratio = (half.x / half.z).sqrt();
    let cells = [detail.of(7.0 * ratio, 6), detail.of(7.0 / ratio, 6)];
    let soft = 0.45 * half.y;
    let outline =
        RoundedRectangle { half: DVec2::new(half.x - soft, half.z - soft), radius: round, cells };
    let sheet = |side: f64| {
        move |u: f64, v: f64| {
            let p = outline.at(u, v);
            let swell = puff * (1.0 - u * u) * (1.0 - v * v);
            DVec3::new(p.x, side * (half.y + swell), -p.y)
        }
    };
    let rims = [Rim { rise: 0.2, out: soft }, Rim { rise: 0.8, out: soft }];
    slab(cells, sheet(1.0), sheet(-1.0), &rims)
}

pub(super) fn parts(rng: &mut ChaCha8Rng, detail: Detail) -> Vec<SynthPart> {
    let half = DVec2::new(rng.random_range(0.45..0.95), rng.random_range(0.98..1.06));
    let leg = rng.random_range(0.12..0.3);
    let frame = rng.random_range(0.05..0.1);
    let mattress = rng.random_range(0.08..0.13);
    let head = rng.random_range(0.35..0.8);
    let radius = rng.random_range(0.03..0.045);

    let base = board(DVec3::new(half.x, frame, half.y), [detail.of(5.0, 2), detail.of(7.0, 2)])
        .shifted(DVec3::Y * (leg + frame));
    let mut parts = vec![SynthPart::new("frame", base)];
    let middle = leg + 2.0 * frame + 0.85 * mattress;
    let soft = cushion(DVec3::new(half.x - 0.04, mattress, half.y - 0.05), 0.08, 0.02, detail);
    parts.push(SynthPart::new("mattress", soft.shifted(DVec3::Y * middle)));
    let count = 1 + usize::from(half.x > 0.65);
    for i in 0..count {
        let wide = (half.x - 0.06) / count as f64;
        let x = (2.0 * i as f64 + 1.0 - count as f64) * wide;
        let pillow = cushion(DVec3::new(0.85 * wide, 0.045, 0.2), 0.07, 0.03, detail);
        let at = DVec3::new(x, middle + mattress + 0.04, 0.3 - half.y);
        parts.push(SynthPart::new(format!("pillow_{}", i + 1), pillow.shifted(at)));
    }
    let arch = rng.random_range(0.0..0.2);
    let panel = |top: f64| {
        let sheet = move |side: f64| {
            move |u: f64, v: f64| {
                let y = leg + (0.5 * v + 0.5) * (top - leg) * (1.0 + arch * (1.0 - u * u));
                DVec3::new(u * (half.x + 0.02), y, side * 0.022)
            }
        };
        let cells = [detail.of(8.0, 4), detail.of(4.0, 2)];
        slab(cells, sheet(1.0), sheet(-1.0), &[Rim { rise: 0.5, out: 0.006 }])
    };
    let back = panel(middle + head).shifted(DVec3::Z * -(half.y + 0.015));
    parts.push(SynthPart::new("headboard", back));
    if rng.random_bool(0.4) {
        let front = panel(middle + 0.3 * head).shifted(DVec3::Z * (half.y + 0.015));
        parts.push(SynthPart::new("footboard", front));
    }
    let shape = LEGS[rng.random_range(0..LEGS.len())];
    let corners = [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
    for (i, (sx, sz)) in corners.into_iter().enumerate() {
        let profile = turned(&marks(shape, radius, leg + 0.5 * frame), detail.of(12.0, 3));
        let at = DVec3::new(sx * (half.x - 0.07), 0.0, sz * (half.y - 0.07));
        let turned = lathe(&profile, detail.of(7.0, 6)).shifted(at);
        parts.push(SynthPart::new(format!("leg_{}", i + 1), turned));
    }
    parts
}
