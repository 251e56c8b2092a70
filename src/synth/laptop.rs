//! An open laptop: base, lid, display, two hinges, a keyboard with its keys, a touchpad. x is its
//! right, z its front.

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

pub(super) fn parts(rng: &mut ChaCha8Rng, detail: Detail) -> Vec<SynthPart> {
    let x = rng.random_range(0.15..0.18);
    let z = rng.random_range(0.105..0.125);
    let base_height = rng.random_range(0.015..0.019);
    let lid_height = rng.random_range(0.007..0.009);
    let opening = rng.random_range(100.0..125.0_f64).to_radians();
    let (rows, columns) = (3, rng.random_range(6..=8));
    let corner = rng.random_range(0.008..0.016);

    let cells = [detail.of(6.0, 5), detail.of(5.0, 4)];
    let base = plate(x, z, base_height, corner, cells);
    let mut parts = vec![SynthPart::new("base", base)];

    // The lid turns about the hinge line behind the base.
    let hinge = DVec3::new(0.0, base_height, -z - 0.002);
    let open = move |s: Solid| {
        let turn = DQuat::from_rotation_x(-opening);
        s.shifted(-hinge).map(|p| turn * p).shifted(hinge)
    };
    let closed_y = base_height + 0.004;
    let lid = plate(x, z, lid_height, corner, cells).shifted(DVec3::new(0.0, closed_y, 0.0));
    parts.push(SynthPart::new("lid", open(lid)));
    let display = board(DVec3::new(0.90 * x, 0.0010, 0.84 * z), cells).shifted(DVec3::new(
        0.0,
        closed_y,
        0.02 * z,
    ));
    parts.push(SynthPart::new("display", open(display)));

    for (i, side) in [-1.0, 1.0].into_iter().enumerate() {
        let width = 0.26 * x;
        let barrel = cylinder(0.0058, width, 0.0010, detail.of(8.0, 6), detail.of(1.5, 1))
            .shifted(DVec3::new(0.0, -0.5 * width, 0.0))
            .map(|p| DQuat::from_rotation_z(FRAC_PI_2) * p)
            .shifted(hinge + DVec3::new(side * 0.60 * x, 0.0005, 0.0));
        parts.push(SynthPart::new(format!("hinge_{}", i + 1), barrel));
    }

    let (deck_x, deck_z) = (0.86 * x, 0.46 * z);
    let deck_at = DVec3::new(0.0, base_height, -0.36 * z);
    let deck = board(DVec3::new(deck_x, 0.0012, deck_z), [detail.of(7.0, 5), detail.of(3.0, 2)]);
    parts.push(SynthPart::new("keyboard", deck.shifted(deck_at)));
    let pitch = (2.0 * deck_x / columns as f64, 2.0 * deck_z / rows as f64);
    for row in 0..rows {
        for column in 0..columns {
            let half = DVec3::new(0.43 * pitch.0, 0.0016, 0.43 * pitch.1);
            let n = detail.of(0.7, 1);
            // Caps are smaller at the top than at the foot.
            let cap = slab(
                [n, n],
                |u, v| DVec3::new(0.86 * u * half.x, half.y, -0.86 * v * half.z),
                |u, v| DVec3::new(u * half.x, -half.y, -v * half.z),
                &[],
            );
            let at = DVec3::new(
                (column as f64 + 0.5) * pitch.0 - deck_x,
                0.0016,
                (row as f64 + 0.5) * pitch.1 - deck_z,
            );
            let number = row * columns + column + 1;
            parts.push(SynthPart::new(format!("key_{number}"), cap.shifted(deck_at + at)));
        }
    }

    let pad = board(DVec3::new(0.30 * x, 0.0010, 0.24 * z), [detail.of(3.0, 3), detail.of(2.0, 2)]);
    parts.push(SynthPart::new("touchpad", pad.shifted(DVec3::new(0.0, base_height, 0.56 * z))));
    parts
}
