//! What the cut promises, on shapes whose best charts are known.

use std::collections::HashMap;

use glam::{DVec2, DVec3};
use proptest::prelude::*;

use super::limits::ChartLimits;
use super::limits::fit::Fit;
use super::limits::visibility::visibility;
use super::moves::compact::compact;
use super::moves::straighten::straighten;
use super::part_mesh::PartMesh;
use super::patchwork::Patchwork;
use super::scenes::*;
use super::*;
use crate::contract::Run;
use crate::flatten::{Border, certify, quality};
use crate::mesh::{NONE, Surface};

/// Cut everything as one part, and check what every cut must keep.
fn cut(surface: &Surface, bound: f64) -> Vec<Chart> {
    let part_of = vec![0; surface.face_count()];
    let options = ChartOptions { distortion_bound: bound, pinches: true };
    let charts = build(surface, &part_of, &options, &Run::quiet()).unwrap();
    let mut faces: Vec<u32> = charts.iter().flat_map(|c| c.faces.clone()).collect();
    faces.sort_unstable();
    let all: Vec<u32> = (0..surface.face_count() as u32).collect();
    assert_eq!(faces, all, "every face is in one chart");
    for chart in &charts {
        assert!(certify(&chart.disk, &chart.cut_map).is_injective());
        assert!(quality(&chart.disk, &chart.cut_map).mean - 1.0 <= bound + 1e-12);
        for (t, &f) in chart.disk.triangles.iter().zip(&chart.faces) {
            let own = t.map(|v| chart.vertices[v as usize]);
            assert_eq!(own, surface.triangles[f as usize]);
        }
    }
    charts
}

fn energy(charts: &[Chart]) -> f64 {
    charts.iter().map(|c| quality(&c.disk, &c.cut_map).mean - 1.0).fold(0.0, f64::max)
}

#[test]
fn a_box_is_unfolded_without_distortion() {
    let solid = solid_box(1.0, 1.2, 0.9);
    let charts = cut(&beside_a_plate(&solid), 0.01);
    assert!(charts.len() <= 4, "{}", charts.len());
    assert!(energy(&charts) < 1e-9);
    // Alone it falls into a few pieces that fill a page better than a cross.
    let charts = cut(&solid, 0.01);
    assert!((2..=4).contains(&charts.len()), "{}", charts.len());
}

#[test]
fn the_caps_of_a_prism_hang_on_its_side() {
    let charts = cut(&beside_a_plate(&prism(8, 6.0)), 1e-6);
    assert_eq!(charts.len(), 2);
    assert!(energy(&charts) < 1e-9);
}

#[test]
fn a_lone_sheet_stays_whole() {
    for width in [1.0, 2.0] {
        let corners = [(0.0, 0.0), (width, 0.0), (width, 1.0), (0.0, 1.0)];
        let corners = corners.map(|(x, y)| DVec3::new(x, y, 0.0));
        assert_eq!(cut(&quads(corners.to_vec(), &[[0, 1, 2, 3]]), 0.01).len(), 1);
    }
}

#[test]
fn a_neck_that_is_too_thin_is_none() {
    // An edge of 48 is 0.13 of the cap's diameter.
    let charts = cut(&beside_a_plate(&prism(48, 3.0)), 1e-6);
    assert_eq!(charts.len(), 4);
    assert!(charts.iter().any(|c| matches!(c.shape, ChartShape::Tubular { .. })));
}

/// A square plate with a square hole, flat or lifted by `height`.
fn frame(height: impl Fn(f64, f64) -> f64) -> Surface {
    let mut index = HashMap::new();
    let (mut positions, mut sides) = (Vec::new(), Vec::new());
    for (i, j) in (0..6).flat_map(|i| (0..6).map(move |j| (i, j))) {
        if (2..4).contains(&i) && (2..4).contains(&j) {
            continue;
        }
        sides.push([(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(x, y): (i32, i32)| {
            *index.entry((x, y)).or_insert_with(|| {
                let (x, y) = (f64::from(x) - 3.0, f64::from(y) - 3.0);
                positions.push(DVec3::new(x, y, height(x, y)));
                positions.len() as u32 - 1
            })
        }));
    }
    quads(positions, &sides)
}

#[test]
fn a_flat_frame_keeps_its_hole() {
    let charts = cut(&frame(|_, _| 0.0), 0.01);
    assert_eq!(charts.len(), 1);
    assert_eq!(Border::of(&charts[0].disk).loops.len(), 2);
    assert!(energy(&charts) < 1e-12);
}

#[test]
fn a_frame_on_a_cylinder_keeps_its_hole_too() {
    let charts = cut(&frame(|x, _| 0.08 * x * x), 0.01);
    assert_eq!(charts.len(), 1);
    assert_eq!(Border::of(&charts[0].disk).loops.len(), 2);
}

#[test]
fn a_long_rod_is_divided_for_the_page() {
    // 40 long in 60 rings: its unrolled side is six times as long as √area.
    let n = 12u32;
    let rings = 60u32;
    let mut positions = Vec::new();
    for r in 0..=rings {
        for i in 0..n {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / f64::from(n)).sin_cos();
            positions.push(DVec3::new(
                0.2 * cos,
                0.2 * sin,
                40.0 * f64::from(r) / f64::from(rings),
            ));
        }
    }
    let at = |r: u32, i: u32| r * n + i % n;
    let sides: Vec<[u32; 4]> = (0..rings)
        .flat_map(|r| (0..n).map(move |i| [at(r, i), at(r, i + 1), at(r + 1, i + 1), at(r + 1, i)]))
        .collect();
    let rod = quads(positions, &sides);
    let charts = cut(&rod, 0.01);
    let side = rod.area().sqrt();
    assert!((4..=8).contains(&charts.len()), "{}", charts.len());
    for chart in &charts {
        assert!(limits::extent::extent(&chart.cut_map).length < 1.7 * side);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Hills of any shape, with holes: every chart is proved and within the bound, whatever it takes.
    #[test]
    fn rough_sheets_are_cut_within_the_bound(
        heights in prop::collection::vec(-0.8..0.8f64, 81),
        missing in prop::collection::vec(0..64usize, 0..12),
        bound in -4.0..-1.5f64,
    ) {
        let positions = (0..81).map(|i| DVec3::new((i % 9) as f64, (i / 9) as f64, heights[i]));
        let sides: Vec<[u32; 4]> = (0..64u32)
            .filter(|&q| !missing.contains(&(q as usize)))
            .map(|q| q / 8 * 9 + q % 8)
            .map(|a| [a, a + 1, a + 10, a + 9])
            .collect();
        cut(&quads(positions.collect(), &sides), 10f64.powf(bound));
    }
}

#[test]
fn a_jagged_seam_is_moved_straight() {
    // A sheet of 8 × 8 squares, each half dealt to one chart along a comb.
    let n = 8u32;
    let corner = |i: u32| DVec3::new(f64::from(i % (n + 1)), f64::from(i / (n + 1)), 0.0);
    let square = |i: u32| {
        let v = i / n * (n + 1) + i % n;
        [v, v + 1, v + n + 2, v + n + 1]
    };
    let squares: Vec<[u32; 4]> = (0..n * n).map(square).collect();
    let s = quads((0..(n + 1) * (n + 1)).map(corner).collect(), &squares);
    let mesh = PartMesh::new(&s, (0..2 * n * n).collect());
    let reach = |row: u32| if row.is_multiple_of(2) { 3 } else { 5 };
    let chart_of: Vec<u32> =
        (0..2 * n * n).map(|f| u32::from(f / 2 % n >= reach(f / 2 / n))).collect();
    let glued: Vec<bool> = (0..mesh.twin.len())
        .map(|h| mesh.twin[h] != NONE && chart_of[h / 3] == chart_of[mesh.twin[h] as usize / 3])
        .collect();
    let mut work = Patchwork::new(&mesh, chart_of, glued);
    for chart in 0..2 {
        let piece = mesh.cut_open(work.faces[chart as usize].clone(), &work.glued);
        let uv = piece.disk.positions.iter().map(|p| p.truncate()).collect();
        work.place(chart, &piece, &Fit { uv, energy: 0.0, kind: StartKind::Planar });
    }
    straighten(&mut work, &[0, 1], &ChartLimits::new(&s, 0.01), &Run::quiet()).unwrap();
    let seam = |work: &Patchwork| -> f64 {
        let across = |h: &u32| work.across(*h) == Some(1);
        work.rims[0].iter().flatten().filter(|h| across(h)).map(|&h| mesh.length(h)).sum()
    };
    assert!((seam(&work) - f64::from(n)).abs() < 1e-9, "{}", seam(&work));
    assert!(work.energy.iter().all(|&e| e.abs() < 1e-9));
    assert!((work.area.iter().sum::<f64>() - f64::from(n * n)).abs() < 1e-9);
}

#[test]
fn an_angle_of_two_arms_is_divided_where_they_meet_and_a_square_is_not() {
    // A flat L: two arms, 10 long and 1 wide, of unit squares; and a square of as many.
    let l: Vec<(u32, u32)> = (0..10).map(|i| (i, 0)).chain((1..10).map(|j| (0, j))).collect();
    let square: Vec<(u32, u32)> = (0..16).map(|i| (i % 4, i / 4)).collect();
    for (cells, pieces) in [(l, 2), (square, 1)] {
        let corner = |i: u32| DVec3::new(f64::from(i % 11), f64::from(i / 11), 0.0);
        let cell = |&(i, j): &(u32, u32)| {
            let v = 11 * j + i;
            [v, v + 1, v + 12, v + 11]
        };
        let sheets: Vec<[u32; 4]> = cells.iter().map(cell).collect();
        let s = quads((0..121).map(corner).collect(), &sheets);
        let mesh = PartMesh::new(&s, (0..s.face_count() as u32).collect());
        let glued = mesh.twin.iter().map(|&t| t != NONE).collect();
        let mut work = Patchwork::new(&mesh, vec![0; mesh.len()], glued);
        let piece = mesh.cut_open(work.faces[0].clone(), &work.glued);
        // Seen from its front.
        let front = s.normals[0].z.signum();
        let uv = piece.disk.positions.iter().map(|p| DVec2::new(front * p.x, p.y)).collect();
        work.place(0, &piece, &Fit { uv, energy: 0.0, kind: StartKind::Planar });
        let changed = compact(&mut work, &ChartLimits::new(&s, 0.01), &Run::quiet()).unwrap();
        assert_eq!(work.faces.len(), pieces);
        assert_eq!(changed.len(), if pieces > 1 { pieces } else { 0 });
        let left: f64 = work.extent.iter().map(|e| e.rectangle).sum();
        assert!((left - cells.len() as f64).abs() < 1e-9, "{left}: nothing is left empty");
    }
}

#[test]
fn what_stands_in_a_closed_box_is_not_seen() {
    let (outer, inner) = (solid_box(4.0, 4.0, 4.0), solid_box(1.0, 1.0, 1.0));
    let first = outer.positions.len() as u32;
    let moved = inner.positions.iter().map(|p| p + 1.5);
    let positions = outer.positions.iter().copied().chain(moved).collect();
    let triangles = inner.triangles.iter().map(|t| t.map(|v| v + first));
    let s = surface(positions, outer.triangles.iter().copied().chain(triangles).collect());
    let seen = visibility(&s, &Run::quiet()).unwrap().unwrap();
    for (origin, &seen) in s.origins.iter().zip(&seen) {
        assert_eq!(seen, if origin.face < 12 { 1.0 } else { 0.0 });
    }
}

#[test]
fn a_seam_that_was_there_before_is_taken_again() {
    // A wide tube of 24 sides must be cut once along its axis: anywhere, unless there was a seam.
    for column in [5, 17] {
        let mut s = open_tube(24, 4.0);
        let at = |v: u32| s.positions[v as usize];
        let angle = std::f64::consts::TAU * f64::from(column) / 24.0;
        let on = |v: u32| (at(v).x - angle.cos()).hypot(at(v).y - angle.sin()) < 1e-9;
        s.existing_seams = (0..s.twin.len() as u32)
            .map(|h| s.twin[h as usize] != NONE && on(s.from(h)) && on(s.to(h)))
            .collect();
        let charts = cut(&s, 0.01);
        let [chart] = &charts[..] else { panic!("{} charts", charts.len()) };
        let twice = |v: u32| chart.vertices.iter().filter(|&&w| w == v).count() == 2;
        for v in 0..s.positions.len() as u32 {
            assert_eq!(twice(v), on(v), "column {column}, vertex {v}");
        }
    }
}

/// A ring with waves around it.
fn wavy_ring(around: u32, across: u32) -> Surface {
    let at = |i: u32, k: u32| (i % around) * across + k % across;
    let positions = (0..around * across).map(|v| {
        let turn = |i: u32, n: u32| std::f64::consts::TAU * f64::from(i) / f64::from(n);
        let (u, v) = (turn(v / across, around), turn(v % across, across));
        let radius = 0.3 + 0.08 * (5.0 * u).sin() * (2.0 * v).cos();
        let out = DVec2::from_angle(u) * (1.0 + radius * v.cos());
        out.extend(radius * v.sin())
    });
    let cells = (0..around).flat_map(|i| (0..across).map(move |k| (i, k)));
    let quad = |(i, k)| [at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)];
    quads(positions.collect(), &cells.map(quad).collect::<Vec<_>>())
}

#[test]
fn what_is_solved_ahead_of_its_turn_changes_nothing() {
    let surface = wavy_ring(40, 18);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| cut(&surface, 0.02))
    };
    let alone = with(1);
    assert!(alone.len() > 2, "{}", alone.len());
    for threads in [2, 3, 7] {
        assert!(with(threads) == alone, "{threads} threads");
    }
}
