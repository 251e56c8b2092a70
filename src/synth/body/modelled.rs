//! Bodies as people model them: loops of quads along what each is made of, parted into triangles, as fine
//! as wanted. Tubes along curves, sheets, turned and toothed things, things of several pieces. About a metre
//! each, y up; proportions are drawn by eye.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::Body;
use crate::synth::solid::{Cap, Solid, cylinder, hoop, lathe, skin, tube};

/// Halvings of the interval in which the edge length lies.
const HALVINGS: usize = 40;

/// A body of edges of a length.
pub(super) type Maker = fn(f64) -> Solid;

/// The body with the shortest edges that give no more triangles than wanted.
pub(super) fn with_triangles(make: Maker, wanted: usize) -> Body {
    // Edge lengths known to give few enough and too many.
    let (mut long, mut short) = (0.2_f64, 1e-4_f64);
    let mut best = make(long);
    for _ in 0..HALVINGS {
        let edge = (long * short).sqrt();
        // What is far too fine is not made only to be counted.
        if 0.05 / (edge * edge) > wanted as f64 {
            short = edge;
            continue;
        }
        let solid = make(edge);
        if solid.triangles.len() <= wanted {
            (long, best) = (edge, solid);
        } else {
            short = edge;
        }
    }
    Body { positions: best.positions, triangles: best.triangles }
}

/// Edges along a length, at least `least`.
fn edges(length: f64, edge: f64, least: usize) -> usize {
    ((length / edge).round() as usize).max(least)
}

/// Points of a curve over 0 to 1.
fn curve(count: usize, at: impl Fn(f64) -> DVec3) -> Vec<DVec3> {
    (0..=count).map(|i| at(i as f64 / count as f64)).collect()
}

/// Six turns of a wire with flat ends.
pub(super) fn spring(edge: f64) -> Solid {
    let (turns, ring, wire, pitch) = (6.0, 0.3, 0.04, 0.15);
    let length = turns * f64::hypot(TAU * ring, pitch);
    let path = curve(edges(length, edge, 48), |t| {
        let (sin, cos) = (TAU * turns * t).sin_cos();
        DVec3::new(ring * cos, wire + pitch * turns * t, -ring * sin)
    });
    tube(&path, |_| wire, edges(TAU * wire, edge, 6))
}

/// A tube along a winding curve, open at both ends.
pub(super) fn hose(edge: f64) -> Solid {
    let radius = 0.035;
    let path = curve(edges(2.6, edge, 24), |t| {
        let s = 2.0 * t - 1.0;
        DVec3::new(0.55 * s, 0.3 + 0.22 * (TAU * 1.1 * t).sin(), 0.2 * (TAU * 0.8 * t).cos())
    });
    let sides = edges(TAU * radius, edge, 6);
    let mut hose = tube(&path, |_| radius, sides);
    // The caps come last: a fan about a point at each end.
    hose.triangles.truncate(hose.triangles.len() - 2 * sides);
    hose.positions.truncate(hose.positions.len() - 2);
    hose
}

/// A ring of a wheel without its tyre: a closed tube.
pub(super) fn rim(edge: f64) -> Solid {
    ring(0.45, 0.03, edge).map(|p| p + DVec3::Y * 0.48)
}

fn ring(radius: f64, thickness: f64, edge: f64) -> Solid {
    let count = edges(TAU * radius, edge, 24);
    let mut path = curve(count, |t| {
        let (sin, cos) = (TAU * t).sin_cos();
        radius * DVec3::new(cos, sin, 0.0)
    });
    path.pop();
    hoop(&path, DVec3::Z, thickness, edges(TAU * thickness, edge, 6))
}

/// An open sheet over the unit square.
fn sheet(columns: usize, rows: usize, at: impl Fn(f64, f64) -> DVec3) -> Solid {
    let mut solid = Solid::default();
    for j in 0..=rows {
        for i in 0..=columns {
            solid.vertex(at(i as f64 / columns as f64, j as f64 / rows as f64));
        }
    }
    let id = |i: usize, j: usize| (j * (columns + 1) + i) as u32;
    for j in 0..rows {
        for i in 0..columns {
            solid.quad([id(i, j), id(i, j + 1), id(i + 1, j + 1), id(i + 1, j)]);
        }
    }
    solid
}

/// A wavy strip.
pub(super) fn cloth(edge: f64) -> Solid {
    sheet(edges(1.1, edge, 12), edges(0.5, edge, 4), |u, v| {
        let wave = 0.05 * (TAU * 2.0 * u).sin() + 0.02 * (TAU * (u + 0.7 * v)).cos();
        DVec3::new(u - 0.5, 0.1 + wave, 0.5 * (v - 0.5) + 0.03 * (TAU * u).sin())
    })
}

/// Hills over a square.
pub(super) fn terrain(edge: f64) -> Solid {
    let count = edges(1.1, edge, 16);
    sheet(count, count, |u, v| {
        let mut height = 0.0;
        for octave in 0..4 {
            let (k, size) = (f64::from(1 << octave), 0.06 / f64::from(1 << octave));
            let turn = 0.9 * f64::from(octave);
            let (x, z) = (u * turn.cos() - v * turn.sin(), u * turn.sin() + v * turn.cos());
            height += size * (TAU * k * x + turn).sin() * (TAU * 0.8 * k * z).cos();
        }
        DVec3::new(u - 0.5, height, v - 0.5)
    })
}

/// A shaft with a thread and a hexagonal head.
pub(super) fn bolt(edge: f64) -> Solid {
    let (shaft, head, thread, pitch) = (0.12, 0.24, 0.012, 0.06);
    // Corners of the head are corners of the mesh.
    let sides = 6 * edges(TAU * shaft / 6.0, edge, 2);
    let ring = |y: f64, radius: &dyn Fn(f64) -> f64| -> Vec<DVec3> {
        let point = |j: usize| {
            let angle = TAU * j as f64 / sides as f64;
            let (sin, cos) = angle.sin_cos();
            DVec3::new(radius(angle) * cos, y, -radius(angle) * sin)
        };
        (0..sides).map(point).collect()
    };
    let (threaded, plain, top) = (0.55, 0.72, 0.9);
    let rows = edges(threaded, edge, (6.0 * threaded / pitch) as usize);
    let mut rings: Vec<Vec<DVec3>> = (0..=rows)
        .map(|i| {
            let y = threaded * i as f64 / rows as f64;
            let fade = (i.min(rows - i) as f64 / 4.0).min(1.0);
            ring(y, &|angle| {
                let phase = (y / pitch + angle / TAU).rem_euclid(1.0);
                shaft + fade * thread * (1.0 - (4.0 * phase - 2.0).abs())
            })
        })
        .collect();
    let rows = edges(plain - threaded, edge, 2);
    rings.extend(
        (1..=rows)
            .map(|i| ring(threaded + (plain - threaded) * i as f64 / rows as f64, &|_| shaft)),
    );
    let hexagon =
        |angle: f64| head * (PI / 6.0).cos() / (angle.rem_euclid(PI / 3.0) - PI / 6.0).cos();
    let rows = edges(head - shaft, edge, 1);
    rings.extend((1..=rows).map(|i| {
        let t = i as f64 / rows as f64;
        ring(plain, &move |angle| shaft + t * (hexagon(angle) - shaft))
    }));
    let rows = edges(top - plain, edge, 1);
    rings
        .extend((1..=rows).map(|i| ring(plain + (top - plain) * i as f64 / rows as f64, &hexagon)));
    skin(&rings, Cap::Fan)
}

/// A loop of sections that closes upon itself: `sections` of as many points each.
fn closed(sections: &[Vec<DVec3>]) -> Solid {
    let mut solid = Solid::default();
    let ids: Vec<Vec<u32>> =
        sections.iter().map(|s| s.iter().map(|&p| solid.vertex(p)).collect()).collect();
    for (i, a) in ids.iter().enumerate() {
        let b = &ids[(i + 1) % ids.len()];
        for j in 0..a.len() {
            let k = (j + 1) % a.len();
            solid.quad([a[j], b[j], b[k], a[k]]);
        }
    }
    solid.wound_outwards()
}

/// A section with as many edges along each side as its length wants.
fn section(corners: &[DVec2], edge: f64) -> Vec<DVec2> {
    let mut points = Vec::new();
    for (i, &from) in corners.iter().enumerate() {
        let to = corners[(i + 1) % corners.len()];
        let count = edges(from.distance(to), edge, 1);
        points.extend((0..count).map(|k| from.lerp(to, k as f64 / count as f64)));
    }
    points
}

/// A spur wheel of eighteen teeth with a bore.
pub(super) fn gear(edge: f64) -> Solid {
    let (teeth, root, tip, bore, width) = (18, 0.38, 0.45, 0.12, 0.14);
    // Radius and height of the section; what is at the outside follows the teeth.
    let square = [(bore, 0.0), (root, 0.0), (root, width), (bore, width)].map(DVec2::from);
    let section = section(&square, edge);
    // Angles of a tooth's corners over a pitch, and how far out each is.
    let tooth = [(0.0, 0.0), (0.22, 0.0), (0.38, 1.0), (0.62, 1.0), (0.78, 0.0)];
    let each = edges(TAU * root / f64::from(teeth * 5), edge, 1);
    let mut sections = Vec::new();
    for number in 0..teeth {
        for (k, &(from, low)) in tooth.iter().enumerate() {
            let (to, high) = tooth.get(k + 1).copied().unwrap_or((1.0, 0.0));
            for step in 0..each {
                let t = step as f64 / each as f64;
                let angle = TAU * (f64::from(number) + from + t * (to - from)) / f64::from(teeth);
                let out = low + t * (high - low);
                let (sin, cos) = angle.sin_cos();
                let place = |p: &DVec2| {
                    let r = if p.x > root - 1e-9 { root + out * (tip - root) } else { p.x };
                    DVec3::new(r * cos, p.y, -r * sin)
                };
                sections.push(section.iter().map(place).collect());
            }
        }
    }
    closed(&sections)
}

/// A rim, a hub and sixteen spokes, which touch and are not grown together.
pub(super) fn wheel(edge: f64) -> Solid {
    let (hub, spoke) = (0.07, 0.008);
    let sides = edges(TAU * hub, edge, 12);
    let mut solid = ring(0.45, 0.025, edge).and(
        cylinder(hub, 0.16, 0.01, sides, edges(0.14, edge, 1))
            .along(DVec3::new(0.0, 0.0, -0.08), DVec3::Z),
    );
    for k in 0..16 {
        let (sin, cos) = (TAU * f64::from(k) / 16.0).sin_cos();
        let side = if k % 2 == 0 { 0.05 } else { -0.05 };
        let from = hub * DVec3::new(cos, sin, side / hub);
        let to = 0.43 * DVec3::new(cos, sin, 0.0);
        let length = from.distance(to);
        solid = solid.and(
            cylinder(spoke, length, 0.0, edges(TAU * spoke, edge, 6), edges(length, edge, 1))
                .along(from, to),
        );
    }
    solid.shifted(DVec3::Y * 0.48)
}

/// A cylinder with round ends.
fn capsule(from: DVec3, to: DVec3, radius: f64, edge: f64) -> Solid {
    let length = from.distance(to);
    let (round, rows) = (edges(0.5 * PI * radius, edge, 3), edges(length, edge, 2));
    let arc = |i: usize| {
        let (sin, cos) = (0.5 * PI * i as f64 / round as f64).sin_cos();
        DVec2::new(radius * sin, -radius * cos)
    };
    let mut profile: Vec<DVec2> = (0..=round).map(arc).collect();
    profile.extend((1..rows).map(|i| DVec2::new(radius, length * i as f64 / rows as f64)));
    profile.extend((0..=round).rev().map(|i| DVec2::new(arc(i).x, length - arc(i).y)));
    lathe(&profile, edges(TAU * radius, edge, 8)).along(from, to)
}

/// A person of capsules that run into each other.
pub(super) fn figure(edge: f64) -> Solid {
    let v = DVec3::new;
    let mut bones = vec![
        (v(0.0, 0.62, 0.0), v(0.0, 0.86, 0.0), 0.11),
        (v(0.0, 1.0, 0.0), v(0.0, 1.06, 0.0), 0.085),
        (v(0.0, 0.88, 0.0), v(0.0, 0.98, 0.0), 0.045),
    ];
    for x in [-1.0, 1.0] {
        bones.extend([
            (v(0.07 * x, 0.56, 0.0), v(0.09 * x, 0.32, 0.02), 0.065),
            (v(0.09 * x, 0.32, 0.02), v(0.09 * x, 0.06, 0.0), 0.05),
            (v(0.09 * x, 0.04, 0.0), v(0.1 * x, 0.035, 0.11), 0.035),
            (v(0.13 * x, 0.9, 0.0), v(0.27 * x, 0.72, 0.0), 0.045),
            (v(0.27 * x, 0.72, 0.0), v(0.36 * x, 0.52, 0.06), 0.037),
            (v(0.37 * x, 0.48, 0.07), v(0.38 * x, 0.43, 0.08), 0.033),
        ]);
    }
    bones.into_iter().fold(Solid::default(), |solid, (from, to, radius)| {
        solid.and(capsule(from, to, radius, edge))
    })
}

/// The frame of a picture: a moulding with mitred corners.
pub(super) fn frame(edge: f64) -> Solid {
    let half = DVec2::new(0.42, 0.55);
    // How far in from the outside, and how far forward.
    let moulding =
        [(0.0, 0.0), (0.09, 0.0), (0.09, 0.02), (0.06, 0.035), (0.03, 0.05), (0.0, 0.04)];
    let section = section(&moulding.map(DVec2::from), edge);
    let corners = [(1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)].map(DVec2::from);
    let mut sections = Vec::new();
    for (k, &from) in corners.iter().enumerate() {
        let to = corners[(k + 1) % 4];
        let count = edges((half * from).distance(half * to), edge, 1);
        for step in 0..count {
            let t = step as f64 / count as f64;
            let place = |p: &DVec2| {
                let inner = half - DVec2::splat(p.x);
                let at = (inner * from).lerp(inner * to, t);
                DVec3::new(at.x, at.y + half.y, p.y)
            };
            sections.push(section.iter().map(place).collect());
        }
    }
    closed(&sections)
}
