//! Tubes along a curve whose strips are known: rings and springs of given girth, bent more and less.

use std::f64::consts::TAU;

use glam::DVec3;

use super::*;
use crate::charts::scenes;
use crate::mesh::{NONE, Surface};

/// Sections of a tube of a radius about the points of a curve, closed to a ring or open at both ends.
fn tube(centers: &[DVec3], radius: f64, sides: u32, ring: bool) -> Surface {
    let n = centers.len();
    let at = |i: usize| centers[i % n];
    let mut positions = Vec::new();
    for i in 0..n {
        let (before, after) = match ring {
            true => (at(i + n - 1), at(i + 1)),
            false => (at(i.saturating_sub(1)), at((i + 1).min(n - 1))),
        };
        let along = (after - before).normalize();
        let out = along.cross(DVec3::Z).normalize();
        let up = out.cross(along);
        positions.extend((0..sides).map(|j| {
            let (sin, cos) = (TAU * f64::from(j) / f64::from(sides)).sin_cos();
            at(i) + radius * (cos * out + sin * up)
        }));
    }
    let sections = if ring { n } else { n - 1 } as u32;
    let id = |i: u32, j: u32| (i % n as u32) * sides + j % sides;
    let quads: Vec<[u32; 4]> = (0..sections)
        .flat_map(|i| (0..sides).map(move |j| (i, j)))
        .map(|(i, j)| [id(i, j), id(i, j + 1), id(i + 1, j + 1), id(i + 1, j)])
        .collect();
    scenes::quads(positions, &quads)
}

/// A ring of radius 1.
fn ring(radius: f64) -> Surface {
    let centers: Vec<DVec3> = (0..96)
        .map(|i| TAU * f64::from(i) / 96.0)
        .map(|a| DVec3::new(a.cos(), a.sin(), 0.0))
        .collect();
    tube(&centers, radius, 16, true)
}

fn strips(surface: &Surface) -> (Vec<Side>, ChartLimits) {
    let limits = ChartLimits::new(surface, 0.01);
    let mesh = PartMesh::new(surface, (0..surface.face_count() as u32).collect());
    (swept(&mesh, &limits, &Run::quiet()).unwrap(), limits)
}

/// Every face lies in one strip, and each strip has a map within the bound that is no longer than a page.
fn cover(surface: &Surface, strips: &[Side], limits: &ChartLimits) {
    let mut faces: Vec<u32> = strips.iter().flat_map(|s| s.faces.iter().copied()).collect();
    faces.sort_unstable();
    assert_eq!(faces, (0..surface.face_count() as u32).collect::<Vec<u32>>());
    for strip in strips {
        assert!(strip.fit.energy <= limits.bound);
        let extent = crate::charts::limits::extent::extent(&strip.fit.uv);
        assert!(extent.length <= 1.25 * limits.length, "{} of {}", extent.length, limits.length);
    }
}

#[test]
fn a_thin_ring_is_cut_along_one_line_and_across_where_the_page_ends() {
    let surface = ring(0.08);
    let (strips, limits) = strips(&surface);
    cover(&surface, &strips, &limits);
    assert_eq!(strips.len() as f64, (TAU / limits.length).ceil());
    // The line is the shortest way round: on the inside of the bend.
    let mesh = PartMesh::new(&surface, (0..surface.face_count() as u32).collect());
    let cut = strips.iter().flat_map(|s| &s.cut).map(|&h| mesh.surface_half_edge(h));
    for h in cut.filter(|&h| surface.length(h) > 0.04) {
        let p = surface.positions[surface.from(h) as usize];
        assert!(p.truncate().length() < 0.95, "{p}");
    }
}

#[test]
fn a_thick_ring_is_cut_along_two_lines() {
    let surface = ring(0.25);
    let (strips, limits) = strips(&surface);
    cover(&surface, &strips, &limits);
    let pieces = (TAU / limits.length).ceil() as usize;
    assert_eq!(strips.len(), 2 * pieces);
    assert!(strips.iter().all(|s| s.cut.is_empty()), "the line inside the bend is closed");
}

#[test]
fn a_ring_with_an_open_edge_whose_ends_are_closed_is_no_ring() {
    let mut torn = ring(0.1);
    let t = torn.twin[0] as usize;
    (torn.twin[0], torn.twin[t]) = (NONE, NONE);
    assert!(strips(&torn).0.is_empty());
}

#[test]
fn a_spring_is_strips() {
    let centers: Vec<DVec3> = (0..200)
        .map(|i| f64::from(i) / 40.0 * TAU)
        .map(|a| DVec3::new(a.cos(), a.sin(), 0.04 * a))
        .collect();
    let surface = tube(&centers, 0.1, 12, false);
    let (strips, limits) = strips(&surface);
    cover(&surface, &strips, &limits);
    let (length, girth) = (5.0 * TAU, 0.1 * TAU);
    assert!(strips.len() as f64 <= (0.75 * length / girth).sqrt().ceil() + 3.0);
}

#[test]
fn caps_are_no_part_of_a_tube() {
    let centers: Vec<DVec3> = (0..40).map(|i| DVec3::X * f64::from(i) * 0.5).collect();
    let open = tube(&centers, 1.0, 24, false);
    let rim = |x: f64| open.positions.iter().copied().filter(move |p| (p.x - x).abs() < 1e-9);
    let mut positions = open.positions.clone();
    let mut triangles = open.triangles.clone();
    for x in [0.0, 19.5] {
        let mut ends: Vec<DVec3> = rim(x).collect();
        ends.sort_by(|p, q| p.z.atan2(p.y).total_cmp(&q.z.atan2(q.y)));
        let first = positions.len() as u32;
        positions.extend(ends);
        positions.push(DVec3::X * x);
        triangles.extend((0..24).map(|i| [first + i, first + (i + 1) % 24, first + 24]));
    }
    let closed = scenes::surface(positions, triangles);
    let (strips, _) = strips(&closed);
    let faces: usize = strips.iter().map(|s| s.faces.len()).sum();
    assert_eq!(faces, open.face_count());
}

#[test]
fn what_is_no_tube_is_left_alone() {
    for surface in [scenes::solid_box(1.0, 2.0, 3.0), scenes::prism(64, 0.5)] {
        assert!(strips(&surface).0.is_empty());
    }
}
