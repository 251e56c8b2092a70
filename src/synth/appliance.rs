//! Boxes with a door: safes, ovens, microwaves, refrigerators, washing machines. The body is many solids
//! and yet one part, as is the door: walls, liner, back plate; slab, frame, window. On them sit handles,
//! knobs, buttons and hinges. x is the right, z the front.

use std::f64::consts::PI;

use glam::{DQuat, DVec2, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::SynthPart;
use super::outline::RoundedRectangle;
use super::solid::{Detail, Rim, Solid, board, cylinder, hollow, slab, tube};

/// An upright slab of half sizes `x` and `y` whose back stands on z = 0, with round corners.
fn plate(x: f64, y: f64, thick: f64, corner: f64, detail: Detail) -> Solid {
    let cells = [detail.of(5.0, 4), detail.of(5.0, 4)];
    let bevel = 0.2 * thick;
    let half = DVec2::new(x - bevel, y - bevel);
    let outline = RoundedRectangle { half, radius: corner, cells };
    let sheet = |z: f64| {
        move |u: f64, v: f64| {
            let p = outline.at(u, v);
            DVec3::new(p.x, p.y, z)
        }
    };
    let rims = [Rim { rise: 0.3, out: bevel }, Rim { rise: 0.7, out: bevel }];
    slab(cells, sheet(thick), sheet(0.0), &rims)
}

/// A cylinder that points forwards.
fn stud(radius: f64, height: f64, detail: Detail) -> Solid {
    let turn = DQuat::from_rotation_x(0.5 * PI);
    cylinder(radius, height, 0.1 * radius.min(height), detail.of(12.0, 8), 1).map(|p| turn * p)
}

/// Walls about a hollow of half sizes `half`, open in front; each wall is a solid of its own.
fn case(half: DVec3, wall: f64) -> Solid {
    let one = [1, 1];
    let flat = |x: f64, z: f64| board(DVec3::new(x, 0.5 * wall, z), one);
    let upright = |p: DVec3| DVec3::new(-p.y, p.x, p.z);
    let facing = |p: DVec3| DVec3::new(p.x, -p.z, p.y);
    let side =
        |s: f64| flat(half.y, half.z).map(upright).shifted(DVec3::X * s * (half.x - 0.5 * wall));
    let lid = |s: f64| flat(half.x, half.z).shifted(DVec3::Y * s * (half.y - 0.5 * wall));
    let back = flat(half.x, half.y).map(facing).shifted(DVec3::Z * (0.5 * wall - half.z));
    [side(1.0), side(-1.0), lid(1.0), lid(-1.0)].into_iter().fold(back, Solid::and)
}

pub(super) fn parts(rng: &mut ChaCha8Rng, detail: Detail) -> Vec<SynthPart> {
    let half = DVec3::new(
        rng.random_range(0.2..0.4),
        rng.random_range(0.2..0.65),
        rng.random_range(0.18..0.35),
    );
    let wall = rng.random_range(0.015..0.06);
    let solid = rng.random_bool(0.35);
    let one = [detail.of(2.0, 1), detail.of(2.0, 1)];
    let mut body = if solid { board(half, one) } else { case(half, wall) };
    if !solid && rng.random_bool(0.5) {
        let gap = DVec3::splat(1.3 * wall);
        body = body.and(case(half - gap, 0.3 * wall).shifted(DVec3::Z * 0.3 * wall));
    }
    if rng.random_bool(0.4) {
        let vent = board(DVec3::new(0.6 * half.x, 0.02 * half.y, 0.01), [1, 1]);
        let at = |i: i32| DVec3::new(0.0, half.y * (0.1 * f64::from(i) - 0.6), -half.z);
        body = (0..5).fold(body, |body, i| body.and(vent.clone().shifted(at(i))));
    }

    // A strip of controls beside or above the door, or none.
    let strip = rng.random_range(0..3);
    let (mut low, mut high) = (DVec2::new(-half.x, -half.y), DVec2::new(half.x, half.y));
    let taken = rng.random_range(0.2..0.35);
    match strip {
        0 => high.x -= 2.0 * taken * half.x,
        1 => high.y -= 2.0 * taken * half.y,
        _ => {}
    }
    let (own_low, own_high) = match strip {
        0 => (DVec2::new(high.x, low.y), DVec2::new(half.x, half.y)),
        1 => (DVec2::new(low.x, high.y), DVec2::new(half.x, half.y)),
        _ => (DVec2::ZERO, DVec2::ZERO),
    };
    if strip < 2 {
        let size = 0.5 * (own_high - own_low);
        let middle = 0.5 * (own_high + own_low);
        let front = plate(size.x, size.y, 1.2 * wall, 0.1 * size.min_element(), detail);
        body = body.and(front.shifted(middle.extend(half.z - wall)));
    }
    let mut parts = vec![SynthPart::new("body", body)];

    // The door, and what turns with it.
    let inset = rng.random_range(0.0..0.06) * half.x;
    low += inset;
    high -= inset;
    let (size, middle) = (0.5 * (high - low), 0.5 * (high + low));
    let thick = rng.random_range(0.6..1.6) * wall;
    let corner = rng.random_range(0.02..0.25) * size.min_element();
    let mut door = plate(size.x, size.y, thick, corner, detail);
    let mut window = None;
    if rng.random_bool(0.45) {
        let (x, y) = (rng.random_range(0.5..0.75) * size.x, rng.random_range(0.4..0.7) * size.y);
        let bar = 0.12 * x.min(y);
        let rail = |w: f64, h: f64, at: DVec2| {
            plate(w, h, 0.3 * thick, 0.2 * w.min(h), detail).shifted(at.extend(0.9 * thick))
        };
        for s in [-1.0, 1.0] {
            door = door.and(rail(x, 0.5 * bar, DVec2::new(0.0, s * y)));
            door = door.and(rail(0.5 * bar, y - 0.5 * bar, DVec2::new(s * (x - 0.5 * bar), 0.0)));
        }
        let glass = plate(x - bar, y - 0.5 * bar, 0.15 * thick, 0.05 * x.min(y), detail);
        window = Some(glass.shifted(DVec3::Z * 0.95 * thick));
    }
    if rng.random_bool(0.4) {
        let liner = plate(0.85 * size.x, 0.88 * size.y, 0.5 * thick, 0.5 * corner, detail);
        door = door.and(liner.shifted(DVec3::Z * -0.45 * thick));
    }
    let mut swinging = vec![("door".to_owned(), door)];
    swinging.extend(window.map(|glass| ("glass".to_owned(), glass)));
    let reach = rng.random_range(0.7..0.9) * size.x;
    match rng.random_range(0..4) {
        0 => {
            let out = rng.random_range(0.04..0.08);
            let long = rng.random_range(0.3..0.8) * size.y;
            let path: Vec<DVec3> = [(0.0, -1.0), (1.0, -0.95), (1.0, 0.0), (1.0, 0.95), (0.0, 1.0)]
                .map(|(z, y)| DVec3::new(reach, y * long, 0.8 * thick + z * out))
                .to_vec();
            swinging.push(("handle".into(), tube(&path, |_| 0.2 * out, detail.of(8.0, 6))));
        }
        1 => {
            let dial = stud(0.14 * size.x, 0.05, detail).and(stud(0.07 * size.x, 0.09, detail));
            swinging.push(("knob".into(), dial.shifted(DVec3::new(0.3 * reach, 0.0, 0.9 * thick))));
            let arm = |turn: f64| {
                let long = 0.2 * size.x;
                board(DVec3::new(long, 0.012, 0.012), [1, 1])
                    .map(|p| DQuat::from_rotation_z(turn) * p)
            };
            let cross = arm(0.0).and(arm(0.5 * PI)).shifted(DVec3::Z * 0.06);
            let wheel = stud(0.015, 0.07, detail).and(cross);
            let at = DVec3::new(-0.4 * reach, 0.0, 0.9 * thick);
            swinging.push(("handle".into(), wheel.shifted(at)));
        }
        2 => {
            let grip = board(DVec3::new(0.02, 0.25 * size.y, 0.02), [1, 2]);
            swinging.push(("handle".into(), grip.shifted(DVec3::new(reach, 0.0, thick + 0.015))));
        }
        _ => {
            let ring = hollow(0.1 * size.x, 0.06 * size.x, 0.03, detail.of(14.0, 10), 1);
            let turn = DQuat::from_rotation_x(0.5 * PI);
            let ring = ring.map(|p| turn * p).shifted(DVec3::new(reach - 0.1, 0.0, 0.95 * thick));
            swinging.push(("handle".into(), ring));
        }
    }
    let open = if rng.random_bool(0.5) { 0.0 } else { rng.random_range(0.2..1.9) };
    let pin = DVec3::new(-size.x, 0.0, 0.0);
    let turn = DQuat::from_rotation_y(-open);
    // The door's edge stands in the body, so that it hangs on it however far it is open.
    let place = middle.extend(half.z - 0.1 * wall);
    for (name, part) in swinging {
        let part = part.map(|p| turn * (p - pin) + pin).shifted(place);
        parts.push(SynthPart::new(name, part));
    }
    for (i, side) in [-0.7, 0.7].into_iter().enumerate() {
        if inset > 0.0 && rng.random_bool(0.8) {
            let hinge = cylinder(0.4 * wall, 0.2 * size.y, 0.0, detail.of(8.0, 6), 1);
            let at = place + pin + DVec3::new(-0.2 * wall, side * size.y - 0.1 * size.y, 0.0);
            parts.push(SynthPart::new(format!("hinge_{}", i + 1), hinge.shifted(at)));
        }
    }
    if strip < 2 {
        let middle = 0.5 * (own_high + own_low);
        let (span, count) = (own_high - own_low, rng.random_range(2..6));
        let along = if strip == 0 { DVec2::Y * span.y } else { DVec2::X * span.x };
        let radius = 0.28 * span.min_element() * rng.random_range(0.3..0.8);
        for i in 0..count {
            let at = middle + along * ((f64::from(i) + 0.5) / f64::from(count) - 0.5) * 0.8;
            let knob = stud(radius, rng.random_range(0.4..1.4) * radius, detail);
            let knob = knob.shifted(at.extend(half.z + 0.15 * wall));
            parts.push(SynthPart::new(format!("knob_{}", i + 1), knob));
        }
    }
    if rng.random_bool(0.5) {
        for (i, (x, z)) in
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].into_iter().enumerate()
        {
            let foot = cylinder(0.025, 0.04, 0.0, detail.of(10.0, 8), 1);
            let at = DVec3::new(0.85 * x * half.x, -half.y - 0.035, 0.85 * z * half.z);
            parts.push(SynthPart::new(format!("foot_{}", i + 1), foot.shifted(at)));
        }
    }
    if !solid && open > 0.0 {
        for i in 0..rng.random_range(0..3) {
            let shelf = board(
                DVec3::new(half.x - wall, 0.006, half.z - 1.2 * wall),
                [detail.of(3.0, 2), 2],
            );
            let at = DVec3::Y * half.y * (0.5 * f64::from(i) - 0.4);
            parts.push(SynthPart::new(format!("shelf_{}", i + 1), shelf.shifted(at)));
        }
    }
    parts
}
