//! A skateboard along x: a concave deck with upturned ends, two trucks (base plate, hanger, axle),
//! four wheels and the bolts of the trucks.

use std::f64::consts::FRAC_PI_2;

use glam::{DQuat, DVec2, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::SynthPart;
use super::outline::squircle;
use super::solid::{Detail, Rim, Solid, board, cylinder, lathe, slab};

/// Share of the half length at which the rounded, upturned ends begin.
const END: f64 = 0.66;

struct Plan {
    half_length: f64,
    half_width: f64,
    height: f64,
    lift: f64,
    concave: f64,
    wheel: f64,
}

impl Plan {
    /// The upper side of the deck over the square: parallel sides, ends like half a superellipse
    /// that bend upwards, edges raised.
    fn deck(&self, u: f64, v: f64) -> DVec3 {
        let beyond = ((u.abs() - END) / (1.0 - END)).max(0.0);
        let p = squircle(beyond, v, 2.3);
        let along = if beyond > 0.0 { END + (1.0 - END) * p.x } else { u.abs() };
        let rise = self.lift * ((along - END) / (1.0 - END)).max(0.0).powi(2);
        let cup = self.concave * p.y * p.y * (1.0 - 0.5 * beyond);
        let x = self.half_length * along * u.signum();
        DVec3::new(x, self.height + rise + cup, -self.half_width * p.y)
    }
}

/// A solid of revolution about z, centred on the origin.
fn across(s: Solid, length: f64) -> Solid {
    s.shifted(DVec3::new(0.0, -0.5 * length, 0.0)).map(|p| DQuat::from_rotation_x(FRAC_PI_2) * p)
}

pub(super) fn parts(rng: &mut ChaCha8Rng, detail: Detail) -> Vec<SynthPart> {
    let plan = Plan {
        half_length: rng.random_range(0.38..0.42),
        half_width: rng.random_range(0.098..0.108),
        height: 0.098,
        lift: rng.random_range(0.045..0.065),
        concave: rng.random_range(0.008..0.013),
        wheel: rng.random_range(0.025..0.029),
    };
    let thickness = 0.011;
    let down = DVec3::new(0.0, -thickness, 0.0);
    let rims = [Rim { rise: 0.5, out: 0.003 }];
    let cells = [detail.of(16.0, 10), detail.of(5.0, 4)];
    let deck = slab(cells, |u, v| plan.deck(u, v), |u, v| plan.deck(u, v) + down, &rims);
    let mut parts = vec![SynthPart::new("deck", deck)];

    let under = plan.height - thickness;
    let (track, axle_y) = (0.078, plan.wheel);
    let mut numbers = (1, 1);
    for (i, end) in [-1.0, 1.0].into_iter().enumerate() {
        let x = end * 0.54 * plan.half_length;
        let plate = board(DVec3::new(0.042, 0.006, 0.027), [detail.of(2.0, 2), detail.of(1.5, 1)])
            .shifted(DVec3::new(x, under - 0.003, 0.0));
        parts.push(SynthPart::new(format!("base_plate_{}", i + 1), plate));

        // The hanger: a spindle across, thick in the middle, that hangs from the plate.
        let marks = [(0.010, 0.0), (0.011, 0.006), (0.016, 0.035), (0.021, 0.055)];
        let mut profile: Vec<DVec2> = marks.iter().map(|&(r, y)| DVec2::new(r, y)).collect();
        profile.extend(marks.iter().rev().map(|&(r, y)| DVec2::new(r, 0.110 - y)).skip(1));
        let hanger = across(lathe(&profile, detail.of(8.0, 6)), 0.110);
        let reach = under - 0.006 - axle_y;
        // Stretched upwards into the plate.
        let hanger = hanger
            .map(|p| {
                let pull = (1.0 - (p.z / 0.040).powi(2)).max(0.0) * p.y.max(0.0) / 0.021;
                DVec3::new(p.x, p.y + pull * (reach - 0.018), p.z)
            })
            .shifted(DVec3::new(x, axle_y, 0.0));
        parts.push(SynthPart::new(format!("hanger_{}", i + 1), hanger));

        let length = 2.0 * (track + 0.021);
        let axle =
            across(cylinder(0.0042, length, 0.0, detail.of(4.0, 6), detail.of(9.0, 4)), length)
                .shifted(DVec3::new(x, axle_y, 0.0));
        parts.push(SynthPart::new(format!("axle_{}", i + 1), axle));

        for side in [-1.0, 1.0] {
            let wide = 0.033;
            let wheel = across(cylinder(plan.wheel, wide, 0.005, detail.of(12.0, 9), 1), wide)
                .shifted(DVec3::new(x, axle_y, side * track));
            parts.push(SynthPart::new(format!("wheel_{}", numbers.0), wheel));
            numbers.0 += 1;
        }
        for (dx, dz) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let (bx, bz) = (x + dx * 0.032, dz * 0.020);
            let top = plan.height + plan.concave * (bz / plan.half_width).powi(2) + 0.0018;
            let foot = under - 0.004;
            let bolt = cylinder(0.0040, top - foot, 0.0, detail.of(4.0, 5), 1)
                .shifted(DVec3::new(bx, foot, bz));
            parts.push(SynthPart::new(format!("bolt_{}", numbers.1), bolt));
            numbers.1 += 1;
        }
    }
    parts
}
