//! A chair: a doubly curved shell seat on four turned legs, stretchers between them, and a back of
//! spindles, slats or one shell between two turned posts. x is its right, z its front.

use glam::{DVec2, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::SynthPart;
use super::outline::squircle;
use super::profile::{LEGS, marks, turned};
use super::solid::{Detail, Rim, Solid, lathe, slab, tube};

const POST: &[(f64, f64)] =
    &[(0.80, 0.0), (1.0, 0.14), (0.72, 0.46), (0.88, 0.74), (0.66, 0.88), (0.96, 0.94), (0.5, 1.0)];
const SPINDLE: &[(f64, f64)] = &[(0.62, 0.0), (1.0, 0.34), (0.70, 0.72), (0.58, 1.0)];

#[derive(Clone, Copy)]
enum Back {
    Spindles(usize),
    Slats(usize),
    Shell,
}

/// The sizes that the seed decides, metres.
struct Plan {
    half_width: f64,
    half_depth: f64,
    seat: f64,
    thickness: f64,
    dip: f64,
    roundness: f64,
    top: f64,
    recline: f64,
    splay: f64,
    leg_radius: f64,
    leg: &'static [(f64, f64)],
    bow: f64,
    back: Back,
}

impl Plan {
    fn draw(rng: &mut ChaCha8Rng) -> Self {
        let seat = rng.random_range(0.42..0.47);
        Self {
            half_width: rng.random_range(0.20..0.24),
            half_depth: rng.random_range(0.19..0.22),
            seat,
            thickness: rng.random_range(0.034..0.042),
            dip: rng.random_range(0.014..0.022),
            roundness: rng.random_range(3.0..4.5),
            top: seat + rng.random_range(0.42..0.52),
            recline: rng.random_range(0.06..0.12),
            splay: rng.random_range(0.025..0.055),
            leg_radius: rng.random_range(0.021..0.026),
            leg: LEGS[rng.random_range(0..LEGS.len())],
            bow: rng.random_range(0.025..0.045),
            back: match rng.random_range(0..3) {
                0 => Back::Spindles(rng.random_range(4..=6)),
                1 => Back::Slats(rng.random_range(2..=3)),
                _ => Back::Shell,
            },
        }
    }

    /// Height of the seat's upper side at (x, z), both as shares of the half sizes: a saddle in
    /// both directions that rolls off at the front.
    fn seat_height(&self, p: DVec2) -> f64 {
        let hollow = self.dip * (1.0 - p.x * p.x) * (1.0 - 0.6 * p.y * p.y);
        self.seat - hollow - 0.012 * p.y.max(0.0).powi(2)
    }

    /// The point of the seat over (x, z), `depth` (share of its thickness) below its upper side.
    fn seat_point(&self, p: DVec2, depth: f64) -> DVec3 {
        let x = self.half_width * p.x * (1.0 + 0.07 * p.y);
        let y = self.seat_height(p) - depth * self.thickness;
        DVec3::new(x, y, self.half_depth * p.y)
    }

    fn seat_solid(&self, detail: Detail) -> Solid {
        let place =
            |u: f64, v: f64, depth: f64| self.seat_point(squircle(u, v, self.roundness), depth);
        let rims = [Rim { rise: 0.22, out: 0.007 }, Rim { rise: 0.72, out: 0.009 }];
        let n = detail.of(7.0, 4);
        slab([n, n], |u, v| place(u, v, 0.0), |u, v| place(u, v, 1.0), &rims)
    }

    /// Foot and head of a leg; sides are −1 or 1.
    fn leg(&self, side: f64, front: f64) -> (DVec3, DVec3) {
        let head = self.seat_point(DVec2::new(0.70 * side, 0.70 * front), 0.55);
        let mut foot = DVec3::new(head.x + side * self.splay, 0.0, head.z + front * self.splay);
        if front < 0.0 {
            foot.z -= 0.5 * self.recline;
        }
        (foot, head)
    }

    /// Foot and head of a post of the back.
    fn post(&self, side: f64) -> (DVec3, DVec3) {
        let foot = self.seat_point(DVec2::new(0.80 * side, -0.80), 0.6);
        (foot, DVec3::new(1.12 * foot.x, self.top, foot.z - self.recline))
    }

    /// A board between the posts, bowed backwards and arched, from share `low` to `high` of them.
    fn board(&self, low: f64, high: f64, arch: f64, cells: [usize; 2]) -> Solid {
        let ((foot, head), half) = (self.post(1.0), 0.5 * (high - low));
        let height = self.top - foot.y;
        let sheet = |side: f64| {
            move |u: f64, v: f64| {
                let t = low + half + half * v;
                let on_post = foot.lerp(head, t);
                let open = 1.0 - u * u;
                let lift = arch * open * (0.5 + 0.5 * v) * height;
                let hollow = self.bow * open + 0.010 * (1.0 - v * v);
                DVec3::new(u * on_post.x, on_post.y + lift, on_post.z - hollow + side * 0.008)
            }
        };
        slab(cells, sheet(1.0), sheet(-1.0), &[Rim { rise: 0.5, out: 0.004 }])
    }
}

pub(super) fn parts(rng: &mut ChaCha8Rng, detail: Detail) -> Vec<SynthPart> {
    let plan = Plan::draw(rng);
    let mut parts = vec![SynthPart::new("seat", plan.seat_solid(detail))];
    let turning = |shape, radius: f64, (foot, head): (DVec3, DVec3), rings: f64, sides: f64| {
        let marks = marks(shape, radius, foot.distance(head));
        lathe(&turned(&marks, detail.of(rings, 3)), detail.of(sides, 6)).along(foot, head)
    };

    let corners = [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
    let legs = corners.map(|(side, front)| plan.leg(side, front));
    for (i, &ends) in legs.iter().enumerate() {
        let leg = turning(plan.leg, plan.leg_radius, ends, 15.0, 5.5);
        parts.push(SynthPart::new(format!("leg_{}", i + 1), leg));
    }

    let rod = |a: DVec3, b: DVec3| {
        let n = detail.of(7.0, 2);
        let path: Vec<DVec3> = (0..=n).map(|i| a.lerp(b, i as f64 / n as f64)).collect();
        tube(&path, |_| 0.0095, detail.of(3.6, 6))
    };
    let on = |i: usize, t: f64| legs[i].0.lerp(legs[i].1, t);
    let rods = [
        (on(0, 0.38), on(3, 0.38)),
        (on(1, 0.38), on(2, 0.38)),
        (on(0, 0.38).lerp(on(3, 0.38), 0.5), on(1, 0.38).lerp(on(2, 0.38), 0.5)),
        (on(3, 0.56), on(2, 0.56)),
    ];
    for (i, &(a, b)) in rods.iter().enumerate() {
        parts.push(SynthPart::new(format!("stretcher_{}", i + 1), rod(a, b)));
    }

    for (i, side) in [-1.0, 1.0].into_iter().enumerate() {
        let post = turning(POST, 0.017, plan.post(side), 13.0, 4.5);
        parts.push(SynthPart::new(format!("post_{}", i + 1), post));
    }
    let long = detail.of(8.0, 4);
    match plan.back {
        Back::Spindles(count) => {
            let crest = plan.board(0.74, 0.90, 0.06, [long, detail.of(1.5, 1)]);
            parts.push(SynthPart::new("crest_rail", crest));
            for i in 0..count {
                let u = 1.6 * (i as f64 + 0.5) / count as f64 - 0.8;
                let (foot, head) = plan.post(1.0);
                let from = plan.seat_point(DVec2::new(0.80 * u, -0.82), 0.5);
                let end = foot.lerp(head, 0.80);
                let to = DVec3::new(u * end.x, end.y, end.z - plan.bow * (1.0 - u * u) - 0.010);
                let spindle = turning(SPINDLE, 0.0085, (from, to), 8.0, 3.6);
                parts.push(SynthPart::new(format!("spindle_{}", i + 1), spindle));
            }
        }
        Back::Slats(count) => {
            for i in 0..count {
                let low = 0.26 + 0.60 * i as f64 / count as f64;
                let slat = plan.board(low, low + 0.12, 0.03, [long, detail.of(1.5, 1)]);
                parts.push(SynthPart::new(format!("slat_{}", i + 1), slat));
            }
        }
        Back::Shell => {
            let shell = plan.board(0.22, 0.90, 0.05, [long, long]);
            parts.push(SynthPart::new("back", shell));
        }
    }
    parts
}
