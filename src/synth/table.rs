//! A table: a bevelled top on an apron of four boards, on four legs, tapered and square or turned.

use std::f64::consts::FRAC_PI_2;

use glam::{DQuat, DVec2, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::SynthPart;
use super::outline::{RoundedRectangle, squircle};
use super::profile::{LEGS, marks, turned};
use super::solid::{Detail, Rim, Solid, board, lathe, slab};

/// A square leg from the floor to `height`, tapering below the apron, its edges rounded.
fn tapered(half: f64, height: f64, apron: f64, detail: Detail) -> Solid {
    let sheet = |y: f64, half: f64| {
        move |u: f64, v: f64| {
            let p = squircle(u, v, 12.0) * half;
            DVec3::new(p.x, y, -p.y)
        }
    };
    let straight = 1.0 - apron / height;
    let n = detail.of(5.0, 2);
    // The sides run straight between foot and head; `out` fills them up to full width below the
    // apron.
    let rims: Vec<Rim> = (1..n)
        .map(|k| k as f64 / n as f64 * straight)
        .chain([straight])
        .map(|rise| Rim { rise, out: half * 0.42 * (rise / straight - rise) })
        .collect();
    let cells = detail.of(2.0, 2);
    slab([cells, cells], sheet(height, half), sheet(0.0, 0.58 * half), &rims)
}

pub(super) fn parts(rng: &mut ChaCha8Rng, detail: Detail) -> Vec<SynthPart> {
    let half = DVec3::new(rng.random_range(0.55..0.80), 0.0, rng.random_range(0.35..0.45));
    let height = rng.random_range(0.70..0.76);
    let thickness = rng.random_range(0.026..0.036);
    let apron = rng.random_range(0.085..0.11);
    let leg_half = rng.random_range(0.030..0.038);
    let turned_legs = rng.random_bool(0.5);
    let shape = LEGS[rng.random_range(0..LEGS.len())];
    let corner = rng.random_range(0.03..0.09);

    let bevel = 0.008;
    let cells = [detail.of(10.0, 6), detail.of(8.0, 6)];
    let inner = DVec2::new(half.x - bevel, half.z - bevel);
    let outline = RoundedRectangle { half: inner, radius: corner, cells };
    let sheet = |y: f64| {
        move |u: f64, v: f64| {
            let p = outline.at(u, v);
            DVec3::new(p.x, y, -p.y)
        }
    };
    let share = bevel / thickness;
    let rims = [Rim { rise: share, out: bevel }, Rim { rise: 1.0 - share, out: bevel }];
    let top = slab(cells, sheet(height), sheet(height - thickness), &rims);
    let mut parts = vec![SynthPart::new("top", top)];

    let under = height - thickness;
    let (x, z) = (half.x - 0.07, half.z - 0.07);
    for (i, (sx, sz)) in [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)].iter().enumerate() {
        // The head stands a little inside the top, so that no two faces share a plane.
        let length = under + 0.3 * thickness;
        let leg = if turned_legs {
            let profile = turned(&marks(shape, leg_half, length), detail.of(14.0, 3));
            lathe(&profile, detail.of(7.0, 6))
        } else {
            tapered(leg_half, length, apron + 0.03, detail)
        };
        let leg = leg.shifted(DVec3::new(sx * x, 0.0, sz * z));
        parts.push(SynthPart::new(format!("leg_{}", i + 1), leg));
    }

    let middle = under - 0.5 * apron + 0.15 * thickness;
    let tall = 0.5 * apron + 0.15 * thickness;
    let plank = |half_length: f64| {
        let cells = [detail.of(6.0, 3), detail.of(1.0, 1)];
        board(DVec3::new(half_length, 0.011, tall), cells)
            .map(|p| DQuat::from_rotation_x(FRAC_PI_2) * p)
    };
    let quarter = |s: Solid| s.map(|p| DVec3::new(p.z, p.y, -p.x));
    let boards = [
        plank(x).shifted(DVec3::new(0.0, middle, z)),
        quarter(plank(z)).shifted(DVec3::new(x, middle, 0.0)),
        plank(x).shifted(DVec3::new(0.0, middle, -z)),
        quarter(plank(z)).shifted(DVec3::new(-x, middle, 0.0)),
    ];
    for (i, plank) in boards.into_iter().enumerate() {
        parts.push(SynthPart::new(format!("apron_{}", i + 1), plank));
    }
    parts
}
