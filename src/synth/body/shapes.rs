//! The scanned bodies, about a metre each, y up. Proportions are drawn by eye; the knot is the trefoil in
//! its usual parameters (sin t + 2 sin 2t, cos t - 2 cos 2t, -sin 3t). Limbs, walls and gaps are
//! thick enough that 5,000 triangles still find their way round each.

use std::f64::consts::TAU;

use glam::{DQuat, DVec2, DVec3};

use super::field::Group;

const fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// A palm of metacarpals, four fingers of three phalanges, a thumb, a wrist.
pub(super) fn hand() -> Vec<Group> {
    // Knuckle, its radius, the turn sideways in degrees, lengths and radius of the finger.
    let fingers = [
        (v(-0.180, 0.500, 0.000), 0.070, 13.0, [0.190, 0.125, 0.090], 0.047),
        (v(-0.060, 0.530, 0.014), 0.074, 3.5, [0.210, 0.140, 0.095], 0.049),
        (v(0.060, 0.505, 0.010), 0.070, -6.0, [0.195, 0.130, 0.092], 0.046),
        (v(0.172, 0.445, -0.010), 0.062, -17.0, [0.150, 0.100, 0.080], 0.041),
    ];
    let mut palm = Group::new(0.06, 0.0).chain(&[
        (v(0.0, -0.17, -0.02), 0.105),
        (v(0.0, 0.0, -0.01), 0.088),
        (v(0.0, 0.12, 0.0), 0.095),
    ]);
    let mut groups = vec![];
    for (knuckle, round, turn, lengths, radius) in fingers {
        let root = v(0.42 * knuckle.x, 0.10, 0.0);
        palm = palm.chain(&[(root, 0.082), (root.lerp(knuckle, 0.6), 0.074), (knuckle, round)]);
        let (mut at, mut bend) = (knuckle, 8.0_f64);
        let mut balls = vec![(at, 1.12 * radius)];
        for (length, thin) in lengths.into_iter().zip([1.0, 0.92, 0.84]) {
            let sideways = DQuat::from_rotation_z(f64::to_radians(turn));
            let way = sideways * DQuat::from_rotation_x(bend.to_radians()) * DVec3::Y;
            balls.push((at + 0.5 * length * way, 0.92 * thin * radius));
            at += length * way;
            balls.push((at, thin * radius));
            bend += 15.0;
        }
        groups.push(Group::new(0.02, 0.03).chain(&balls));
    }
    let thumb = [
        (v(-0.07, 0.13, 0.03), 0.085),
        (v(-0.19, 0.25, 0.07), 0.070),
        (v(-0.265, 0.325, 0.085), 0.058),
        (v(-0.315, 0.390, 0.095), 0.050),
        (v(-0.365, 0.455, 0.105), 0.053),
        (v(-0.400, 0.515, 0.110), 0.045),
        (v(-0.420, 0.560, 0.110), 0.040),
    ];
    groups.insert(0, palm);
    groups.push(Group::new(0.02, 0.06).chain(&thumb));
    groups
}

/// A four-legged animal that looks along x.
pub(super) fn animal() -> Vec<Group> {
    let trunk = Group::new(0.08, 0.0).chain(&[
        (v(-0.32, 0.57, 0.0), 0.135),
        (v(-0.05, 0.55, 0.0), 0.140),
        (v(0.25, 0.56, 0.0), 0.165),
    ]);
    let neck = [(v(0.28, 0.62, 0.0), 0.125), (v(0.42, 0.80, 0.0), 0.085)];
    let head = [
        (v(0.43, 0.85, 0.0), 0.095),
        (v(0.52, 0.84, 0.0), 0.085),
        (v(0.58, 0.81, 0.0), 0.056),
        (v(0.67, 0.785, 0.0), 0.050),
    ];
    let tail = [
        (v(-0.42, 0.62, 0.0), 0.050),
        (v(-0.54, 0.64, 0.0), 0.036),
        (v(-0.63, 0.72, 0.0), 0.033),
        (v(-0.66, 0.83, 0.0), 0.028),
    ];
    let mut groups = vec![
        trunk,
        Group::new(0.0, 0.08).chain(&neck),
        Group::new(0.05, 0.06).chain(&head),
        Group::new(0.02, 0.05).chain(&tail),
    ];
    for side in [-1.0, 1.0] {
        let at = |x: f64, y: f64, z: f64| v(x, y, side * z);
        let ear = [(at(0.40, 0.91, 0.055), 0.042), (at(0.375, 1.01, 0.095), 0.028)];
        let front = [
            (at(0.25, 0.50, 0.085), 0.100),
            (at(0.24, 0.27, 0.115), 0.052),
            (at(0.25, 0.07, 0.120), 0.042),
            (at(0.30, 0.042, 0.122), 0.044),
        ];
        let hind = [
            (at(-0.32, 0.53, 0.080), 0.120),
            (at(-0.26, 0.31, 0.115), 0.068),
            (at(-0.37, 0.20, 0.120), 0.044),
            (at(-0.35, 0.06, 0.120), 0.041),
            (at(-0.30, 0.042, 0.122), 0.044),
        ];
        groups.push(Group::new(0.0, 0.04).chain(&ear));
        groups.push(Group::new(0.03, 0.06).chain(&front));
        groups.push(Group::new(0.03, 0.06).chain(&hind));
    }
    groups
}

/// An open vessel: the middle of its floor and wall, turned about the axis.
pub(super) fn vase() -> Vec<Group> {
    // Radius, height and half thickness; a Catmull–Rom curve runs through them.
    let points = [
        [0.0, 0.06, 0.045],
        [0.11, 0.06, 0.045],
        [0.19, 0.15, 0.042],
        [0.24, 0.33, 0.038],
        [0.20, 0.54, 0.036],
        [0.115, 0.72, 0.035],
        [0.115, 0.83, 0.034],
        [0.17, 0.93, 0.034],
    ]
    .map(DVec3::from);
    // Mirrored at the axis, so that the floor is level there.
    let point = |i: isize| match i {
        ..0 => points[1] * v(-1.0, 1.0, 1.0),
        _ => points[(i as usize).min(points.len() - 1)],
    };
    let mut balls = vec![];
    for i in 0..points.len() as isize - 1 {
        let [a, b, c, d] = [point(i - 1), point(i), point(i + 1), point(i + 2)];
        for step in 0..8 {
            let t = f64::from(step) / 8.0;
            let cubic = (3.0 * b - a - 3.0 * c + d) * t + (2.0 * a - 5.0 * b + 4.0 * c - d);
            balls.push(b + 0.5 * t * (c - a + t * cubic));
        }
    }
    balls.push(points[points.len() - 1]);
    let balls: Vec<_> = balls.iter().map(|b| (DVec2::new(b.x.max(0.0), b.y), b.z)).collect();
    vec![Group::new(0.0, 0.0).revolved(&balls)]
}

/// A cup with a wall and a handle.
pub(super) fn mug() -> Vec<Group> {
    let wall = 0.05;
    let middle = [(0.0, wall), (0.3, wall), (0.34, 0.08), (0.35, 0.4), (0.36, 0.85)];
    let cup: Vec<_> = middle.iter().map(|&p| (DVec2::from(p), wall)).collect();
    let turn = |k: i32| {
        let (sin, cos) = (TAU * (f64::from(k) / 16.0 - 0.25)).sin_cos();
        (v(0.34 + 0.22 * cos, 0.46 + 0.24 * sin, 0.0), 0.045)
    };
    let handle: Vec<_> = (0..=8).map(turn).collect();
    vec![Group::new(0.0, 0.0).revolved(&cup), Group::new(0.0, 0.04).chain(&handle)]
}

/// A tube along a trefoil.
pub(super) fn knot() -> Vec<Group> {
    let (pieces, a_group) = (192, 6);
    let ball = |i: i32| {
        let t = TAU * f64::from(i) / f64::from(pieces);
        let (x, y) = (t.sin() + 2.0 * (2.0 * t).sin(), t.cos() - 2.0 * (2.0 * t).cos());
        (0.16 * v(x, y + 3.4, -1.1 * (3.0 * t).sin()), 0.072)
    };
    (0..pieces / a_group)
        .map(|g| (g * a_group..=(g + 1) * a_group).map(ball).collect::<Vec<_>>())
        .map(|balls| Group::new(0.0, 0.0).chain(&balls))
        .collect()
}

/// Three rings in a bent row, each grown together with the next.
pub(super) fn genus3() -> Vec<Group> {
    let (ring, tube) = (0.15, 0.062);
    [(v(-0.28, 0.26, 0.0), -0.25), (v(0.0, 0.36, 0.0), 0.0), (v(0.28, 0.26, 0.0), 0.25)]
        .map(|(centre, turn)| {
            let axis = DQuat::from_rotation_y(turn) * DVec3::Z;
            Group::new(0.0, 0.06).torus(centre, axis, ring, tube)
        })
        .into()
}

/// Seat, legs with stretchers, a back of two posts and a panel: four handles.
pub(super) fn chair() -> Vec<Group> {
    let seat = v(0.25, 0.034, 0.24);
    let mut groups =
        vec![Group::new(0.0, 0.0).block(v(0.0, 0.46, 0.0), DQuat::IDENTITY, seat, 0.03)];
    let foot = |x: f64, z: f64| v(0.235 * x, 0.034, 0.225 * z);
    let top = |x: f64, z: f64| v(0.19 * x, 0.45, 0.18 * z);
    // Where the stretchers meet the legs.
    let half = |x: f64, z: f64| foot(x, z).lerp(top(x, z), 0.35);
    for x in [-1.0, 1.0] {
        for z in [-1.0, 1.0] {
            groups.push(Group::new(0.0, 0.03).chain(&[(foot(x, z), 0.030), (top(x, z), 0.038)]));
        }
        let side = [(half(x, -1.0), 0.027), (half(x, 1.0), 0.027)];
        let post = [(v(0.20 * x, 0.46, -0.20), 0.036), (v(0.19 * x, 0.99, -0.30), 0.030)];
        groups.push(Group::new(0.0, 0.02).chain(&side));
        groups.push(Group::new(0.0, 0.03).chain(&post));
    }
    let across = |x: f64| 0.5 * (half(x, -1.0) + half(x, 1.0));
    groups.push(Group::new(0.0, 0.02).chain(&[(across(-1.0), 0.027), (across(1.0), 0.027)]));
    let lean = DQuat::from_rotation_x(-(0.10_f64 / 0.53).atan());
    let panel = v(0.20, 0.13, 0.030);
    groups.push(Group::new(0.0, 0.03).block(v(0.0, 0.82, -0.268), lean, panel, 0.025));
    groups
}
