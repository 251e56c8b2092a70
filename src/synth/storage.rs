//! A cabinet or shelf: sides, boards and a back; drawers or doors with handles, or open; legs.

use glam::DVec3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::SynthPart;
use super::solid::{Detail, Solid, board, cylinder};

/// A board of these half sizes about a centre, with cells about as long as wide.
fn plank(centre: DVec3, half: DVec3, detail: Detail) -> Solid {
    let side = 2.2 * (half.x * half.y * half.z).cbrt();
    let cells = [half.x, half.z].map(|h| detail.of((2.0 * h / side).clamp(1.0, 6.0), 1));
    board(half, cells).shifted(centre)
}

pub(super) fn parts(rng: &mut ChaCha8Rng, detail: Detail) -> Vec<SynthPart> {
    let half = DVec3::new(
        rng.random_range(0.2..0.6),
        rng.random_range(0.3..0.8),
        rng.random_range(0.16..0.28),
    );
    let t = rng.random_range(0.009..0.014);
    let legs = rng.random_bool(0.5);
    let rows = rng.random_range(2..=5usize);
    let columns = 1 + usize::from(half.x > 0.4);
    let closed = rng.random_range(0..3);

    let lift = if legs { rng.random_range(0.06..0.16) } else { 0.0 };
    let up = |y: f64| lift + half.y + y;
    let mut parts = Vec::new();
    let mut add = |name: String, centre: DVec3, size: DVec3| {
        parts.push(SynthPart::new(name, plank(centre, size, detail)));
    };
    // Boards reach into one another by half their thickness: no two faces share a plane.
    for (i, side) in [-1.0, 1.0].into_iter().enumerate() {
        let at = DVec3::new(side * (half.x - t), up(0.0), 0.0);
        add(format!("side_{}", i + 1), at, DVec3::new(t, half.y - t, half.z));
    }
    let lid = DVec3::new(half.x + 0.4 * t, t, half.z + 0.4 * t);
    add("top".into(), DVec3::new(0.0, up(half.y - t), 0.0), lid);
    add("bottom".into(), DVec3::new(0.0, up(t - half.y), 0.0), lid);
    let behind = DVec3::new(0.0, up(0.0), 0.6 * t - half.z);
    add("back".into(), behind, DVec3::new(half.x - 0.8 * t, half.y - 0.8 * t, 0.4 * t));
    let inner = half.y - 2.0 * t;
    let row = 2.0 * inner / rows as f64;
    let width = 2.0 * (half.x - 2.0 * t) / columns as f64;
    if columns == 2 {
        let size = DVec3::new(t, half.y - 0.7 * t, half.z - 0.7 * t);
        add("divider".into(), DVec3::new(0.0, up(0.0), 0.3 * t), size);
    }
    for i in 1..rows {
        let at = DVec3::new(0.0, up(row * i as f64 - inner), 0.1 * t);
        add(format!("shelf_{i}"), at, DVec3::new(half.x - 1.3 * t, 0.7 * t, half.z - 0.9 * t));
    }
    let mut knobs = Vec::new();
    if closed > 0 {
        let doors = closed == 2;
        let fronts = if doors { 1 } else { rows };
        let tall = 2.0 * inner / fronts as f64;
        for c in 0..columns {
            for r in 0..fronts {
                let x = width * (c as f64 + 0.5) - (half.x - 2.0 * t);
                let at = DVec3::new(x, up(tall * (r as f64 + 0.5) - inner), half.z - 0.2 * t);
                let size = DVec3::new(0.5 * width - 0.3 * t, 0.5 * tall - 0.3 * t, 0.9 * t);
                let name = if doors { "door" } else { "drawer" };
                add(format!("{name}_{}", c * fronts + r + 1), at, size);
                let aside = if doors { 0.36 * width * (1.0 - 2.0 * c as f64) } else { 0.0 };
                knobs.push(at + DVec3::new(aside, 0.0, 0.5 * t));
            }
        }
    }
    let bar = rng.random_bool(0.5);
    for (i, at) in knobs.into_iter().enumerate() {
        let handle = if bar {
            board(DVec3::new(0.06, 0.008, 0.014), [detail.of(4.0, 2), 1])
        } else {
            cylinder(0.014, 0.034, 0.003, detail.of(8.0, 6), 1).along(DVec3::ZERO, DVec3::Z)
        };
        parts.push(SynthPart::new(format!("handle_{}", i + 1), handle.shifted(at)));
    }
    if legs {
        let radius = rng.random_range(0.012..0.022);
        let corners = [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
        for (i, (sx, sz)) in corners.into_iter().enumerate() {
            let at = DVec3::new(sx * (half.x - 3.0 * radius), 0.0, sz * (half.z - 3.0 * radius));
            let leg = cylinder(radius, lift + t, 0.0, detail.of(8.0, 6), detail.of(3.0, 1));
            parts.push(SynthPart::new(format!("leg_{}", i + 1), leg.shifted(at)));
        }
    }
    parts
}
