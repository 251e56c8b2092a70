//! Objects as they come in the wild, for training: parts that carry ribs, bosses, plates and rows of
//! small things which are no parts of their own.

use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::solid::{Detail, Solid, board, cylinder, lathe};
use super::{SynthKind, SynthObject, SynthPart, SynthVariant, parts};

/// Chance that an object is embellished at all.
const EMBELLISHED: f64 = 0.55;

/// Chance that a part of such an object is.
const PART: f64 = 0.5;

/// Chance that such a part carries many rows.
const BUSY: f64 = 0.25;

/// An object for training: a random resolution, some parts embellished.
pub fn embellished(kind: SynthKind, seed: u64) -> SynthObject {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(7);
    let detail = Detail(0.6 * 2.5_f64.powf(rng.random_range(0.0..1.0)));
    let mut parts = parts(kind, seed, detail);
    if rng.random_bool(EMBELLISHED) {
        for part in &mut parts {
            if rng.random_bool(PART) {
                embellish(part, &mut rng);
            }
        }
    }
    SynthObject { kind, variant: SynthVariant::MultiNode, parts, fused: None }
}

fn add(part: &mut SynthPart, positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) {
    let base = part.positions.len() as u32;
    part.positions.extend(positions);
    part.triangles.extend(triangles.into_iter().map(|t| t.map(|v| v + base)));
}

/// A place on a part: a point, the normal, a direction along the surface.
struct Place {
    point: DVec3,
    normal: DVec3,
    along: DVec3,
}

/// A random place, large faces first.
fn place(part: &SynthPart, rng: &mut ChaCha8Rng) -> Option<Place> {
    let corners = |t: &[u32; 3]| t.map(|v| part.positions[v as usize]);
    let area = |t: &[u32; 3]| {
        let [a, b, c] = corners(t);
        0.5 * (b - a).cross(c - a).length()
    };
    let total: f64 = part.triangles.iter().map(area).sum();
    let mut at = rng.random_range(0.0..1.0) * total;
    let chosen = part.triangles.iter().find(|t| {
        at -= area(t);
        at <= 0.0
    })?;
    let [a, b, c] = corners(chosen);
    let normal = (b - a).cross(c - a).try_normalize()?;
    let (u, v): (f64, f64) = (rng.random_range(0.2..0.5), rng.random_range(0.2..0.5));
    let axis = [DVec3::X, DVec3::Y, DVec3::Z][rng.random_range(0..3)];
    let along = (axis - normal * axis.dot(normal)).try_normalize();
    let along = along.unwrap_or_else(|| normal.any_orthonormal_vector());
    Some(Place { point: a + u * (b - a) + v * (c - a), normal, along })
}

/// Put rows of small things on a part: up to three, sometimes a dozen.
fn embellish(part: &mut SynthPart, rng: &mut ChaCha8Rng) {
    let low = part.positions.iter().fold(DVec3::INFINITY, |m, &p| m.min(p));
    let high = part.positions.iter().fold(DVec3::NEG_INFINITY, |m, &p| m.max(p));
    let size = (high - low).length();
    let bare = part.clone();
    let rows =
        if rng.random_bool(BUSY) { rng.random_range(4..=12) } else { rng.random_range(1..=3) };
    for _ in 0..rows {
        let Some(place) = place(&bare, rng) else { continue };
        let scale = size * rng.random_range(0.012..0.07);
        let thing = thing(scale, rng);
        let turn = DQuat::from_rotation_arc(DVec3::Y, place.normal);
        let row = if rng.random_bool(0.5) { rng.random_range(2..9) } else { 1 };
        let pitch = scale * rng.random_range(1.3..3.0);
        for i in 0..row {
            let shift = place.along * (pitch * (f64::from(i) - 0.5 * f64::from(row - 1)));
            // Its foot stands in the part.
            let foot = place.point + shift - place.normal * (0.2 * scale);
            let positions = thing.positions.iter().map(|&p| foot + turn * p).collect();
            add(part, positions, thing.triangles.clone());
        }
    }
}

/// A rib, a plate, a boss or a knob about as large as `scale`, standing on y = 0.
fn thing(scale: f64, rng: &mut ChaCha8Rng) -> Solid {
    let mut share = |low: f64, high: f64| scale * rng.random_range(low..high);
    let (x, y, z) = (share(0.2, 1.0), share(0.1, 0.6), share(0.2, 1.0));
    match rng.random_range(0..4) {
        0 => board(DVec3::new(x, y, z), [1, 1]).shifted(DVec3::Y * y),
        1 => cylinder(0.6 * x, 2.0 * y, 0.0, 10, 1),
        2 => board(DVec3::new(0.15 * x, y, z), [1, 2]).shifted(DVec3::Y * y),
        _ => {
            let arc = |i: i32| (std::f64::consts::FRAC_PI_2 * f64::from(i) / 4.0).sin_cos();
            let profile: Vec<_> = (0..=4)
                .map(|i| glam::DVec2::new(0.6 * x * arc(4 - i).0, y + y * arc(i).0))
                .collect();
            let mut all = vec![glam::DVec2::new(0.6 * x, 0.0)];
            all.extend(profile);
            lathe(&all, 10)
        }
    }
}
