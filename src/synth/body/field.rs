//! Solids as signed distances, negative inside. Every shape is exact outside and the blend of two
//! distances has a gradient between theirs, so a field changes by no more than the way gone
//! (1-Lipschitz): that is what lets marching cubes pass over empty space. Derived here: the round cone
//! as the hull of two spheres, in the half plane of its axis. The blend is the quadratic one of
//! Quilez, "Smooth minimum" (https://iquilezles.org/articles/smin/), written from its formula.

use glam::{DQuat, DVec2, DVec3};

/// The hull of two spheres, seen in the half plane (along the axis, away from it).
#[derive(Debug, Clone, Copy)]
struct Hull {
    length: f64,
    radius: f64,
    /// Loss of radius a unit of length: the sine of the slant.
    slope: f64,
    /// Its tangent.
    lean: f64,
}

impl Hull {
    fn new(length: f64, radii: [f64; 2]) -> Self {
        // A sphere within the other leaves the larger one; shapes here never come near that.
        let slope = ((radii[0] - radii[1]) / length.max(1e-9)).clamp(-0.99, 0.99);
        Self { length, radius: radii[0], slope, lean: slope / (1.0 - slope * slope).sqrt() }
    }

    fn distance(&self, along: f64, away: f64) -> f64 {
        // The sphere of the hull that is nearest: its centre is where the normal meets the axis.
        let t = (along - away * self.lean).clamp(0.0, self.length);
        let d = along - t;
        (d * d + away * away).sqrt() - (self.radius - self.slope * t)
    }
}

/// A shape of its own.
#[derive(Debug, Clone)]
enum Shape {
    RoundCone {
        from: DVec3,
        axis: DVec3,
        hull: Hull,
    },
    Box {
        centre: DVec3,
        turned: DQuat,
        half: DVec3,
        round: f64,
    },
    Torus {
        centre: DVec3,
        axis: DVec3,
        ring: f64,
        tube: f64,
    },
    /// A line of varying thickness in the half plane (radius, height), turned about the y axis.
    Revolved {
        pieces: Vec<(DVec2, DVec2, Hull)>,
    },
}

impl Shape {
    fn distance(&self, p: DVec3) -> f64 {
        match self {
            Self::RoundCone { from, axis, hull } => {
                let v = p - *from;
                let along = v.dot(*axis);
                hull.distance(along, (v.length_squared() - along * along).max(0.0).sqrt())
            }
            Self::Box { centre, turned, half, round } => {
                let q = (*turned * (p - *centre)).abs() - *half + DVec3::splat(*round);
                q.max(DVec3::ZERO).length() + q.max_element().min(0.0) - round
            }
            Self::Torus { centre, axis, ring, tube } => {
                let v = p - *centre;
                let height = v.dot(*axis);
                let away = (v.length_squared() - height * height).max(0.0).sqrt() - ring;
                (away * away + height * height).sqrt() - tube
            }
            Self::Revolved { pieces } => {
                let p = DVec2::new((p.x * p.x + p.z * p.z).sqrt(), p.y);
                let piece = |(from, axis, hull): &(DVec2, DVec2, Hull)| {
                    let v = p - *from;
                    hull.distance(v.dot(*axis), v.perp_dot(*axis).abs())
                };
                pieces.iter().map(piece).fold(f64::INFINITY, f64::min)
            }
        }
    }
}

/// Shapes that belong together, with a ball round them that tells when they cannot matter.
#[derive(Debug, Clone)]
pub(super) struct Group {
    shapes: Vec<Shape>,
    /// Width of the blend between its shapes.
    within: f64,
    /// Width of the blend with the groups before.
    outside: f64,
    low: DVec3,
    high: DVec3,
}

impl Group {
    pub(super) fn new(within: f64, outside: f64) -> Self {
        let (low, high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        Self { shapes: vec![], within, outside, low, high }
    }

    fn push(&mut self, shape: Shape, low: DVec3, high: DVec3) {
        self.shapes.push(shape);
        self.low = self.low.min(low);
        self.high = self.high.max(high);
    }

    /// Round cones from ball to ball.
    pub(super) fn chain(mut self, balls: &[(DVec3, f64)]) -> Self {
        for pair in balls.windows(2) {
            let ((a, ra), (b, rb)) = (pair[0], pair[1]);
            let axis = (b - a).normalize_or(DVec3::Y);
            let hull = Hull::new(a.distance(b), [ra, rb]);
            let (ea, eb) = (DVec3::splat(ra), DVec3::splat(rb));
            let shape = Shape::RoundCone { from: a, axis, hull };
            self.push(shape, (a - ea).min(b - eb), (a + ea).max(b + eb));
        }
        self
    }

    /// A box with rounded edges; `half` is half its size, rounding included.
    pub(super) fn block(mut self, centre: DVec3, turned: DQuat, half: DVec3, round: f64) -> Self {
        let reach = DVec3::splat(half.length());
        let shape = Shape::Box { centre, turned: turned.inverse(), half, round };
        self.push(shape, centre - reach, centre + reach);
        self
    }

    /// A ring about an axis.
    pub(super) fn torus(mut self, centre: DVec3, axis: DVec3, ring: f64, tube: f64) -> Self {
        let reach = DVec3::splat(ring + tube);
        let shape = Shape::Torus { centre, axis: axis.normalize_or(DVec3::Y), ring, tube };
        self.push(shape, centre - reach, centre + reach);
        self
    }

    /// Balls (radius, height) joined and turned about the y axis.
    pub(super) fn revolved(mut self, balls: &[(DVec2, f64)]) -> Self {
        let piece = |pair: &[(DVec2, f64)]| {
            let ((a, ra), (b, rb)) = (pair[0], pair[1]);
            (a, (b - a).normalize_or(DVec2::Y), Hull::new(a.distance(b), [ra, rb]))
        };
        let pieces = balls.windows(2).map(piece).collect();
        let wide = balls.iter().map(|(p, r)| p.x + r).fold(0.0, f64::max);
        let bottom = balls.iter().map(|(p, r)| p.y - r).fold(f64::INFINITY, f64::min);
        let top = balls.iter().map(|(p, r)| p.y + r).fold(f64::NEG_INFINITY, f64::max);
        let (low, high) = (DVec3::new(-wide, bottom, -wide), DVec3::new(wide, top, wide));
        self.push(Shape::Revolved { pieces }, low, high);
        self
    }

    fn distance(&self, p: DVec3) -> f64 {
        let blend = |d, s: &Shape| smooth_min(d, s.distance(p), self.within);
        self.shapes.iter().fold(f64::INFINITY, blend)
    }
}

/// A group and the ball that holds it, blend included.
#[derive(Debug, Clone)]
struct Ball {
    centre: DVec3,
    reach: f64,
    group: Group,
}

/// A solid: the smooth union of groups.
#[derive(Debug, Clone)]
pub(super) struct Field {
    balls: Vec<Ball>,
    /// The box that holds it.
    pub(super) low: DVec3,
    pub(super) high: DVec3,
}

impl Field {
    pub(super) fn new(groups: Vec<Group>) -> Self {
        // A blend swells by a quarter of its width at most.
        let swell = |g: &Group| 0.25 * (g.within * g.shapes.len() as f64 + g.outside);
        let low = groups.iter().map(|g| g.low - swell(g)).fold(DVec3::INFINITY, DVec3::min);
        let high = groups.iter().map(|g| g.high + swell(g)).fold(DVec3::NEG_INFINITY, DVec3::max);
        let ball = |group: Group| {
            let reach = 0.5 * group.low.distance(group.high) + swell(&group);
            Ball { centre: 0.5 * (group.low + group.high), reach, group }
        };
        Self { balls: groups.into_iter().map(ball).collect(), low, high }
    }

    /// Signed distance, or less.
    pub(super) fn distance(&self, p: DVec3) -> f64 {
        union(self.balls.iter(), p)
    }

    /// What of the field matters within `reach` of a point.
    pub(super) fn near(&self, p: DVec3, reach: f64) -> Near<'_> {
        let widest = self.balls.iter().map(|b| b.group.outside).fold(0.0, f64::max);
        // Three widths: blends of groups that are both too far must not matter either.
        let far = self.distance(p) + 2.0 * reach + 3.0 * widest;
        let matters = |b: &&Ball| p.distance(b.centre) - b.reach <= far;
        Near(self.balls.iter().filter(matters).collect())
    }
}

/// Part of a field. Where it stands for the field, it has the same values to the last bit.
pub(super) struct Near<'a>(Vec<&'a Ball>);

impl Near<'_> {
    pub(super) fn distance(&self, p: DVec3) -> f64 {
        union(self.0.iter().copied(), p)
    }
}

fn union<'a>(balls: impl Iterator<Item = &'a Ball>, p: DVec3) -> f64 {
    balls.fold(f64::INFINITY, |d, b| {
        // Farther than the blend is wide, a group changes nothing.
        let near = d + b.group.outside + b.reach;
        if near > 0.0 && p.distance_squared(b.centre) < near * near {
            smooth_min(d, b.group.distance(p), b.group.outside)
        } else {
            d
        }
    })
}

/// The smaller of two, rounded off where they differ by less than `width`.
fn smooth_min(a: f64, b: f64, width: f64) -> f64 {
    // Negative where one of them is infinite.
    let overlap = width - (a - b).abs();
    if overlap > 0.0 { a.min(b) - 0.25 * overlap * overlap / width } else { a.min(b) }
}
