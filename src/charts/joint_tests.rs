//! Joint seams: the over-cut mesh, and merging in the order that a soft map says.

use glam::DVec3;

use super::component::patchwork;
use super::joins::merge::merge;
use super::limits::ChartLimits;
use super::part_mesh::PartMesh;
use super::scenes::*;
use super::*;
use crate::contract::Run;
use crate::device::Seeded;
use crate::flatten::quality;
use crate::mesh::Surface;

#[test]
fn an_over_cut_box_is_laid_out_along_a_tree_of_its_edges() {
    let s = solid_box(3.0, 2.0, 1.0);
    let options = ChartOptions { distortion_bound: 0.01, pinches: true };
    let parts = over_cut(&s, &vec![0; s.face_count()], &options, 100, &Run::quiet()).unwrap();
    let [part] = &parts[..] else { panic!("{} parts", parts.len()) };
    assert_eq!((part.seams.len(), part.disk.positions.len()), (12, 24), "six faces, twelve edges");
    assert!(quality(&part.disk, &part.start).max - 1.0 < 1e-9);
    let gap = |seam: &&Seam| {
        let [[i, j], [k, l]] = seam.sides.map(|side| side.map(|v| part.start[v as usize]));
        i.distance(k) + j.distance(l) < 1e-9
    };
    let closed: Vec<&Seam> = part.seams.iter().filter(gap).collect();
    assert_eq!(closed.len(), 5, "a tree over six faces");
    // The dearest edges are the longest: all four of length 3.
    assert_eq!(closed.iter().filter(|seam| (seam.length - 3.0).abs() < 1e-9).count(), 3);
    assert!(
        over_cut(&s, &vec![0; s.face_count()], &options, 23, &Run::quiet()).unwrap().is_empty()
    );
}

/// A box of 3 × 2 × 1 beside a plate, and the part of each face: the box is part 0.
fn box_beside_a_plate() -> (Surface, Vec<u32>) {
    let s = beside_a_plate(&solid_box(3.0, 2.0, 1.0));
    let part_of = (0..s.face_count() as u32).map(|f| u32::from(f >= 12)).collect();
    (s, part_of)
}

#[test]
fn a_box_is_joined_where_a_soft_map_has_closed_it() {
    let (s, _) = box_beside_a_plate();
    // However wasteful a net is.
    let limits = ChartLimits { waste: 9.0, length: 99.0, ..ChartLimits::new(&s, 0.01) };
    let mesh = PartMesh::new(&s, (0..12).collect());
    // Two nets: a strip of the four sides around an axis, with a cap on its first and on its last. Sides
    // of the box: −x, +x, −y, +y, −z, +z.
    let side = |h: u32| {
        let normal = s.normals[h as usize / 3].to_array();
        (0..6).find(|k| normal[k / 2] == if k % 2 == 0 { -1.0 } else { 1.0 })
    };
    for strip in [[0, 2, 4, 3, 5, 1], [4, 0, 2, 1, 3, 5]] {
        let closed = |h: u32| {
            let [a, b] =
                [h, s.twin[h as usize]].map(|h| strip.iter().position(|&k| Some(k) == side(h)));
            a.zip(b).is_some_and(|(a, b)| a.abs_diff(b) == 1)
        };
        let edges = |of: &dyn Fn(u32) -> bool| -> Vec<u32> {
            (0..36).filter(|&h| s.is_crease(h) && of(h)).collect()
        };
        let openness: Vec<f32> = (0..36).map(|h| if closed(h) { 0.0 } else { 0.9 }).collect();
        let mut work = patchwork(&mesh, &[], &limits, &Run::quiet()).unwrap();
        let all: Vec<u32> = (0..6).collect();
        merge(&mut work, &all, Some(&openness), &limits, &Run::quiet()).unwrap();
        assert_eq!(edges(&closed).len(), 10, "five edges, from both sides");
        assert_eq!(edges(&|h| work.glued[h as usize]), edges(&closed));
    }
}

#[test]
fn what_a_soft_map_leaves_open_is_followed_where_it_is_better() {
    let (s, part_of) = rough();
    let options = ChartOptions { distortion_bound: 0.01, pinches: true };
    let baseline = build(&s, &part_of, &options, &Run::quiet()).unwrap();
    let mut followed = [0, 0];
    for seed in 0..16 {
        let mut random = Seeded::new(seed, 0);
        let openness: Vec<f32> = s.twin.iter().map(|_| random.unit_f64() as f32).collect();
        let built = build_jointly(&s, &part_of, &options, Some(&openness), &Run::quiet()).unwrap();
        let [orders] = built.orders[..] else { panic!("{:?}", built.orders) };
        let better = orders.joint < orders.baseline;
        assert_eq!(built.charts != baseline, better, "{orders:?}");
        followed[usize::from(better)] += 1;
    }
    assert!(followed.iter().all(|&n| n > 0), "{followed:?}");
}

/// A ball of rough relief.
fn rough() -> (Surface, Vec<u32>) {
    let (n, m) = (10u32, 8u32);
    let mut positions = Vec::new();
    for j in 0..=m {
        for i in 0..n {
            let (a, b) = (
                std::f64::consts::TAU * f64::from(i) / f64::from(n),
                std::f64::consts::PI * (f64::from(j) + 0.2) / (f64::from(m) + 0.4),
            );
            let radius = 1.0 + 0.25 * (3.0 * a).sin() * (4.0 * b).cos();
            positions.push(DVec3::new(b.sin() * a.cos(), b.sin() * a.sin(), b.cos()) * radius);
        }
    }
    let at = |i: u32, j: u32| j * n + i % n;
    let sides: Vec<[u32; 4]> = (0..m)
        .flat_map(|j| (0..n).map(move |i| [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]))
        .collect();
    let s = quads(positions, &sides);
    let part_of = vec![0; s.face_count()];
    (s, part_of)
}
