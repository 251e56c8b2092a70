//! T-junctions of all kinds, and what is none.

use glam::DVec3;

use crate::contract::{Run, Winding};
use crate::mesh::condition::{Conditioned, condition};
use crate::mesh::{NONE, Scene, Sides};

/// Quads at these corners, in the plane; a polygon of more is a fan from its first.
fn plane(polygons: &[&[[f64; 2]]]) -> Conditioned {
    told(polygons, |x, y| DVec3::new(x, y, 0.0), false)
}

fn told(polygons: &[&[[f64; 2]]], at: impl Fn(f64, f64) -> DVec3, both: bool) -> Conditioned {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for polygon in polygons {
        let first = positions.len() as u32;
        positions.extend(polygon.iter().map(|&[x, y]| at(x, y)));
        for k in 1..polygon.len() as u32 - 1 {
            triangles.push([first, first + k, first + k + 1]);
            if both {
                triangles.push([first, first + k + 1, first + k]);
            }
        }
    }
    let scene = Scene::from_triangles(positions, triangles);
    condition(&scene, Winding::Surface, &Run::quiet()).unwrap()
}

fn box_of([x, y]: [f64; 2], [w, h]: [f64; 2]) -> [[f64; 2]; 4] {
    [[x, y], [x + w, y], [x + w, y + h], [x, y + h]]
}

/// Junctions, and components.
fn counts(c: &Conditioned) -> (u64, usize) {
    let roots = c.surface.components(|_| true);
    let caps = c.surface.closes.iter().filter(|f| **f != NONE).count();
    assert_eq!(caps as u64, c.surface.repairs.t_junctions);
    (caps as u64, roots.iter().zip(0..).filter(|(root, f)| **root == *f).count())
}

#[test]
fn an_edge_with_a_vertex_on_it_is_closed() {
    let c = plane(&[
        &box_of([0.0, 0.0], [1.0, 1.0]),
        &box_of([1.0, 0.0], [1.0, 0.5]),
        &box_of([1.0, 0.5], [1.0, 0.5]),
    ]);
    assert_eq!(counts(&c), (1, 1));
    assert_eq!(c.surface.repairs.first_faces.t_junctions, Some(0));
    let cap = (0..7).find(|&f| c.surface.is_cap(f)).unwrap();
    let twins = (3 * cap..3 * cap + 3).filter(|&h| c.surface.twin[h as usize] != NONE);
    assert_eq!(twins.count(), 3, "it is closed on all sides");
    let area = c.surface.areas[cap as usize];
    assert!(area > 0.0 && area < 1e-3, "{area}");
    assert!(!c.telling.face.contains(&cap), "no face of the file is one");
}

#[test]
fn many_vertices_and_rows_of_bricks_are_closed() {
    let small: Vec<[[f64; 2]; 4]> =
        (0..7).map(|i| box_of([0.2 * f64::from(i), 1.0], [0.2, 0.3])).collect();
    let wide = box_of([0.0, 0.0], [1.4, 1.0]);
    let all: Vec<&[[f64; 2]]> =
        [&wide[..]].into_iter().chain(small.iter().map(|b| &b[..])).collect();
    assert_eq!(counts(&plane(&all)), (6, 1));
    // Two rows, the upper one set off by half a brick: neither has what the other has.
    let lower = (0..5).map(|i| box_of([f64::from(i), 0.0], [1.0, 0.4]));
    let upper = (0..4).map(|i| box_of([0.5 + f64::from(i), 0.4], [1.0, 0.4]));
    let half = box_of([0.0, 0.4], [0.5, 0.4]);
    let bricks: Vec<[[f64; 2]; 4]> = lower.chain(upper).chain([half]).collect();
    let all: Vec<&[[f64; 2]]> = bricks.iter().map(|b| &b[..]).collect();
    let c = plane(&all);
    assert_eq!(counts(&c).1, 1);
    // What stays open is the outline: 2 × 5 below and above, less the step, and two sides.
    let border = (0..c.surface.twin.len() as u32).filter(|&h| c.surface.twin[h as usize] == NONE);
    let length: f64 = border.map(|h| c.surface.length(h)).sum();
    assert!((length - 11.6).abs() < 0.02, "{length}");
}

#[test]
fn at_a_crease_and_on_two_sides_it_is_closed_too() {
    let parts = [
        box_of([0.0, 0.0], [1.0, 1.0]),
        box_of([1.0, 0.0], [1.0, 0.5]),
        box_of([1.0, 0.5], [1.0, 0.5]),
    ];
    let all: Vec<&[[f64; 2]]> = parts.iter().map(|b| &b[..]).collect();
    let bent = |x: f64, y: f64| DVec3::new(x.min(1.0), y, (x - 1.0).max(0.0));
    let c = told(&all, bent, true);
    assert_eq!(counts(&c), (1, 1));
    let creases = (0..c.surface.twin.len() as u32).filter(|&h| c.surface.is_crease(h)).count();
    assert!(creases >= 2, "the edge bends as it did");
    let sides = Sides::of(&c.surface, &c.telling, true, true);
    assert_eq!(sides.surface.face_count(), 14);
    let caps: Vec<u32> = (0..14).filter(|&f| sides.surface.is_cap(f)).collect();
    assert_eq!(caps.len(), 2);
    let open = |f: &u32| (0..3).any(|k| sides.surface.twin[3 * *f as usize + k] == NONE);
    assert!(!caps.iter().any(open));
}

#[test]
fn a_corner_that_touches_an_edge_is_no_junction() {
    let corner = [[1.0, 0.5], [2.0, 0.2], [2.0, 0.8]];
    let c = plane(&[&box_of([0.0, 0.0], [1.0, 1.0]), &corner]);
    assert_eq!(counts(&c), (0, 2));
}

#[test]
fn a_face_without_area_between_them_changes_nothing() {
    let (long, low, high) = (
        box_of([0.0, 0.0], [1.0, 1.0]),
        box_of([1.0, 0.0], [1.0, 0.5]),
        box_of([1.0, 0.5], [1.0, 0.5]),
    );
    let flat = [[1.0, 0.0], [1.0, 0.5], [1.0, 1.0]];
    assert_eq!(counts(&plane(&[&long, &low, &high, &flat])), (1, 1));
}

#[test]
fn a_thin_face_is_not_turned_over_for_it() {
    // The faces beside the long edge are thinner than a cap would be.
    let thin = |y| box_of([1.0, y], [1e-3, 0.5]);
    let c = plane(&[&box_of([0.0, 0.0], [1.0, 1.0]), &thin(0.0), &thin(0.5)]);
    assert_eq!(counts(&c).0, 0);
}

#[test]
fn hundreds_of_edges_at_one_vertex_are_no_line() {
    let spikes: Vec<[[f64; 2]; 3]> = (1..2_000)
        .map(|i| [[0.0, 0.0], [f64::from(i), 0.0], [f64::from(i), 1.0 + f64::from(i % 7)]])
        .collect();
    let all: Vec<&[[f64; 2]]> = spikes.iter().map(|s| &s[..]).collect();
    assert_eq!(counts(&plane(&all)).0, 0);
}
