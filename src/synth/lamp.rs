//! A lamp for table or floor: a foot, a pole, straight, bent or turned, and a shade with a wall.

use glam::{DVec2, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::SynthPart;
use super::profile::{marks, turned};
use super::solid::{Detail, Solid, lathe, tube, vessel};

const POLE: &[(f64, f64)] =
    &[(1.0, 0.0), (0.55, 0.08), (0.9, 0.30), (0.45, 0.52), (0.7, 0.74), (0.4, 1.0)];

pub(super) fn parts(rng: &mut ChaCha8Rng, detail: Detail) -> Vec<SynthPart> {
    let tall = rng.random_range(0.35..1.5);
    let foot = rng.random_range(0.09..0.14) + 0.04 * tall;
    let thick = rng.random_range(0.012..0.035);
    let pole = rng.random_range(0.008..0.014) + 0.004 * tall;
    let shade = rng.random_range(0.09..0.16) + 0.05 * tall;
    let taper = rng.random_range(0.45..1.0);
    let drop = rng.random_range(0.9..1.4) * shade;
    let style = rng.random_range(0..3);

    let dome = rng.random_range(0.2..1.0);
    let n = detail.of(4.0, 2);
    let mut profile = vec![DVec2::ZERO, DVec2::new(foot, 0.0), DVec2::new(foot, 0.5 * thick)];
    profile.extend((1..n).map(|i| {
        let t = i as f64 / n as f64;
        DVec2::new(foot * (1.0 - 0.85 * t), thick * (0.5 + dome * t))
    }));
    profile.push(DVec2::new(0.0, thick * (0.5 + dome)));
    let sides = detail.of(14.0, 8);
    let mut parts = vec![SynthPart::new("base", lathe(&profile, sides))];

    // The pole ends within the shade; a bent one reaches out over the foot's edge.
    let (low, high) = (0.3 * thick, tall - 0.55 * drop);
    let reach = if style == 1 { rng.random_range(0.1..0.3) * tall } else { 0.0 };
    let stem: Solid = if style == 2 {
        let turned = turned(&marks(POLE, 2.2 * pole, high - low), detail.of(14.0, 4));
        lathe(&turned, detail.of(8.0, 6)).shifted(DVec3::Y * low)
    } else {
        let n = detail.of(12.0, 5);
        let bend = |t: f64| {
            let out = (t - 0.4).max(0.0) / 0.6;
            DVec3::new(reach * out * out, low + t * (high - low), 0.0)
        };
        let path: Vec<DVec3> = (0..=n).map(|i| bend(i as f64 / n as f64)).collect();
        tube(&path, |_| pole, detail.of(7.0, 6))
    };
    parts.push(SynthPart::new("pole", stem));

    let wall = 0.004 + 0.02 * shade;
    let n = detail.of(5.0, 2);
    let round = rng.random_range(0.0..0.25);
    let outer: Vec<DVec2> = (0..=n)
        .map(|i| {
            let t = i as f64 / n as f64;
            let r = shade * (taper + (1.0 - taper) * t + round * (t * (1.0 - t)));
            DVec2::new(r, t * drop)
        })
        .collect();
    // Open towards the floor.
    let cover = vessel(&outer, wall, 1.5 * wall, detail.of(16.0, 10))
        .map(|p| DVec3::new(p.x, -p.y, -p.z))
        .shifted(DVec3::new(reach, high + 0.6 * wall, 0.0));
    parts.push(SynthPart::new("shade", cover));
    parts
}
