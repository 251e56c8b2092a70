//! A proxy keeps shape, topology, borders and labels.

use glam::DVec3;

use super::*;
use crate::contract::Winding;
use crate::mesh::{Scene, condition};

const SIZE: ProxySize = ProxySize { dense: 12_000, coarse: 8_000 };

fn conditioned(scene: &Scene) -> Surface {
    condition(scene, Winding::Surface, &Run::quiet()).unwrap().surface
}

/// A wavy sheet of 2 n² faces.
fn wavy(n: u32) -> Surface {
    let at = |i: u32| f64::from(i) / f64::from(n);
    let positions = (0..(n + 1) * (n + 1)).map(|i| {
        let (x, y) = (at(i % (n + 1)), at(i / (n + 1)));
        DVec3::new(x, y, 0.05 * (9.0 * x).sin() * (7.0 * y).cos())
    });
    let quads = (0..n * n).map(|i| i / n * (n + 1) + i % n);
    let faces = quads.flat_map(|a| [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]);
    let scene = Scene::from_triangles(positions.collect(), faces.collect());
    conditioned(&scene)
}

fn is_sound(p: &Proxy) {
    let s = &p.surface;
    for (h, &t) in (0u32..).zip(&s.twin).filter(|(_, t)| **t != NONE) {
        assert_eq!(s.twin[t as usize], h);
        assert_eq!((s.from(h), s.to(h)), (s.to(t), s.from(t)));
    }
    assert!(s.areas.iter().all(|&a| a > 0.0));
}

#[test]
fn a_few_faces_need_no_proxy() {
    assert!(proxy(&wavy(70), SIZE, &Run::quiet()).unwrap().is_none());
}

#[test]
fn a_sheet_keeps_shape_topology_and_border() {
    let fine = wavy(120);
    let p = proxy(&fine, SIZE, &Run::quiet()).unwrap().unwrap();
    is_sound(&p);
    assert!(p.surface.face_count() <= SIZE.coarse && p.surface.face_count() > SIZE.coarse - 3);
    let edges = p.surface.twin.iter().enumerate().filter(|(h, t)| **t == NONE || *h < **t as usize);
    let vertices = p.surface.positions.len() as i64;
    assert_eq!(vertices - edges.count() as i64 + p.surface.face_count() as i64, 1, "a disk");
    // Every vertex has a place, as near as the waves are flat there.
    for (f, t) in p.corners.iter().enumerate() {
        for (k, &v) in t.iter().enumerate() {
            let Place { face, weights } = p.places[v as usize];
            let corners = p.surface.corners(face as usize);
            let there: DVec3 = corners.iter().zip(weights).map(|(c, w)| *c * f64::from(w)).sum();
            assert!(there.distance(fine.corners(f)[k]) < 2e-3);
        }
    }
    let area = p.surface.area() / fine.area();
    assert!((area - 1.0).abs() < 1e-3, "{area}");
}

#[test]
fn what_the_caller_says_ends_where_it_ended() {
    let mut fine = wavy(120);
    // A disk in the middle.
    let label =
        |f: usize| i32::from(fine.centroid(f).truncate().distance(glam::DVec2::splat(0.5)) < 0.3);
    let labels: Vec<i32> = (0..fine.face_count()).map(label).collect();
    fine.labels = Some(labels.clone());
    let p = proxy(&fine, SIZE, &Run::quiet()).unwrap().unwrap();
    is_sound(&p);
    let coarse = p.surface.labels.as_ref().unwrap();
    for (f, &label) in labels.iter().enumerate() {
        assert_eq!(coarse[p.face[f] as usize], label);
    }
}

#[test]
fn the_same_at_any_number_of_threads() {
    let fine = wavy(100);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| proxy(&fine, SIZE, &Run::quiet()).unwrap().unwrap())
    };
    let (one, three) = (with(1), with(3));
    assert_eq!(one.surface.positions, three.surface.positions);
    assert_eq!((one.face, one.places), (three.face, three.places));
}

#[test]
fn lace_and_what_cannot_be_collapsed_stay_as_they_are() {
    let fine = wavy(120);
    let faces = |keep: &dyn Fn(u32) -> bool| -> Vec<[u32; 3]> {
        (0u32..).zip(&fine.triangles).filter(|(f, _)| keep(*f)).map(|(_, t)| *t).collect()
    };
    let made = |triangles: Vec<[u32; 3]>, labels: Option<Vec<i32>>| {
        let scene = Scene { labels, ..Scene::from_triangles(fine.positions.clone(), triangles) };
        let fine = conditioned(&scene);
        proxy(&fine, SIZE, &Run::quiet()).unwrap()
    };
    // Every tenth cell both ways is a hole, 144 in all; then two only.
    let cell = |f: u32| (f / 2 % 120, f / 240);
    let lace = faces(&|f| cell(f).0 % 10 != 5 || cell(f).1 % 10 != 5);
    assert!(made(lace, None).is_none());
    assert!(made(faces(&|f| ![777, 20_777].contains(&(f / 2))), None).is_some());
    // A label a face leaves nothing that may go.
    let all = faces(&|_| true);
    let labels = (0..all.len() as i32).collect();
    assert!(made(all, Some(labels)).is_none());
}

#[test]
fn a_rough_sheet_gets_a_coarser_proxy() {
    let fine = wavy(120);
    let mut random = crate::device::Seeded::new(3, 0);
    let shaken = fine.positions.iter().map(|p| *p + DVec3::Z * 0.004 * random.unit_f64());
    let scene = Scene::from_triangles(shaken.collect(), fine.triangles.clone());
    let rough = conditioned(&scene);
    let left = |surface| proxy(surface, SIZE, &Run::quiet()).unwrap().unwrap().surface.face_count();
    assert!(left(&rough) <= 4_800 && left(&fine) > 7_990);
}
