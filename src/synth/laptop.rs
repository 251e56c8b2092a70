//! An open laptop after PartNet's taxonomy: base frame, keyboard, touchpad and its buttons; screen and
//! screen frame, camera; the shaft between. A keyboard is one part, whatever number of keys it has. x is
//! its right, z its front.

use std::f64::consts::FRAC_PI_2;

use glam::{DQuat, DVec2, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::SynthPart;
use super::outline::RoundedRectangle;
use super::solid::{Detail, Rim, Solid, board, cylinder, slab};

/// A plate on y = 0 with round corners and a softened rim, of half sizes `x` and `z`.
fn plate(x: f64, z: f64, thickness: f64, corner: f64, cells: [usize; 2]) -> Solid {
    let bevel = 0.3 * thickness;
    let half = DVec2::new(x - bevel, z - bevel);
    let outline = RoundedRectangle { half, radius: corner, cells };
    let sheet = |y: f64| {
        move |u: f64, v: f64| {
            let p = outline.at(u, v);
            DVec3::new(p.x, y, -p.y)
        }
    };
    let rims = [Rim { rise: 0.3, out: bevel }, Rim { rise: 0.7, out: bevel }];
    slab(cells, sheet(thickness), sheet(0.0), &rims)
}

/// Rows of keys whose feet stand `sunk` below y = 0, on a field of half size `field`. Caps are smaller
/// at the top than at the foot; the lowest row has a space bar.
fn keys(rng: &mut ChaCha8Rng, field: DVec2, [rows, columns]: [usize; 2], sunk: f64) -> Solid {
    let pitch = 2.0 * field / DVec2::new(columns as f64, rows as f64);
    let gap = rng.random_range(0.80..0.95);
    let top = rng.random_range(0.75..1.0);
    let rise = rng.random_range(0.0006..0.0030);
    let key = |left: f64, columns: f64, row: usize| {
        let half = 0.5 * gap * DVec2::new(pitch.x * columns, pitch.y);
        let cap = slab(
            [1, 1],
            |u, v| DVec3::new(top * u * half.x, rise, -top * v * half.y),
            |u, v| DVec3::new(u * half.x, -sunk, -v * half.y),
            &[],
        );
        let x = (left + 0.5 * columns) * pitch.x - field.x;
        cap.shifted(DVec3::new(x, 0.0, (row as f64 + 0.5) * pitch.y - field.y))
    };
    let bar = (columns / 3, columns / 2);
    let mut all = Solid::default();
    for row in 0..rows {
        let mut column = 0;
        while column < columns {
            let wide = if row + 1 == rows && column == bar.0 { bar.1 } else { 1 };
            all = all.and(key(column as f64, wide as f64, row));
            column += wide;
        }
    }
    all
}

/// What belongs to the base and is a solid of its own: feet, ports at the sides, a plate under the
/// hands, grilles beside the keys.
fn fittings(rng: &mut ChaCha8Rng, base: DVec3) -> Solid {
    let mut all = Solid::default();
    if rng.random_bool(0.5) {
        for (x, z) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let foot = cylinder(0.007, 0.004, 0.0, 8, 1);
            all = all.and(foot.shifted(DVec3::new(0.85 * x * base.x, -0.002, 0.82 * z * base.z)));
        }
    }
    if rng.random_bool(0.5) {
        let port = board(DVec3::new(0.001, 0.25 * base.y, 0.008), [1, 1]);
        for i in 0..rng.random_range(2..7) {
            let (side, row) = (f64::from(i % 2) * 2.0 - 1.0, f64::from(i / 2));
            let at = DVec3::new(side * base.x, 0.5 * base.y, (0.3 * row - 0.5) * base.z);
            all = all.and(port.clone().shifted(at));
        }
    }
    if rng.random_bool(0.4) {
        let slit = board(DVec3::new(0.03 * base.x, 0.0006, 0.004 * base.z), [1, 1]);
        for i in 0..rng.random_range(4..12) {
            let (side, row) = (f64::from(i % 2) * 2.0 - 1.0, f64::from(i / 2));
            let at = DVec3::new(side * 0.93 * base.x, base.y, (0.06 * row - 0.7) * base.z);
            all = all.and(slit.clone().shifted(at));
        }
    }
    all
}

pub(super) fn parts(rng: &mut ChaCha8Rng, detail: Detail) -> Vec<SynthPart> {
    let x = rng.random_range(0.14..0.20);
    let z = x * rng.random_range(0.60..0.78);
    let thick = rng.random_range(0.010..0.024);
    let lid_thick = rng.random_range(0.005..0.011);
    let corner = rng.random_range(0.004..0.016);
    let opening = rng.random_range(85.0..140.0_f64).to_radians();
    let cells = [detail.of(6.0, 5), detail.of(5.0, 4)];

    let base = plate(x, z, thick, corner, cells).and(fittings(rng, DVec3::new(x, thick, z)));
    let mut parts = vec![SynthPart::new("base_frame", base)];

    let (rows, mut columns) = (rng.random_range(4..=6), rng.random_range(9..=14));
    let field = DVec2::new(x * rng.random_range(0.74..0.95), z * rng.random_range(0.34..0.50));
    let back = field.y - z * rng.random_range(0.72..0.88);
    let at = DVec3::new(0.0, thick, back);
    let mut keyboard = Solid::default();
    // Keys stand on a deck of their own, or in the base.
    let deck = rng.random_range(0.0003..0.0015);
    let has_deck = rng.random_bool(0.35);
    if has_deck {
        let half = DVec3::new(1.02 * field.x, deck, 1.03 * field.y);
        keyboard = board(half, [detail.of(7.0, 5), detail.of(3.0, 2)]);
    }
    let lift = if has_deck { deck } else { 0.0 };
    let pad_x = rng.random_range(-0.2..0.05) * x;
    if rng.random_bool(0.25) {
        // A field of numbers at the right.
        columns -= 3;
        let number = DVec2::new(0.2 * field.x, field.y);
        let main = DVec2::new(0.77 * field.x, field.y);
        let right = keys(rng, number, [rows, 4], 0.001).shifted(DVec3::X * (field.x - number.x));
        let left = keys(rng, main, [rows, columns], 0.001).shifted(DVec3::X * (main.x - field.x));
        keyboard = keyboard.and(left.and(right).shifted(DVec3::Y * lift));
    } else {
        let all = keys(rng, field, [rows, columns], 0.001);
        keyboard = keyboard.and(all.shifted(DVec3::Y * lift));
    }
    parts.push(SynthPart::new("keyboard", keyboard.shifted(at)));

    // The touchpad and its buttons share what is left in front of the keys.
    let room = z - (back + field.y);
    let low = back + field.y;
    let pad = DVec2::new(x * rng.random_range(0.2..0.36), room * rng.random_range(0.26..0.38));
    let tall = rng.random_range(0.0004..0.0012);
    let buttons = rng.random_range(0..=2usize);
    let middle = low + room * if buttons > 0 { 0.42 } else { 0.5 };
    let surface = board(DVec3::new(pad.x, tall, pad.y), [detail.of(3.0, 3), detail.of(2.0, 2)]);
    parts.push(SynthPart::new("touchpad", surface.shifted(DVec3::new(pad_x, thick, middle))));
    let depth = 0.1 * room;
    let half = DVec3::new(0.96 * pad.x / buttons.max(1) as f64, 1.2 * tall, 0.8 * depth);
    for i in 0..buttons {
        let left = pad_x - pad.x + pad.x * (2 * i + 1) as f64 / buttons as f64;
        let button = board(half, [detail.of(2.0, 1), 1]).shifted(DVec3::new(
            left,
            thick,
            middle + pad.y + depth,
        ));
        parts.push(SynthPart::new(format!("button_{}", i + 1), button));
    }

    // The lid turns about the hinge line behind the base.
    let hinge = DVec3::new(0.0, thick, -z - 0.002);
    let closed = thick + 0.004;
    let open = move |s: Solid| {
        let turn = DQuat::from_rotation_x(-opening);
        s.shifted(-hinge).map(|p| turn * p).shifted(hinge)
    };
    let margin = DVec2::new(rng.random_range(0.84..0.97), rng.random_range(0.78..0.92));
    let screen = board(DVec3::new(margin.x * x, 0.0008, margin.y * z), cells).shifted(DVec3::new(
        0.0,
        closed,
        (1.0 - margin.y) * z * rng.random_range(-0.6..0.8),
    ));
    parts.push(SynthPart::new("screen", open(screen)));
    let mut lid = plate(x, z, lid_thick, corner, cells);
    if rng.random_bool(0.4) {
        // A cover of its own at the back, or rubber stops in front.
        let n = [detail.of(5.0, 4), detail.of(4.0, 4)];
        let cover = plate(0.99 * x, 0.98 * z, 0.3 * lid_thick, corner, n);
        lid = lid.and(cover.shifted(DVec3::Y * 0.8 * lid_thick));
    }
    if rng.random_bool(0.3) {
        let stop = cylinder(0.003, 0.002, 0.0, 8, 1);
        for side in [-0.9, -0.4, 0.4, 0.9] {
            lid = lid.and(stop.clone().shifted(DVec3::new(side * x, -0.001, 0.95 * z)));
        }
    }
    parts.push(SynthPart::new("screen_frame", open(lid.shifted(DVec3::Y * closed))));
    if rng.random_bool(0.45) {
        let rim = 0.5 * (1.0 - margin.y) * z;
        let lens = cylinder((0.6 * rim).min(0.004), 0.0016, 0.0, detail.of(10.0, 8), 1);
        let lens = lens.shifted(DVec3::new(0.0, closed - 0.0010, z - 0.6 * rim));
        parts.push(SynthPart::new("camera", open(lens)));
    }

    let barrels: &[(f64, f64)] = match rng.random_range(0..4) {
        0 => &[],
        1 => &[(0.0, 0.8)],
        _ => &[(-0.62, 0.14), (0.62, 0.14)],
    };
    for (i, &(side, half)) in barrels.iter().enumerate() {
        let width = 2.0 * half * x;
        let radius = 0.0035 + 0.25 * lid_thick;
        let barrel = cylinder(radius, width, 0.0008, detail.of(8.0, 6), detail.of(1.5, 1))
            .shifted(DVec3::new(0.0, -0.5 * width, 0.0))
            .map(|p| DQuat::from_rotation_z(FRAC_PI_2) * p)
            .shifted(hinge + DVec3::new(side * x, 0.0005, 0.0));
        parts.push(SynthPart::new(format!("shaft_{}", i + 1), barrel));
    }
    parts
}
