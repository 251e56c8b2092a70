//! Figures of objects whose figures are known.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::fixtures;
use super::fixtures::{cube, grid, surface, uvs};
use super::{Measured, MeasuredFigures, measure, packing_efficiency};
use crate::contract::{Budget, Cancel, Run};
use crate::mesh::{NONE, Surface};

/// Everything in one part.
fn measured<'a>(
    surface: &'a Surface,
    uvs: &'a [[[f32; 2]; 3]],
    chart_of: &'a [u32],
    part_of: &'a [u32],
    boundary_labels: Option<&'a [i32]>,
) -> Measured<'a> {
    Measured { boundary_labels, ..fixtures::measured(surface, uvs, chart_of, part_of) }
}

fn one_chart(surface: &Surface, uvs: &[[[f32; 2]; 3]]) -> MeasuredFigures {
    let zeros = vec![0; surface.face_count()];
    measure(&measured(surface, uvs, &zeros, &zeros, None), &Run::quiet()).unwrap()
}

#[track_caller]
fn near(a: impl Into<Option<f64>>, b: f64, tolerance: f64) {
    let a = a.into().expect("a figure");
    assert!((a - b).abs() <= tolerance, "{a} is not {b}");
}

#[test]
fn a_square_has_no_distortion_and_no_seam() {
    let (s, p) = grid(4, 4, |x, y| DVec3::new(3.0 * x, 0.0, -3.0 * y));
    let uv = uvs(&p, |q| q);
    let zeros = [0; 32];
    let input = measured(&s, &uv, &zeros, &zeros, None);
    let figures = measure(&input, &Run::quiet()).unwrap();
    let all = [&figures.atlas, &figures.parts[0], &figures.charts[0]];
    for f in all {
        near(f.quasi_conformal.map(|x| x.max), 1.0, 1e-9);
        near(f.symmetric_dirichlet, 1.0, 1e-12);
        near(f.symmetric_dirichlet_chart, 1.0, 1e-12);
        near(f.area_distortion.map(|x| x.p95), 1.0, 1e-9);
        near(f.area_distortion_chart.map(|x| x.mean), 1.0, 1e-9);
        near(f.stretch_l2, 1.0, 1e-9);
        near(f.stretch_linf, 1.0, 1e-9);
        near(f.texel_density.map(|x| x.mean), 1024.0 / 3.0, 1e-9);
        near(f.texel_density.map(|x| x.cv), 0.0, 1e-7);
        near(f.partuv_angular, 1.0, 1e-9);
        near(f.partuv_area.map(|x| x.worst_chart), 1.0, 1e-9);
        near(f.paper.conformality.map(|x| x.worst_rotation), 0.0, 1e-9);
        near(f.paper.internal_consistency.map(|x| x.geodesic), 0.0, 1e-12);
        near(f.paper.internal_consistency.map(|x| x.euclidean), 0.0, 1e-12);
        near(f.paper.boundary_compactness.map(|x| x.isoperimetric), PI / 4.0, 1e-9);
        near(f.paper.texture_distortion, 0.0, 1e-9);
        near(f.paper.mean_texture_error, 0.0, 1e-9);
        near(f.paper.total_seam_length, 0.0, 0.0);
        assert_eq!((f.seam_edges, f.paper.seam_count, f.paper.island_count), (0, 0, 1));
        assert_eq!((f.boundary_alignment, f.avoidable_seam, f.paper.chamfer), (None, None, None));
    }
    let packing = packing_efficiency(&input, 512 * 1024);
    near(packing.covered, 1.0, 1e-9);
    near(packing.delivered, 0.5, 0.0);
}

#[test]
fn a_double_stretch_is_seen_as_one() {
    let (s, p) = grid(4, 4, |x, y| DVec3::new(x, y, 0.0));
    let f = one_chart(&s, &uvs(&p, |[u, v]| [u, 0.5 * v])).atlas;
    near(f.quasi_conformal.map(|x| x.mean), 2.0, 1e-9);
    near(f.symmetric_dirichlet, 1.25, 1e-9);
    near(f.area_distortion.map(|x| x.max), 1.0, 1e-9);
    near(f.stretch_l2, 1.25f64.sqrt(), 1e-9);
    near(f.stretch_linf, 2f64.sqrt(), 1e-9);
    near(f.partuv_angular, 1.0, 1e-9);
    near(f.paper.conformality.map(|x| x.shipped), 0.0, 1e-9);
    near(f.paper.conformality.map(|x| x.worst_rotation), 0.6, 1e-9);
    let (a, b) = (2f64.sqrt() - 1.0, 1.0 - 0.5f64.sqrt());
    near(f.paper.texture_distortion, 0.5 * (a + b), 1e-9);
    near(f.paper.mean_texture_error, a.hypot(b), 1e-9);
    // Turned by 45°, the axes are seen as they are.
    let turned = uvs(&p, |[u, v]| [0.5 * u - 0.25 * v + 0.3, 0.5 * u + 0.25 * v]);
    let t = one_chart(&s, &turned).atlas;
    near(t.paper.conformality.map(|x| x.shipped), 0.6, 1e-5);
    near(t.partuv_angular, 0.4, 1e-5);
}

#[test]
fn an_unrolled_cylinder_is_isometric_with_one_straight_seam() {
    let k = 48;
    let place = |x: f64, y: f64| {
        let (sin, cos) = (TAU * x).sin_cos();
        DVec3::new(cos, sin, 2.0 * y)
    };
    let (s, p) = grid(k, 8, place);
    let around = 2.0 * (PI / f64::from(k)).sin() * f64::from(k);
    let f = one_chart(&s, &uvs(&p, |[u, v]| [u, v * 2.0 / around])).atlas;
    near(f.symmetric_dirichlet, 1.0, 1e-9);
    near(f.quasi_conformal.map(|x| x.max), 1.0, 1e-5);
    assert_eq!((f.seam_edges, f.paper.seam_count), (8, 1));
    near(f.seam_length.map(|x| x.per_sqrt_area), 2.0 / (around * 2.0).sqrt(), 1e-9);
    near(f.seam_length.map(|x| x.per_diagonal), 2.0 / s.diagonal, 1e-9);
    near(f.avoidable_seam, 1.0, 1e-9);
    let c = f.paper.internal_consistency.unwrap();
    near(c.geodesic, 0.0, 1e-9);
    assert!(c.euclidean > 0.01, "the two sides of the cut are near in 3D only: {c:?}");
}

#[test]
fn a_cube_of_six_charts_is_cut_at_its_twelve_edges() {
    let (s, uv) = cube();
    let sides: Vec<u32> = (0..12).map(|f| f / 2).collect();
    // The first side is one part, the others together another.
    let labels: Vec<i32> = (0..12).map(|f| i32::from(f >= 2)).collect();
    let parts: Vec<u32> = labels.iter().map(|l| *l as u32).collect();
    let input = measured(&s, &uv, &sides, &parts, Some(&labels));
    let figures = measure(&input, &Run::quiet()).unwrap();
    let f = &figures.atlas;
    assert_eq!((f.seam_edges, f.paper.seam_count, f.paper.island_count), (12, 1, 6));
    near(f.seam_length.map(|x| x.per_sqrt_area), 12.0 / 6f64.sqrt(), 1e-9);
    near(f.seam_length.map(|x| x.per_diagonal), 12.0 / 3f64.sqrt(), 1e-9);
    near(f.avoidable_seam, 0.0, 0.0);
    near(f.symmetric_dirichlet, 1.0, 1e-9);
    let a = f.boundary_alignment.unwrap();
    // Four edges, and on four others the 2 of 116 samples that are within 1 % of the diagonal.
    near(a.precision, (4.0 + 4.0 * 2.0 / 116.0) / 12.0, 1e-9);
    near(a.recall, 1.0, 1e-9);
    near(a.ceiling, 4.0 / 12.0, 1e-9);
    near(a.f1, 2.0 * a.precision / (1.0 + a.precision), 1e-9);
    near(f.paper.boundary_alignment_score, a.precision, 0.0);
    near(f.paper.boundary_compactness.and_then(|x| x.seam_boundary_overlap), 4.0 / 12.0, 1e-9);
    assert_eq!(figures.parts[0].seam_edges, 4);
    assert_eq!(figures.parts[1].seam_edges, 12);
    assert_eq!(figures.parts[1].paper.island_count, 5);
    for chart in &figures.charts {
        assert_eq!(chart.seam_edges, 4);
        near(chart.seam_length.map(|x| x.per_sqrt_area), 4.0, 1e-6);
    }
    // A boundary between the parts themselves is the same boundary.
    let own = measure(&Measured { boundary_labels: None, ..input }, &Run::quiet()).unwrap();
    assert_eq!(own.atlas.boundary_alignment, f.boundary_alignment);
    // One label everywhere, or none known, is no boundary.
    for label in [7, -1] {
        let none = vec![label; 12];
        let input = Measured { boundary_labels: Some(&none), ..input };
        let f = measure(&input, &Run::quiet()).unwrap().atlas;
        assert_eq!((f.boundary_alignment, f.paper.boundary_alignment_score), (None, None));
    }
}

/// The square of 4 × 4 and its back.
fn pillow() -> (Surface, Vec<[[f32; 2]; 3]>) {
    let (s, p) = grid(4, 4, |x, y| DVec3::new(x, y, 0.0));
    let mut triangles = s.triangles.clone();
    triangles.extend(s.triangles.iter().map(|t| [t[0], t[2], t[1]]));
    let mut uv = uvs(&p, |[u, v]| [0.4 * u, 0.4 * v]);
    let back = uvs(&p, |[u, v]| [0.9 - 0.4 * u, 0.4 * v]);
    uv.extend(back.iter().map(|t| [t[0], t[2], t[1]]));
    (surface(s.positions, triangles), uv)
}

#[test]
fn two_sheets_are_no_seam_by_themselves() {
    let (s, mut uv) = pillow();
    let mut charts: Vec<u32> = (0..64).map(|f| f / 32).collect();
    let parts = vec![0; 64];
    let f = measure(&measured(&s, &uv, &charts, &parts, None), &Run::quiet()).unwrap();
    assert_eq!((f.atlas.seam_edges, f.parts[0].seam_edges), (16, 16));
    assert_eq!((f.charts[0].seam_edges, f.charts[1].seam_edges), (16, 16));
    near(f.atlas.avoidable_seam, 0.0, 0.0);
    // The front is cut down the middle: four more, none of them the back's.
    for face in 16..32 {
        uv[face] = uv[face].map(|[u, v]| [u, v + 0.5]);
        charts[face] = 2;
    }
    let f = measure(&measured(&s, &uv, &charts, &parts, None), &Run::quiet()).unwrap();
    assert_eq!(f.atlas.seam_edges, 20);
    assert_eq!(f.charts.iter().map(|c| c.seam_edges).collect::<Vec<_>>(), [12, 16, 12]);
    // The paired sheet hides nothing: the cut is in plain sight.
    near(f.atlas.avoidable_seam, 4.0 * 0.25 / (4.0 * 0.25 + 4.0), 1e-9);
    // The sheets may be two parts: their common edges are then no part boundary, but their rim is.
    let sheets: Vec<u32> = (0..64).map(|f| f / 32).collect();
    let f = measure(&measured(&s, &uv, &charts, &sheets, None), &Run::quiet()).unwrap();
    near(f.atlas.boundary_alignment.map(|a| a.ceiling), 4.0 / 5.0, 1e-9);
}

/// A plate cut down its middle within a box of which `sides` sides are there.
fn plate_in_box(sides: usize) -> MeasuredFigures {
    let (plate, p) = grid(2, 2, |x, y| DVec3::new(0.4 * x + 0.3, 0.4 * y + 0.3, 0.5));
    let (cube, cube_uv) = cube();
    let mut uv: Vec<_> = cube_uv[..2 * sides].to_vec();
    let mut positions = cube.positions.clone();
    let mut triangles = cube.triangles[..2 * sides].to_vec();
    let base = positions.len() as u32;
    positions.extend(&plate.positions);
    triangles.extend(plate.triangles.iter().map(|t| t.map(|v| v + base)));
    let cell = |[u, v]: [f64; 2], x: f64| [0.2 * u + x, 0.2 * v + 0.7];
    for (f, t) in p.iter().enumerate() {
        uv.push(t.map(|q| cell(q, if f < 4 { 0.1 } else { 0.3 }).map(|x| x as f32)));
    }
    let surface = surface(positions, triangles);
    let mut charts: Vec<u32> = (0..2 * sides as u32).map(|f| f / 2).collect();
    charts.extend([6; 4].into_iter().chain([7; 4]));
    let mut parts = vec![0; 2 * sides];
    parts.extend([1; 8]);
    measure(&measured(&surface, &uv, &charts, &parts, None), &Run::quiet()).unwrap()
}

#[test]
fn a_seam_inside_a_closed_box_is_hidden() {
    let closed = plate_in_box(6);
    assert_eq!(closed.parts[1].seam_edges, 2);
    near(closed.atlas.avoidable_seam, 0.0, 0.0);
    near(closed.parts[1].avoidable_seam, 0.0, 0.0);
    // Without the last side (above the plate) the same seam is in sight.
    let open = plate_in_box(5);
    near(open.parts[1].avoidable_seam, 1.0, 1e-9);
    near(open.parts[0].avoidable_seam, 0.0, 0.0);
    assert!(open.atlas.avoidable_seam.unwrap() > 0.0);
}

#[test]
fn a_seam_on_a_part_boundary_is_not_avoidable() {
    let (s, p) = grid(2, 2, |x, y| DVec3::new(x, y, 0.0));
    let half = uvs(&p, |[u, v]| [0.3 * u, 0.3 * v]);
    let uv: Vec<_> =
        (0..8).map(|f| if f < 4 { half[f] } else { half[f].map(|[u, v]| [u + 0.5, v]) }).collect();
    let halves: Vec<u32> = (0..8).map(|f| f / 4).collect();
    let on = measure(&measured(&s, &uv, &halves, &halves, None), &Run::quiet()).unwrap().atlas;
    near(on.avoidable_seam, 0.0, 0.0);
    near(on.boundary_alignment.map(|a| a.f1), 1.0, 1e-12);
    let off = measure(&measured(&s, &uv, &halves, &[0; 8], None), &Run::quiet()).unwrap().atlas;
    near(off.avoidable_seam, 1.0, 1e-9);
}

#[test]
fn stacked_cubes_touch_along_the_rim_between_them() {
    let (a, uv) = cube();
    let mut positions = a.positions.clone();
    positions.extend(a.positions.iter().map(|p| *p * 0.5 + DVec3::new(0.25, 0.25, 1.0)));
    let mut triangles = a.triangles.clone();
    triangles.extend(a.triangles.iter().map(|t| t.map(|v| v + 8)));
    let s = surface(positions, triangles);
    let mut uv2 = uv.clone();
    uv2.extend(uv.iter().map(|t| t.map(|[u, v]| [0.3 * u, 0.3 * v + 0.65])));
    let charts: Vec<u32> = (0..24).map(|f| f / 2).collect();
    // The large cube has two parts, so that there is a boundary that is measured.
    let parts: Vec<u32> = (0..24).map(|f| if f < 2 { 0 } else { 1 + f / 12 }).collect();
    let figures = measure(&measured(&s, &uv2, &charts, &parts, None), &Run::quiet()).unwrap();
    let touch = 0.005 * s.diagonal;
    // Its rim, and of the four edges that rise from it what is as near.
    let contact = figures.atlas.boundary_alignment.unwrap().contact_length * s.diagonal;
    assert!((2.0..2.0 + 4.0 * 1.6 * touch).contains(&contact), "{contact}");
    let part = figures.parts[1].boundary_alignment.unwrap().contact_length * s.diagonal;
    near(part, contact, 1e-12);
    assert_eq!(figures.parts[2].boundary_alignment, None);
}

#[test]
fn scales_that_differ_between_charts_are_seen_globally_only() {
    let (s, uv) = cube();
    let sides: Vec<u32> = (0..12).map(|f| f / 2).collect();
    let mut uv = uv;
    for t in &mut uv[..2] {
        *t = t.map(|[u, v]| [0.05 + (u - 0.05) * 0.5, 0.05 + (v - 0.05) * 0.5]);
    }
    let f = measure(&measured(&s, &uv, &sides, &[0; 12], None), &Run::quiet()).unwrap();
    near(f.atlas.symmetric_dirichlet_chart, 1.0, 1e-9);
    near(f.atlas.area_distortion_chart.map(|x| x.max), 1.0, 1e-5);
    let scale = (5.0 + 0.25) / 6.0;
    near(f.atlas.area_distortion.map(|x| x.max), scale / 0.25, 1e-5);
    near(f.charts[0].area_distortion.map(|x| x.mean), scale / 0.25, 1e-5);
    near(f.charts[0].area_distortion_chart.map(|x| x.mean), 1.0, 1e-5);
    assert!(f.atlas.symmetric_dirichlet.unwrap() > 1.1);
    assert!(f.atlas.paper.internal_consistency.unwrap().geodesic > 0.01);
}

#[test]
fn faces_without_chart_or_area_count_for_nothing() {
    let (s, p) = grid(2, 1, |x, y| DVec3::new(x, y, 0.0));
    let mut uv = uvs(&p, |q| q);
    uv[3] = [[f32::NAN; 2]; 3];
    let f = measure(&measured(&s, &uv, &[0, 0, 0, NONE], &[0, 0, 0, NONE], None), &Run::quiet());
    let f = f.unwrap().atlas;
    near(f.symmetric_dirichlet, 1.0, 1e-12);
    assert_eq!((f.seam_edges, f.paper.island_count), (0, 1));
    // A collapsed face is "100 or worse", and leaves inverse powers alone.
    uv[2] = [[0.5, 0.5]; 3];
    let f = one_chart(&s, &uv).atlas;
    near(f.quasi_conformal.map(|x| x.max), 100.0, 0.0);
    near(f.area_distortion.map(|x| x.max), 100.0, 0.0);
    near(f.symmetric_dirichlet, 1.0, 1e-9);
    // Nothing at all has no figures, but figures nonetheless.
    let empty = measure(&measured(&s, &uv, &[NONE; 4], &[NONE; 4], None), &Run::quiet()).unwrap();
    assert_eq!(empty.atlas, Default::default());
}

#[test]
fn trained_charts_alone_have_a_chamfer_distance() {
    let (s, uv) = cube();
    let sides: Vec<u32> = (0..12).map(|f| f / 2).collect();
    let chamfer = [Some(0.02), None, Some(0.04), None, None, None];
    let input = Measured { chamfer: &chamfer, ..measured(&s, &uv, &sides, &[0; 12], None) };
    let f = measure(&input, &Run::quiet()).unwrap();
    near(f.atlas.paper.chamfer, 0.03, 1e-12);
    near(f.charts[2].paper.chamfer, 0.04, 0.0);
    assert_eq!(f.charts[1].paper.chamfer, None);
}

#[test]
fn figures_do_not_depend_on_the_number_of_threads() {
    let bumpy = |x: f64, y: f64| DVec3::new(x, y, 0.1 * (9.0 * x).sin() * (7.0 * y).cos());
    let (s, p) = grid(20, 20, bumpy);
    let cut = |f: usize| u32::from(p[f][0][0] > 0.45);
    let charts: Vec<u32> = (0..p.len()).map(cut).collect();
    let uv: Vec<_> = p
        .iter()
        .zip(&charts)
        .map(|(t, c)| t.map(|[u, v]| [0.45 * u + 0.1 * f64::from(*c), 0.9 * v].map(|x| x as f32)))
        .collect();
    let parts = vec![0; p.len()];
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| measure(&measured(&s, &uv, &charts, &parts, None), &Run::quiet()).unwrap())
    };
    let (one, two) = (with(1), with(2));
    assert!(one.atlas.avoidable_seam.unwrap() > 0.5);
    assert_eq!(one, two);
}

#[test]
fn a_canceled_run_stops() {
    let (s, uv) = cube();
    let run = Run::new(|_| {}, Cancel::default(), Budget::default());
    run.cancel.cancel();
    let input = measured(&s, &uv, &[0; 12], &[0; 12], None);
    assert!(measure(&input, &run).is_err());
}

#[test]
fn thousands_of_faces_about_one_edge_do_not_cost_their_square() {
    let n = 20_000u32;
    let fin = |i: u32| {
        let (sin, cos) = (TAU * f64::from(i) / f64::from(n)).sin_cos();
        DVec3::new(cos, 0.5, sin)
    };
    let positions: Vec<DVec3> =
        [DVec3::ZERO, DVec3::Y].into_iter().chain((0..n).map(fin)).collect();
    let faces = n as usize;
    // Fins pair off as twins, but each is a chart of its own.
    let s = Surface {
        triangles: (0..n).map(|i| if i % 2 == 0 { [0, 1, i + 2] } else { [1, 0, i + 2] }).collect(),
        twin: (0..3 * n)
            .map(|h| if h % 3 == 0 { h / 6 * 6 + 3 * (1 - h / 3 % 2) } else { NONE })
            .collect(),
        normals: vec![DVec3::X; faces],
        areas: vec![0.5; faces],
        sheet_mate: vec![NONE; faces],
        diagonal: 3.0,
        positions,
        ..Surface::default()
    };
    let side = 1.0 / 150.0;
    let uv: Vec<[[f32; 2]; 3]> = (0..n)
        .map(|i| {
            let (x, y) = (side * (i % 150) as f32, side * (i / 150) as f32);
            [[x, y], [x + 0.5 * side, y], [x, y + 0.5 * side]]
        })
        .collect();
    let charts: Vec<u32> = (0..n).collect();
    let start = std::time::Instant::now();
    let f = measure(&measured(&s, &uv, &charts, &vec![0; faces], None), &Run::quiet()).unwrap();
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
    assert_eq!((f.atlas.seam_edges, f.charts[7].seam_edges), (u64::from(n) / 2, 1));
    assert!(f.atlas.avoidable_seam.is_some_and(|a| (0.0..=1.0).contains(&a)));
}
