//! What the cloud promises: evenness by area, denser edges, blue noise, determinism, speed.

use glam::DVec3;

use super::*;
use crate::mesh::{NONE, Surface};
use crate::sampling::farthest_points;

/// A surface of triangles whose half-edges pair by their vertices.
pub(crate) fn surface(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Surface {
    let mut edges = std::collections::BTreeMap::new();
    for (f, t) in (0u32..).zip(&triangles) {
        for k in 0..3u32 {
            edges.insert((t[k as usize], t[(k as usize + 1) % 3]), 3 * f + k);
        }
    }
    let twin = triangles
        .iter()
        .flat_map(|t| (0..3).map(|k| (t[(k + 1) % 3], t[k])))
        .map(|e| edges.get(&e).copied().unwrap_or(NONE))
        .collect();
    let cross = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        (b - a).cross(c - a)
    };
    let n = triangles.len();
    Surface {
        normals: triangles.iter().map(|t| cross(t).normalize_or_zero()).collect(),
        areas: triangles.iter().map(|t| 0.5 * cross(t).length()).collect(),
        twin,
        sheet_mate: vec![NONE; n],
        origins: vec![Default::default(); n],
        diagonal: positions
            .iter()
            .copied()
            .reduce(DVec3::max)
            .unwrap()
            .distance(positions.iter().copied().reduce(DVec3::min).unwrap()),
        names: vec![String::new()],
        positions,
        triangles,
        ..Default::default()
    }
}

/// An n × n grid over the unit square, bent upwards at x > fold by 90°.
fn folded(n: u32, fold: f64) -> Surface {
    let place = |i: u32| f64::from(i) / f64::from(n);
    let positions = (0..=n)
        .flat_map(|j| (0..=n).map(move |i| (i, j)))
        .map(|(i, j)| {
            let x = place(i);
            DVec3::new(x.min(fold), place(j), (x - fold).max(0.0))
        })
        .collect();
    let id = |i: u32, j: u32| j * (n + 1) + i;
    let cells = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
    let triangles = cells
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    surface(positions, triangles)
}

fn counts(surface: &Surface, cloud: &PointCloud) -> Vec<usize> {
    let mut counts = vec![0; surface.face_count()];
    for &f in &cloud.faces {
        counts[f as usize] += 1;
    }
    counts
}

#[test]
fn a_flat_square_is_sampled_evenly() {
    let s = folded(16, 2.0);
    let cloud = sample(&s, SampleCounts { base: 20_000, extra: 0.5 }, 1, &Run::quiet()).unwrap();
    assert_eq!(cloud.len(), 20_000, "no salient edge, no extra point");
    assert!(cloud.sensitivity.iter().all(|&x| x == 0.0));
    // 100 boxes of 200 points; the deviation of a binomial is 14.
    let mut boxes = [0i32; 100];
    for p in &cloud.positions {
        boxes[((p.x * 10.0) as usize).min(9) * 10 + ((p.y * 10.0) as usize).min(9)] += 1;
    }
    assert!(boxes.iter().all(|b| (b - 200).abs() < 60), "{boxes:?}");
    let each = counts(&s, &cloud);
    assert!(each.iter().all(|&n| n == 39 || n == 40), "512 equal faces share 20,000 points");
}

#[test]
fn faces_at_salient_edges_are_denser() {
    let s = folded(16, 0.5);
    let cloud = sample(&s, SampleCounts { base: 20_000, extra: 0.5 }, 1, &Run::quiet()).unwrap();
    let each = counts(&s, &cloud);
    for (f, &n) in each.iter().enumerate() {
        let edge = (0..3).any(|k| s.is_crease(3 * f as u32 + k));
        if edge {
            assert!(n >= 50, "face {f} at the fold has {n} points");
        } else {
            assert!(n <= 40);
        }
    }
    for ((p, x), &f) in cloud.positions.iter().zip(&cloud.sensitivity).zip(&cloud.faces) {
        let away = if p.z > 0.0 { p.z } else { 0.5 - p.x };
        let want = (-0.5 * (away / (0.02 * s.diagonal)).powi(2)).exp();
        let x = f64::from(*x);
        // Beyond the faces at the edge distances run over vertices, which never shortens them.
        assert!(x < want + 1e-6);
        let at_edge = (0..3).any(|k| s.is_crease(3 * f + k));
        assert!(!at_edge || x > want - 1e-6, "{x} instead of {want} at {p}");
    }
}

#[test]
fn extra_points_keep_their_distance() {
    let s = folded(8, 0.5);
    let faces: Vec<u32> = (0..s.face_count() as u32).collect();
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let (cloud, radius) = blue_noise::scatter(&s, &faces, 3000, &mut rng, &Run::quiet()).unwrap();
    assert!(cloud.len() > 2600, "{} points landed", cloud.len());
    for (i, p) in cloud.positions.iter().enumerate() {
        for q in &cloud.positions[..i] {
            assert!(p.distance(*q) >= radius);
        }
    }
}

#[test]
fn every_face_has_a_point_and_one_without_area_has_none() {
    let mut s = folded(8, 0.5);
    s.areas[5] = 0.0;
    // One face a million times smaller than the rest still counts.
    s.areas[7] *= 1e-6;
    let cloud = sample(&s, SampleCounts::dense(s.face_count()), 1, &Run::quiet()).unwrap();
    let each = counts(&s, &cloud);
    assert_eq!(each[5], 0);
    assert!(each.iter().enumerate().all(|(f, &n)| n > 0 || f == 5));
}

#[test]
fn dense_counts_stay_below_the_cap() {
    for faces in [0, 1, 1000, 20_000, 50_000, 150_000, 199_999, 1_000_000] {
        let c = SampleCounts::dense(faces);
        assert!(c.base as f64 * (1.0 + c.extra) <= DENSE_CAP as f64, "{faces}");
        assert!(c.base >= faces.min(DENSE_CAP));
    }
}

#[test]
fn the_seed_decides() {
    let s = folded(8, 0.5);
    let cloud = |seed| sample(&s, SampleCounts::dense(128), seed, &Run::quiet()).unwrap();
    assert_eq!(cloud(1), cloud(1));
    assert_ne!(cloud(1), cloud(2));
}

#[test]
fn farthest_points_spread_out() {
    let s = folded(8, 2.0);
    let cloud = sample(&s, SampleCounts { base: 4096, extra: 0.0 }, 1, &Run::quiet()).unwrap();
    let chosen = farthest_points(&cloud, 256, &Run::quiet()).unwrap();
    assert_eq!(chosen.len(), 256);
    let points = cloud.subset(&chosen).positions;
    let mut least = f64::INFINITY;
    for (i, p) in points.iter().enumerate() {
        for q in &points[..i] {
            least = least.min(p.distance(*q));
        }
    }
    // 256 points in a hexagonal lattice over the unit square are 0.067 apart.
    assert!(least > 0.04, "{least}");
    let all = farthest_points(&cloud, 5000, &Run::quiet()).unwrap();
    assert_eq!(all.len(), 4096);
    let far = |p: &DVec3| points.iter().map(|q| p.distance(*q)).fold(f64::INFINITY, f64::min);
    assert!(cloud.positions.iter().all(|p| far(p) < 0.09));
}

#[test]
fn a_canceled_run_stops() {
    let run = Run::quiet();
    run.cancel.cancel();
    let s = folded(4, 0.5);
    assert!(sample(&s, SampleCounts::dense(32), 1, &run).is_err());
}
