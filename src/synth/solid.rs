//! Closed solids from rings and from grids. Every constructor returns a closed manifold that is
//! wound outwards.

use std::f64::consts::TAU;

use glam::{DMat3, DQuat, DVec2, DVec3};

/// Resolution: how many times finer than the plainest form of an object.
#[derive(Debug, Clone, Copy)]
pub(super) struct Detail(pub f64);

impl Detail {
    /// `base` segments at resolution 1, at least `least`.
    pub fn of(self, base: f64, least: usize) -> usize {
        ((base * self.0).round() as usize).max(least)
    }
}

/// A closed triangle mesh.
#[derive(Debug, Clone, Default)]
pub(super) struct Solid {
    pub positions: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
}

impl Solid {
    /// A vertex more; its number.
    pub fn vertex(&mut self, p: DVec3) -> u32 {
        self.positions.push(p);
        self.positions.len() as u32 - 1
    }

    fn at(&self, i: u32) -> DVec3 {
        self.positions[i as usize]
    }

    /// A quad, split along the diagonal that leaves the larger smallest angle.
    pub fn quad(&mut self, [a, b, c, d]: [u32; 4]) {
        let p = |i| self.at(i);
        let ac = smallest_angle(p(a), p(b), p(c)).min(smallest_angle(p(a), p(c), p(d)));
        let bd = smallest_angle(p(a), p(b), p(d)).min(smallest_angle(p(b), p(c), p(d)));
        if bd > ac + 1e-9 {
            self.triangles.extend([[a, b, d], [b, c, d]]);
        } else {
            self.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }

    /// Fill a ring that turns counter-clockwise.
    fn close(&mut self, ring: &[u32], cap: Cap) {
        match cap {
            Cap::Fan => {
                let sum: DVec3 = ring.iter().map(|&v| self.at(v)).sum();
                let centre = self.vertex(sum / ring.len() as f64);
                for j in 0..ring.len() {
                    self.triangles.push([centre, ring[j], ring[(j + 1) % ring.len()]]);
                }
            }
            Cap::Ladder => {
                let (mut a, mut b) = (0, ring.len() - 1);
                while b > a + 2 {
                    self.quad([ring[a], ring[a + 1], ring[b - 1], ring[b]]);
                    (a, b) = (a + 1, b - 1);
                }
                if b == a + 2 {
                    self.triangles.push([ring[a], ring[a + 1], ring[b]]);
                }
            }
        }
    }

    /// Six times the signed volume; positive when wound outwards.
    fn volume6(&self) -> f64 {
        self.triangles
            .iter()
            .map(|t| t.map(|v| self.at(v)))
            .map(|[a, b, c]| a.dot(b.cross(c)))
            .sum()
    }

    /// Wound outwards, if it is closed.
    pub fn wound_outwards(mut self) -> Self {
        if self.volume6() < 0.0 {
            for t in &mut self.triangles {
                t.swap(1, 2);
            }
        }
        self
    }

    /// Every position moved by `f`, which must keep the hand.
    pub fn map(mut self, f: impl Fn(DVec3) -> DVec3) -> Self {
        for p in &mut self.positions {
            *p = f(*p);
        }
        self
    }

    /// Both; neither is changed where they meet.
    pub fn and(mut self, other: Solid) -> Self {
        let base = self.positions.len() as u32;
        self.positions.extend(other.positions);
        self.triangles.extend(other.triangles.into_iter().map(|t| t.map(|v| v + base)));
        self
    }

    /// Moved.
    pub fn shifted(self, by: DVec3) -> Self {
        self.map(|p| p + by)
    }

    /// Turned so that the local y axis runs from `from` towards `to`, with the origin at `from`.
    pub fn along(self, from: DVec3, to: DVec3) -> Self {
        let turn = DQuat::from_rotation_arc(DVec3::Y, (to - from).normalize_or(DVec3::Y));
        self.map(|p| from + turn * p)
    }
}

/// The smallest angle of a triangle, radians.
pub(super) fn smallest_angle(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let angle = |p: DVec3, q: DVec3, r: DVec3| (q - p).angle_between(r - p);
    angle(a, b, c).min(angle(b, c, a)).min(angle(c, a, b))
}

/// How the ends of a skin are closed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Cap {
    /// Triangles about the middle: for round rings.
    Fan,
    /// Rungs from the first half of the ring to the second: for narrow rings.
    Ladder,
}

/// The surface through a sequence of rings with the same number of points, each turning
/// counter-clockwise about the way of travel. A ring of one point is a pole; an end that is no pole
/// gets a flat cap.
pub(super) fn skin(rings: &[Vec<DVec3>], cap: Cap) -> Solid {
    let mut s = Solid::default();
    let mut ids: Vec<Vec<u32>> =
        rings.iter().map(|r| r.iter().map(|&p| s.vertex(p)).collect()).collect();
    for pair in ids.windows(2) {
        let (a, b) = (&pair[0], &pair[1]);
        let n = a.len().max(b.len());
        for j in 0..n {
            let k = (j + 1) % n;
            match (a.len(), b.len()) {
                (1, _) => s.triangles.push([a[0], b[k], b[j]]),
                (_, 1) => s.triangles.push([a[j], a[k], b[0]]),
                _ => s.quad([a[j], a[k], b[k], b[j]]),
            }
        }
    }
    // The first end is seen from the other side.
    if let Some(first) = ids.first_mut() {
        first.reverse();
    }
    for ring in [ids.first(), ids.last()].into_iter().flatten().filter(|r| r.len() > 1) {
        s.close(ring, cap);
    }
    s.wound_outwards()
}

/// A surface of revolution about the y axis: `profile` is (radius, height) with heights that do not
/// fall. A radius of 0 is a pole.
pub(super) fn lathe(profile: &[DVec2], sides: usize) -> Solid {
    let ring = |p: &DVec2| {
        if p.x < 1e-9 {
            return vec![DVec3::new(0.0, p.y, 0.0)];
        }
        let point = |j: usize| {
            let (sin, cos) = (TAU * j as f64 / sides as f64).sin_cos();
            DVec3::new(p.x * cos, p.y, -p.x * sin)
        };
        (0..sides).map(point).collect()
    };
    skin(&profile.iter().map(ring).collect::<Vec<_>>(), Cap::Fan)
}

/// A cylinder on the y axis from height 0, its rims bevelled by `bevel` (0: sharp), with `segments`
/// along its side.
pub(super) fn cylinder(
    radius: f64,
    height: f64,
    bevel: f64,
    sides: usize,
    segments: usize,
) -> Solid {
    let mut profile = Vec::new();
    if bevel > 0.0 {
        profile.push(DVec2::new(radius - bevel, 0.0));
    }
    for i in 0..=segments {
        let t = i as f64 / segments as f64;
        profile.push(DVec2::new(radius, bevel + t * (height - 2.0 * bevel)));
    }
    if bevel > 0.0 {
        profile.push(DVec2::new(radius - bevel, height));
    }
    lathe(&profile, sides)
}

/// Where the side of a slab runs: `rise` from the bottom (0) to the top (1), `out` away from the
/// outline, world units.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rim {
    pub rise: f64,
    pub out: f64,
}

/// A solid between two surfaces over the square [−1, 1]², with a side made of the rims, which are
/// given from the bottom upwards.
pub(super) fn slab(
    cells: [usize; 2],
    top: impl Fn(f64, f64) -> DVec3,
    bottom: impl Fn(f64, f64) -> DVec3,
    rims: &[Rim],
) -> Solid {
    let [nu, nv] = cells;
    let mut s = Solid::default();
    let mut sheet = |f: &dyn Fn(f64, f64) -> DVec3| -> Vec<u32> {
        let place = |i: usize, n: usize| 2.0 * i as f64 / n as f64 - 1.0;
        let points = (0..=nv).flat_map(|j| (0..=nu).map(move |i| (i, j)));
        points.map(|(i, j)| s.vertex(f(place(i, nu), place(j, nv)))).collect()
    };
    let (low, high) = (sheet(&bottom), sheet(&top));
    let id = |i: usize, j: usize| j * (nu + 1) + i;
    for j in 0..nv {
        for i in 0..nu {
            let corners = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
            s.quad(corners.map(|c| high[c]));
            let [a, b, c, d] = corners.map(|c| low[c]);
            s.quad([a, d, c, b]);
        }
    }
    // The outline, counter-clockwise over (u, v).
    let outline: Vec<usize> = (0..nu)
        .map(|i| id(i, 0))
        .chain((0..nv).map(|j| id(nu, j)))
        .chain((0..nu).map(|i| id(nu - i, nv)))
        .chain((0..nv).map(|j| id(0, nv - j)))
        .collect();
    let ring = |ids: &[u32]| outline.iter().map(|&c| ids[c]).collect::<Vec<_>>();
    let (foot, head) = (ring(&low), ring(&high));
    let mut rings = vec![foot.clone()];
    for rim in rims {
        let line: Vec<DVec3> =
            foot.iter().zip(&head).map(|(&f, &h)| s.at(f).lerp(s.at(h), rim.rise)).collect();
        let n = line.len();
        // The lattice may be of either hand: twice the area that the outline encloses tells.
        let up = |j: usize| (s.at(head[j]) - s.at(foot[j])).normalize_or(DVec3::Y);
        let turn: f64 =
            (0..n).map(|j| (line[j] - line[0]).cross(line[(j + 1) % n] - line[0]).dot(up(j))).sum();
        let out = rim.out * turn.signum();
        let points: Vec<DVec3> = (0..n)
            .map(|j| {
                line[j] + out * miter(line[(j + n - 1) % n], line[j], line[(j + 1) % n], up(j))
            })
            .collect();
        rings.push(points.into_iter().map(|p| s.vertex(p)).collect());
    }
    rings.push(head);
    for pair in rings.windows(2) {
        for j in 0..outline.len() {
            let k = (j + 1) % outline.len();
            s.quad([pair[0][j], pair[0][k], pair[1][k], pair[1][j]]);
        }
    }
    s.wound_outwards()
}

/// The way out of a counter-clockwise outline at `p`, so long that both of its edges move by 1.
fn miter(before: DVec3, p: DVec3, after: DVec3, up: DVec3) -> DVec3 {
    let a = (p - before).cross(up).normalize_or_zero();
    let b = (after - p).cross(up).normalize_or_zero();
    (a + b) / (1.0 + a.dot(b)).max(0.2)
}

/// A box with the given half sizes and sharp edges, thin along `y`, its large faces in `cells` along
/// x and z.
pub(super) fn board(half: DVec3, cells: [usize; 2]) -> Solid {
    let sheet = |y: f64| move |u: f64, v: f64| DVec3::new(u * half.x, y, -v * half.z);
    slab(cells, sheet(half.y), sheet(-half.y), &[])
}

/// A tube along a path. `radius` is given at the share of the path's points (0 to 1); frames are
/// carried along without twist.
pub(super) fn tube(path: &[DVec3], radius: impl Fn(f64) -> f64, sides: usize) -> Solid {
    let last = path.len() - 1;
    let tangent =
        |i: usize| (path[(i + 1).min(last)] - path[i.saturating_sub(1)]).normalize_or(DVec3::Y);
    let mut frame = DMat3::from_quat(DQuat::from_rotation_arc(DVec3::Y, tangent(0)));
    let mut rings = Vec::with_capacity(path.len());
    for (i, &centre) in path.iter().enumerate() {
        let turn = DQuat::from_rotation_arc(frame.y_axis.normalize(), tangent(i));
        frame = DMat3::from_quat(turn) * frame;
        let r = radius(i as f64 / last as f64);
        let point = |j: usize| {
            let (sin, cos) = (TAU * j as f64 / sides as f64).sin_cos();
            centre + r * (cos * frame.x_axis - sin * frame.z_axis)
        };
        rings.push((0..sides).map(point).collect());
    }
    skin(&rings, Cap::Fan)
}

/// A closed tube about a closed flat path: `normal` is perpendicular to its plane.
pub(super) fn hoop(path: &[DVec3], normal: DVec3, radius: f64, sides: usize) -> Solid {
    let n = path.len();
    let mut s = Solid::default();
    let ids: Vec<Vec<u32>> = (0..n)
        .map(|i| {
            let tangent = (path[(i + 1) % n] - path[(i + n - 1) % n]).normalize_or(DVec3::X);
            let out = tangent.cross(normal).normalize_or(DVec3::X);
            let point = |j: usize| {
                let (sin, cos) = (TAU * j as f64 / sides as f64).sin_cos();
                path[i] + radius * (cos * out + sin * normal)
            };
            (0..sides).map(|j| s.vertex(point(j))).collect()
        })
        .collect();
    for i in 0..n {
        let (a, b) = (&ids[i], &ids[(i + 1) % n]);
        for j in 0..sides {
            let k = (j + 1) % sides;
            s.quad([a[j], a[k], b[k], b[j]]);
        }
    }
    s.wound_outwards()
}

/// A vessel about the y axis: its outside from the foot to the lip (radius, height), a wall and a floor of
/// these thicknesses.
pub(super) fn vessel(outer: &[DVec2], wall: f64, floor: f64, sides: usize) -> Solid {
    let mut profile = vec![DVec2::ZERO];
    profile.extend_from_slice(outer);
    let foot = outer.first().map_or(0.0, |p| p.y);
    let inside = outer.iter().rev().map(|p| DVec2::new(p.x - wall, p.y));
    profile.extend(inside.clone().filter(|p| p.y > foot + 1.5 * floor));
    let last = outer.first().map_or(0.0, |p| p.x - wall);
    profile.extend([DVec2::new(last, foot + floor), DVec2::new(0.0, foot + floor)]);
    lathe(&profile, sides)
}

/// A cylinder on the y axis with a bore through it.
pub(super) fn hollow(radius: f64, bore: f64, height: f64, sides: usize, rows: usize) -> Solid {
    let column = (0..=rows).map(|i| height * i as f64 / rows as f64);
    let outside = column.clone().map(|y| DVec2::new(radius, y));
    let inside = column.rev().map(|y| DVec2::new(bore, y));
    let section: Vec<DVec2> = outside.chain(inside).collect();
    let mut s = Solid::default();
    let ids: Vec<Vec<u32>> = (0..sides)
        .map(|i| {
            let (sin, cos) = (TAU * i as f64 / sides as f64).sin_cos();
            section.iter().map(|p| s.vertex(DVec3::new(p.x * cos, p.y, -p.x * sin))).collect()
        })
        .collect();
    for i in 0..sides {
        let (a, b) = (&ids[i], &ids[(i + 1) % sides]);
        for j in 0..section.len() {
            let k = (j + 1) % section.len();
            s.quad([a[j], b[j], b[k], a[k]]);
        }
    }
    s.wound_outwards()
}
