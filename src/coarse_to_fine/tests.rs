//! What a proxy finds comes back whole: tubes, tori, noise.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::carry::spread;
use super::*;
use crate::charts;
use crate::contract::Winding;
use crate::device::Seeded;
use crate::flatten::quality;
use crate::mesh::{ProxySize, Scene, condition, proxy};

const SIZE: ProxySize = ProxySize { dense: 4_000, coarse: 1_500 };

fn conditioned(scene: &Scene) -> Surface {
    condition(scene, Winding::Surface, &Run::quiet()).unwrap().surface
}

/// A grid of `m` × `n` cells wrapped round both ways or one, its vertices shaken by so many mean edges.
fn wrapped(m: u32, n: u32, closed: bool, noise: f64, at: impl Fn(f64, f64) -> DVec3) -> Surface {
    let rows = if closed { n } else { n + 1 };
    let mut random = Seeded::new(7, 0);
    let mut positions = Vec::new();
    for (j, i) in (0..rows).flat_map(|j| (0..m).map(move |i| (j, i))) {
        let (u, v) = (f64::from(i) / f64::from(m), f64::from(j) / f64::from(n));
        let edge = at(u, v).distance(at(u + 1.0 / f64::from(m), v));
        let mut shake = || 2.0 * random.unit_f64() - 1.0;
        positions.push(at(u, v) + noise * edge * DVec3::new(shake(), shake(), shake()));
    }
    let vertex = |i: u32, j: u32| j % rows * m + i % m;
    let cells = (0..n).flat_map(|j| (0..m).map(move |i| (i, j)));
    let faces = cells.flat_map(|(i, j)| {
        let [a, b, c, d] =
            [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| vertex(i, j));
        [[a, b, c], [a, c, d]]
    });
    conditioned(&Scene::from_triangles(positions, faces.collect()))
}

fn torus(noise: f64) -> Surface {
    wrapped(120, 50, true, noise, |u, v| {
        let ring = DVec2::from_angle(TAU * u);
        let tube = DVec2::from_angle(TAU * v);
        (ring * (1.0 + 0.35 * tube.x)).extend(0.35 * tube.y)
    })
}

fn tube(noise: f64) -> Surface {
    wrapped(80, 60, false, noise, |u, v| DVec2::from_angle(TAU * u).extend(4.0 * v))
}

/// The charts of a surface by way of its proxy: of all its faces, each once, each proved.
fn carried(fine: &Surface) -> (Vec<Chart>, Vec<Chart>) {
    let (run, options) = (Run::quiet(), ChartOptions { distortion_bound: 0.01, pinches: true });
    let proxy = proxy(fine, SIZE, &run).unwrap().unwrap();
    let one = vec![0; proxy.surface.face_count()];
    let labels = labels(fine, &proxy, &one);
    assert!(labels.iter().all(|&l| l == 0));
    let coarse = charts::build(&proxy.surface, &one, &options, &run).unwrap();
    let charts = charts(fine, &proxy, coarse.clone(), [&labels, &one], &options, &run).unwrap();
    let mut faces: Vec<u32> = charts.iter().flat_map(|c| c.faces.iter().copied()).collect();
    faces.sort_unstable();
    assert_eq!(faces, (0..fine.face_count() as u32).collect::<Vec<_>>());
    for chart in &charts {
        assert!(charts::is_sound(&chart.disk, &chart.cut_map, 0.0));
        for (&f, triangle) in chart.faces.iter().zip(&chart.disk.triangles) {
            let own = triangle.map(|v| chart.vertices[v as usize]);
            assert_eq!(own, fine.triangles[f as usize]);
        }
    }
    (coarse, charts)
}

fn energy(charts: &[Chart]) -> f64 {
    let sum =
        |of: &dyn Fn(&Chart) -> f64| charts.iter().map(|c| of(c) * c.disk.area()).sum::<f64>();
    sum(&|c| quality(&c.disk, &c.cut_map).mean - 1.0) / sum(&|_| 1.0)
}

#[test]
fn a_tube_comes_back_with_its_one_cut() {
    let (coarse, charts) = carried(&tube(0.0));
    assert_eq!((coarse.len(), charts.len()), (1, 1));
    assert!(energy(&charts) < 2e-3, "{}", energy(&charts));
}

#[test]
fn noise_does_not_shatter() {
    for fine in [tube(0.1), torus(0.0), torus(0.1)] {
        let (coarse, charts) = carried(&fine);
        // A chart that overlaps itself by a hair is divided.
        assert!(charts.len() <= 3 * coarse.len(), "{} {}", coarse.len(), charts.len());
        assert!(energy(&charts) < 0.03, "{}", energy(&charts));
        let carried = |c: &&Chart| c.start_kind == charts::StartKind::Prolonged;
        let area: f64 = charts.iter().filter(carried).map(|c| c.disk.area()).sum();
        assert!(area > 0.95 * fine.area());
    }
}

#[test]
fn what_is_not_dense_stays_as_it_was_cut() {
    // A torus, and far from it a plate of 800 faces in two halves.
    let mut torus = torus(0.0);
    let plate = wrapped(400, 1, false, 0.0, |u, v| DVec3::new(400.0 * u, 9.0, v));
    let positions: Vec<DVec3> = torus.positions.drain(..).chain(plate.positions).collect();
    let base = (positions.len() - 800) as u32;
    let plate: Vec<[u32; 3]> = plate.triangles.iter().map(|t| t.map(|v| v + base)).collect();
    let faces = [torus.triangles, plate].concat();
    let fine = conditioned(&Scene::from_triangles(positions, faces));
    let (run, options) = (Run::quiet(), ChartOptions { distortion_bound: 0.01, pinches: true });
    let proxy = proxy(&fine, SIZE, &run).unwrap().unwrap();
    // The halves end in a zigzag that no cut would leave.
    let ends = |f: u32| match fine.origins[f as usize].face {
        f if f < 12_000 => 0,
        f => 1 + u32::from(f % 4 > 1),
    };
    let coarse: Vec<u32> = proxy.left_of.iter().map(|&f| ends(f)).collect();
    let carried = labels(&fine, &proxy, &coarse);
    assert_eq!(carried, (0..fine.face_count() as u32).map(ends).collect::<Vec<_>>());
    let cut = charts::build(&proxy.surface, &coarse, &options, &run).unwrap();
    let charts = charts(&fine, &proxy, cut.clone(), [&carried, &coarse], &options, &run).unwrap();
    for chart in cut.iter().filter(|c| c.part > 0) {
        let faces: Vec<u32> = chart.faces.iter().map(|&f| proxy.left_of[f as usize]).collect();
        let same = charts.iter().find(|c| c.faces == faces).unwrap();
        assert_eq!((&same.disk, &same.cut_map), (&chart.disk, &chart.cut_map));
    }
}

#[test]
fn every_face_of_a_part_gets_a_label() {
    let fine = tube(0.0);
    let parts: Vec<u32> =
        (0..fine.face_count() as u32).map(|f| [0, 1, NONE][f as usize % 3]).collect();
    let labels = vec![NONE; parts.len()];
    let given = spread(&fine, labels, &parts, |_, _| false, |part| 7 + part);
    for (&label, &part) in given.iter().zip(&parts) {
        assert_eq!(label, if part == NONE { NONE } else { 7 + part });
    }
}

#[test]
fn the_same_at_any_number_of_threads() {
    let fine = torus(0.1);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| carried(&fine).1)
    };
    assert_eq!(with(1), with(3));
}
