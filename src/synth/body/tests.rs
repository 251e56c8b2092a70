//! What every body promises: closed, manifold, the known topology, nearly as many triangles as wanted
//! and never more, the same bytes on any number of threads.

use std::collections::BTreeMap;

use super::marching_cubes::{Grid, Table};
use super::*;

fn plain(kind: BodyKind, triangles: usize) -> Body {
    make(kind, BodyStyle { triangles, ..BodyStyle::default() })
}

fn field(kind: BodyKind) -> Field {
    match form(kind) {
        Form::Scanned(groups) => Field::new(groups),
        Form::Modelled(_) => unreachable!("{kind:?} is modelled"),
    }
}

/// Every edge has its opposite and every vertex one fan. Returns the Euler characteristic and the
/// number of components.
fn topology(body: &Body) -> (i64, usize) {
    let mut next: Vec<((u32, u32), u32)> = vec![];
    for t in &body.triangles {
        next.extend((0..3).map(|k| ((t[k], t[(k + 1) % 3]), t[(k + 2) % 3])));
    }
    next.sort_unstable();
    assert!(next.windows(2).all(|w| w[0].0 != w[1].0), "an edge stands twice");
    let across = |a: u32, b: u32| {
        let at = next.binary_search_by_key(&(a, b), |e| e.0);
        at.map(|i| next[i].1).expect("an edge is open")
    };
    let n = body.positions.len();
    let mut corners = vec![(0usize, 0u32); n];
    for &((a, b), _) in &next {
        across(b, a);
        corners[a as usize] = (corners[a as usize].0 + 1, b);
    }
    let (mut seen, mut components) = (vec![false; n], 0);
    for root in 0..n {
        let mut stack = vec![root];
        components += usize::from(!seen[root]);
        while let Some(v) = stack.pop() {
            if std::mem::replace(&mut seen[v], true) {
                continue;
            }
            let (count, first) = corners[v];
            assert!(count > 2, "a vertex without a fan");
            let (mut at, mut steps) = (first, 0);
            loop {
                stack.push(at as usize);
                at = across(v as u32, at);
                steps += 1;
                if at == first {
                    break;
                }
            }
            assert_eq!(steps, count, "a vertex has two fans");
        }
    }
    (n as i64 - body.triangles.len() as i64 / 2, components)
}

fn volume(body: &Body) -> f64 {
    let at = |v: u32| body.positions[v as usize];
    body.triangles.iter().map(|t| at(t[0]).dot(at(t[1]).cross(at(t[2]))) / 6.0).sum()
}

fn euler(kind: BodyKind) -> i64 {
    match kind {
        BodyKind::Hand | BodyKind::Animal | BodyKind::Vase => 2,
        BodyKind::Knot | BodyKind::Mug => 0,
        BodyKind::Genus3 => -4,
        // Four handles: two sides and the front of the stretchers' H, one below the back.
        BodyKind::FusedChair => -6,
        _ => unreachable!("{kind:?} is modelled"),
    }
}

#[test]
fn bodies_are_closed_manifolds_of_known_topology_and_size() {
    for kind in BodyKind::SCANNED {
        for wanted in [kind.fewest(), 5_000, 7_001, 20_000, 60_000] {
            let body = plain(kind, wanted);
            let n = body.triangles.len();
            assert_eq!(topology(&body), (euler(kind), 1), "{kind:?} of {wanted}");
            assert!(n <= wanted && n as f64 >= 0.97 * wanted as f64, "{kind:?}: {n} of {wanted}");
            assert!(volume(&body) > 0.01, "{kind:?}");
            let low = body.positions.iter().fold(DVec3::INFINITY, |m, p| m.min(*p));
            let high = body.positions.iter().fold(DVec3::NEG_INFINITY, |m, p| m.max(*p));
            let extent = (high - low).max_element();
            assert!((0.8..1.5).contains(&extent), "{kind:?}: {extent} m");
        }
    }
}

#[test]
fn modelled_bodies_are_manifolds_of_known_topology_and_size() {
    for kind in BodyKind::MODELLED {
        for wanted in [kind.fewest(), 5_000, 20_000] {
            let body = plain(kind, wanted);
            let n = body.triangles.len();
            assert!(n <= wanted && n as f64 >= 0.8 * wanted as f64, "{kind:?}: {n} of {wanted}");
            let extent = body.size().max_element();
            assert!((0.8..1.5).contains(&extent), "{kind:?}: {extent} m");
            let expected = match kind {
                BodyKind::Hose | BodyKind::Cloth | BodyKind::Terrain => None,
                BodyKind::Spring | BodyKind::Bolt => Some((2, 1)),
                BodyKind::Wheel => Some((2 * 17, 18)),
                BodyKind::Figure => Some((2 * 15, 15)),
                _ => Some((0, 1)),
            };
            let Some(expected) = expected else { continue };
            assert_eq!(topology(&body), expected, "{kind:?} of {wanted}");
            assert!(volume(&body) > 0.001, "{kind:?}");
        }
    }
}

#[test]
fn fields_are_lipschitz_and_their_parts_stand_for_them() {
    for kind in BodyKind::SCANNED {
        let field = field(kind);
        let (size, step) = (field.high - field.low, 0.01);
        for i in 0..20_000 {
            let t = f64::from(i);
            let unit = DVec3::new(t * 0.754_877, t * 0.569_840, t * 0.438_579).fract();
            let p = field.low + size * (1.2 * unit - 0.1);
            let way = DVec3::new((t * 1.3).sin(), (t * 2.1).cos(), (t * 0.7).sin());
            let q = p + step * way.normalize_or(DVec3::X);
            let change = (field.distance(p) - field.distance(q)).abs();
            assert!(change <= step * (1.0 + 1e-9), "{kind:?} at {p}: {change}");
            let near = field.near(q, step);
            assert_eq!(near.distance(p), field.distance(p), "{kind:?} at {p}");
        }
    }
}

/// A field of random signs meets every case of the table with every neighbour.
#[test]
fn every_case_closes_with_every_neighbour() {
    let table = Table::new();
    let mut state = 1u64;
    for round in 0..40 {
        let side = 9usize;
        let signs: Vec<bool> = (0..side * side * side)
            .map(|i| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                let rim = [i % side, i / side % side, i / side / side];
                rim.iter().all(|&c| c > 0 && c + 1 < side) && (state >> 33) % 40 > round
            })
            .collect();
        let mut numbers = BTreeMap::new();
        let mut triangles = vec![];
        let inside = |p: [usize; 3]| signs[p[0] + side * (p[1] + side * p[2])];
        for i in 0..(side - 1) * (side - 1) * (side - 1) {
            let n = side - 1;
            let base = [i % n, i / n % n, i / n / n];
            let corner = |c: usize| [base[0] + (c & 1), base[1] + (c >> 1 & 1), base[2] + (c >> 2)];
            let case: usize = (0..8).filter(|&c| inside(corner(c))).map(|c| 1 << c).sum();
            for t in &table.cases[case] {
                triangles.push(t.map(|e| {
                    let (from, axis) = table.edges[e as usize];
                    let next = numbers.len() as u32;
                    *numbers.entry((corner(from), axis)).or_insert(next)
                }));
            }
        }
        let body = Body { positions: vec![DVec3::ZERO; numbers.len()], triangles };
        let (euler, _) = topology(&body);
        assert_eq!(euler % 2, 0);
    }
}

#[test]
fn no_diagonal_lies_in_a_face_of_the_cube() {
    let table = Table::new();
    let on_face = |e: u8, f: usize| {
        let (from, axis) = table.edges[e as usize];
        axis != f / 2 && from >> (f / 2) & 1 == f % 2
    };
    for triangles in &table.cases {
        let mut sides = vec![];
        for t in triangles {
            sides.extend((0..3).map(|k| (t[k], t[(k + 1) % 3])));
        }
        let inner = sides.iter().filter(|&&(a, b)| sides.contains(&(b, a)));
        for &(a, b) in inner {
            assert!(!(0..6).any(|f| on_face(a, f) && on_face(b, f)), "{triangles:?}");
        }
    }
}

#[test]
fn counting_and_meshing_agree() {
    let (field, table) = (field(BodyKind::Hand), Table::new());
    let grid = Grid::new(&field, &table, 0.017);
    assert_eq!(grid.count(), grid.surface().1.len());
}

#[test]
fn noise_has_the_deviation_asked_for() {
    let clean = plain(BodyKind::Animal, 20_000);
    let edge = noise::mean_edge(&clean.positions, &clean.triangles);
    for (noise_kind, degrees) in [(NoiseKind::Normal, 1.0), (NoiseKind::Isotropic, 3.0)] {
        let style = BodyStyle { triangles: 20_000, noise: 0.2, noise_kind, ..BodyStyle::default() };
        let noisy = make(BodyKind::Animal, style);
        assert_eq!(noisy.triangles, clean.triangles);
        let moved = |(p, q): (&DVec3, &DVec3)| p.distance_squared(*q);
        let sum: f64 = clean.positions.iter().zip(&noisy.positions).map(moved).sum();
        let deviation = (sum / degrees / clean.positions.len() as f64).sqrt() / edge;
        assert!((deviation - 0.2).abs() < 0.01, "{noise_kind:?}: {deviation}");
        assert_ne!(noisy, make(BodyKind::Animal, BodyStyle { seed: 2, ..style }));
    }
}

#[test]
fn copies_share_the_triangles_and_do_not_touch() {
    let style = BodyStyle { triangles: 60_000, copies: 7, ..BodyStyle::default() };
    let body = make(BodyKind::Genus3, style);
    assert_eq!(topology(&body), (7 * -4, 7));
    let n = body.triangles.len();
    assert!((58_200..=60_000).contains(&n), "{n}");
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let style = BodyStyle { triangles: 30_000, noise: 0.1, ..BodyStyle::default() };
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| make(BodyKind::Hand, style))
    };
    assert_eq!(with(1), with(3));
}
