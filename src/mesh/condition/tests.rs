//! Conditioning on the kinds of mesh that real files hold, and on every way to tell one.

use proptest::prelude::*;

use super::*;
use crate::mesh::Sides;

fn told(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Conditioned {
    let positions = positions.iter().map(|p| DVec3::from_array(*p)).collect();
    let scene = Scene::from_triangles(positions, triangles.to_vec());
    condition(&scene, Winding::Surface, &Run::quiet()).unwrap()
}

fn conditioned(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Surface {
    told(positions, triangles).surface
}

fn inner(s: &Surface) -> usize {
    s.twin.iter().filter(|&&t| t != NONE).count()
}

const QUAD: [[f64; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];

/// A box from one corner to another, its faces outward.
fn cuboid(low: [f64; 3], high: [f64; 3]) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let at = |i: u32, k: u32| if i >> k & 1 == 0 { low[k as usize] } else { high[k as usize] };
    let corners = (0..8).map(|i| [at(i, 0), at(i, 1), at(i, 2)]).collect();
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    (corners, quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
}

/// Two meshes in one list.
fn both(
    (mut positions, mut triangles): (Vec<[f64; 3]>, Vec<[u32; 3]>),
    (more, faces): (Vec<[f64; 3]>, Vec<[u32; 3]>),
) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let base = positions.len() as u32;
    positions.extend(more);
    triangles.extend(faces.iter().map(|t| t.map(|v| v + base)));
    (positions, triangles)
}

#[test]
fn a_soup_is_welded_and_paired() {
    let soup = [QUAD[0], QUAD[1], QUAD[2], QUAD[0], QUAD[2], QUAD[3]];
    let s = conditioned(&soup, &[[0, 1, 2], [3, 4, 5]]);
    assert_eq!((s.repairs.welded, inner(&s)), (2, 2));
}

#[test]
fn what_is_far_from_the_origin_is_moved_there() {
    let moved = |by: f64| {
        let away = QUAD.map(|p| p.map(|x| x + by));
        conditioned(&away, &[[0, 1, 2], [0, 2, 3]]).positions
    };
    let at = |by: f64| moved(by)[0];
    assert_eq!([at(0.0), at(32.0)], [DVec3::ZERO, DVec3::splat(32.0)]);
    assert_eq!(moved(1024.0), moved(0.0));
}

#[test]
fn a_turned_face_is_turned_back_and_told() {
    let strip = [QUAD.to_vec(), vec![[0., 2., 0.], [1., 2., 0.]]].concat();
    let Conditioned { surface, telling } =
        told(&strip, &[[0, 1, 2], [0, 2, 3], [3, 2, 4], [2, 4, 5]]);
    assert_eq!(inner(&surface), 6, "all hang together");
    let ahead = surface.normals[0].z;
    assert!(surface.normals.iter().all(|n| n.z * ahead > 0.99));
    let against: Vec<bool> = (0..4).map(|f| telling.is_against(&surface, f)).collect();
    assert_eq!(against[..3], [against[0]; 3]);
    assert_ne!(against[3], against[0]);
    for (f, t) in telling.triangles.iter().enumerate() {
        for k in 0..3 {
            let there = surface.triangles[telling.face[f] as usize];
            assert_eq!(there[telling.corner(&surface, f, k)], t[k]);
        }
    }
    // Three of four are wound one way: the sides are, too.
    let sides = Sides::of(&surface, &telling, true, true);
    assert!(sides.surface.normals.iter().all(|n| n.z > 0.99));
}

#[test]
fn a_double_sided_box_corner_is_seen_once_and_has_two_sides() {
    // Two quads that meet at 90°, each face with both windings.
    let p = [QUAD.to_vec(), vec![[1., 0., 1.], [1., 1., 1.]]].concat();
    let front = [[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]];
    let mut faces = front.to_vec();
    faces.extend(front.iter().map(|&[a, b, c]| [a, c, b]));
    let Conditioned { surface, telling } = told(&p, &faces);
    assert_eq!((surface.face_count(), inner(&surface)), (4, 6));
    assert_eq!(surface.repairs.double_sided_faces, 8);
    assert_eq!(telling.face[..4], telling.face[4..]);
    let Sides { surface: all, telling, second, turned, .. } =
        Sides::of(&surface, &telling, true, true);
    assert_eq!((all.face_count(), inner(&all)), (8, 12));
    assert_eq!(turned, [[false; 4], [true; 4]].concat());
    for f in 0..4 {
        assert_eq!((all.sheet_mate[f], all.sheet_mate[second[f] as usize]), (second[f], f as u32));
    }
    for f in 0..8 {
        assert!(!telling.is_against(&all, f), "each side is wound as the file has it");
    }
    for (h, &t) in all.twin.iter().enumerate().filter(|(_, t)| **t != NONE) {
        assert_eq!(h / 3 < 4, t / 3 < 4, "half-edge {h} pairs with the other sheet");
        assert_eq!((all.from(h as u32), all.to(h as u32)), (all.to(t), all.from(t)));
    }
}

#[test]
fn copies_share_the_place_of_the_first_whatever_their_winding() {
    let many = [[0, 1, 2], [0, 2, 3], [1, 2, 0], [2, 0, 1]];
    let Conditioned { surface, telling } = told(&QUAD, &many);
    assert_eq!((surface.face_count(), surface.repairs.copies), (2, 2), "two more of the first");
    assert_eq!(telling.face[0], telling.face[3]);
    assert_eq!(surface.repairs.first_faces.copies, Some(2));
    // One of ten that stands with both windings is no sheet.
    let (positions, mut faces) = cuboid([0.0; 3], [1.0; 3]);
    faces.push([faces[5][1], faces[5][0], faces[5][2]]);
    let Conditioned { surface, telling } = told(&positions, &faces);
    assert_eq!((surface.face_count(), surface.repairs.shared_faces), (12, 1));
    assert_eq!((telling.face[12], telling.second[12]), (telling.face[5], false));
}

#[test]
fn degenerate_faces_are_set_aside() {
    let Conditioned { surface, telling } = told(&QUAD, &[[0, 1, 2], [0, 0, 1], [0, 2, 3]]);
    assert_eq!(telling.face.iter().map(|&f| f == NONE).collect::<Vec<_>>(), [false, true, false]);
    assert_eq!((surface.face_count(), surface.repairs.zero_area_faces), (2, 1));
    assert_eq!(surface.repairs.first_faces.zero_area_faces, Some(1));
}

#[test]
fn a_sliver_that_welding_would_flatten_keeps_its_neighbours() {
    let mut p = QUAD.to_vec();
    p.push([1., 1. + 1e-6, 0.]);
    let s = conditioned(&p, &[[0, 1, 2], [0, 2, 4], [0, 4, 3]]);
    assert_eq!((s.face_count(), inner(&s)), (3, 4));
    assert!(s.origins.iter().all(|o| o.shell == 0));
}

#[test]
fn a_bow_tie_is_two_fans() {
    let p = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [-1., 0., 0.], [0., -1., 0.]];
    let s = conditioned(&p, &[[0, 1, 2], [0, 3, 4]]);
    assert_eq!(s.repairs.split_vertices, 1);
}

#[test]
fn a_vertex_of_nothing_but_a_sliver_is_no_fan() {
    let p = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [-1., 0., 0.], [0., -1., 0.], [0.5, 0., 0.]];
    let s = conditioned(&p, &[[0, 1, 2], [0, 3, 4], [0, 5, 1]]);
    assert_eq!((s.repairs.split_vertices, s.repairs.zero_area_faces), (1, 1));
}

#[test]
fn at_an_edge_of_very_many_faces_each_ends() {
    let fin = |i: u32| {
        let (y, x) = (f64::from(i) / 3000.0).sin_cos();
        [x, y, 0.5]
    };
    let inner = |n: u32| {
        let positions = [vec![[0., 0., 0.], [0., 0., 1.]], (0..n).map(fin).collect()].concat();
        inner(&conditioned(&positions, &(0..n).map(|i| [0, 1, 2 + i]).collect::<Vec<_>>()))
    };
    assert_eq!(inner(3000), 0);
    assert!(inner(40) <= 40);
}

#[test]
fn dihedral_angles_have_a_sign() {
    let (positions, triangles) = cuboid([0.0; 3], [1.0, 2.0, 3.0]);
    let s = conditioned(&positions, &triangles);
    let right = std::f64::consts::FRAC_PI_2;
    let bent: Vec<f64> = (0..36).map(|h| s.dihedral(h)).filter(|a| a.abs() > 0.1).collect();
    assert_eq!(bent.len(), 24);
    assert!(bent.iter().all(|a| (a - right).abs() < 1e-12), "a box is convex: {bent:?}");
}

#[test]
fn what_is_closed_faces_outward_but_for_a_cavity() {
    let volume = |s: &Surface| -> f64 {
        (0..s.face_count()).map(|f| s.corners(f)).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
    };
    let (outer, inner) = (cuboid([0.0; 3], [4.0; 3]), cuboid([1.0; 3], [2.0; 3]));
    let reversed = |(p, t): (Vec<[f64; 3]>, Vec<[u32; 3]>)| {
        (p, t.into_iter().map(|[a, b, c]| [a, c, b]).collect::<Vec<_>>())
    };
    let of = |(p, t): (Vec<[f64; 3]>, Vec<[u32; 3]>)| volume(&conditioned(&p, &t)).round();
    assert_eq!(of(both(outer.clone(), inner.clone())), 65.0, "a body in another");
    assert_eq!(of(both(outer.clone(), reversed(inner.clone()))), 63.0, "a cavity");
    assert_eq!(of(both(reversed(outer), inner)), 63.0, "the same, inside out");
}

#[test]
fn an_open_box_faces_where_rays_escape() {
    let (positions, mut triangles) = cuboid([0.0; 3], [1.0; 3]);
    triangles.truncate(10);
    for turn in [false, true] {
        let told = |&[a, b, c]: &[u32; 3]| if turn { [a, c, b] } else { [a, b, c] };
        let triangles: Vec<[u32; 3]> = triangles.iter().map(told).collect();
        let s = conditioned(&positions, &triangles);
        let outward = (0..10).all(|f| s.normals[f].dot(s.centroid(f) - DVec3::splat(0.5)) > 0.0);
        assert!(outward);
    }
}

#[test]
fn two_solids_that_touch_keep_a_wall_each() {
    let stacked = both(cuboid([0.0; 3], [1.0; 3]), cuboid([0.0, 0.0, 1.0], [1.0, 1.0, 2.0]));
    // By their own vertices, and in a soup, by shape alone.
    let soup = (
        stacked.1.iter().flatten().map(|&v| stacked.0[v as usize]).collect::<Vec<_>>(),
        (0..24).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect::<Vec<[u32; 3]>>(),
    );
    for (positions, triangles) in [stacked, soup] {
        let s = conditioned(&positions, &triangles);
        assert_eq!(s.face_count(), 24);
        assert_eq!(s.sheet_mate.iter().filter(|m| **m != NONE).count(), 4, "the wall");
        assert_eq!(s.repairs.double_sided_faces, 0);
    }
}

#[test]
fn a_moebius_strip_keeps_a_cut_and_is_told() {
    let n = 12u32;
    let at = |i: u32, side: f64| {
        let (a, half) = (f64::from(i) / 12.0 * std::f64::consts::TAU, side * 0.3);
        let r = 1.0 + half * (a / 2.0).cos();
        [r * a.cos(), r * a.sin(), half * (a / 2.0).sin()]
    };
    let positions: Vec<[f64; 3]> = (0..n).flat_map(|i| [at(i, -1.0), at(i, 1.0)]).collect();
    let quad = |i: u32| match i + 1 < n {
        true => [2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1],
        false => [2 * i, 1, 0, 2 * i + 1],
    };
    let triangles: Vec<[u32; 3]> =
        (0..n).map(quad).flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let s = conditioned(&positions, &triangles);
    assert_eq!(s.repairs.components_without_winding, 1);
    assert_eq!(inner(&s), 2 * (24 - 1), "one edge of 24 is cut");
}

#[test]
fn where_windings_count_charts_end_at_them() {
    let positions = QUAD.map(DVec3::from_array).to_vec();
    let scene = Scene::from_triangles(positions, vec![[0, 1, 2], [0, 3, 2]]);
    let inner_edges = |winding| {
        let Conditioned { surface, telling } = condition(&scene, winding, &Run::quiet()).unwrap();
        let against = (0..2).filter(|&f| telling.is_against(&surface, f)).count();
        (inner(&surface), against)
    };
    assert_eq!(inner_edges(Winding::File), (0, 0));
    assert_eq!(inner_edges(Winding::Surface), (2, 1));
}

/// A lumpy sphere, open or closed.
fn lump(rings: u32, open: bool) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let around = 2 * rings;
    let at = |i: u32, j: u32| {
        let (u, v) = (f64::from(i) / f64::from(rings), f64::from(j) / f64::from(around));
        let (polar, turn) = (u * std::f64::consts::PI, v * std::f64::consts::TAU);
        let r = 1.0 + 0.2 * (3.0 * turn).sin() * (2.0 * polar).sin() + 0.1 * polar;
        [r * polar.sin() * turn.cos(), r * polar.sin() * turn.sin(), r * polar.cos()]
    };
    let positions: Vec<[f64; 3]> =
        (1..rings).flat_map(|i| (0..around).map(move |j| at(i, j))).collect();
    let index = |i: u32, j: u32| (i - 1) * around + j % around;
    let mut triangles: Vec<[u32; 3]> = (1..rings - 1)
        .flat_map(|i| (0..around).map(move |j| (i, j)))
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    if !open {
        triangles.extend((1..around - 1).map(|j| [index(1, 0), index(1, j), index(1, j + 1)]));
        let last = rings - 1;
        triangles
            .extend((1..around - 1).map(|j| [index(last, 0), index(last, j + 1), index(last, j)]));
    }
    (positions, triangles)
}

/// A telling of a mesh: its faces in another order and from another corner, vertices in another order, some
/// faces turned over, some twice, each with vertices of its own or not. With the place of each of its faces in
/// the mesh.
fn telling(
    (positions, triangles): &(Vec<[f64; 3]>, Vec<[u32; 3]>),
    seed: u64,
    twice: bool,
    soup: bool,
) -> (Vec<[f64; 3]>, Vec<[u32; 3]>, Vec<usize>) {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut next = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state >> 11
    };
    let mut order: Vec<usize> = (0..triangles.len()).collect();
    if twice {
        order.extend((0..triangles.len()).filter(|_| next() % 10 == 0).collect::<Vec<_>>());
    }
    for i in (1..order.len()).rev() {
        order.swap(i, next() as usize % (i + 1));
    }
    let mut place: Vec<u32> = (0..positions.len() as u32).collect();
    for i in (1..place.len()).rev() {
        place.swap(i, next() as usize % (i + 1));
    }
    let mut moved = positions.clone();
    place.iter().zip(positions).for_each(|(&to, p)| moved[to as usize] = *p);
    let faces: Vec<[u32; 3]> = order
        .iter()
        .map(|&f| {
            let mut t = triangles[f].map(|v| place[v as usize]);
            t.rotate_left(next() as usize % 3);
            if next() % 2 == 0 {
                t.swap(0, 1);
            }
            t
        })
        .collect();
    if soup {
        let corners = faces.iter().flatten().map(|&v| moved[v as usize]).collect();
        let faces = (0..faces.len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
        return (corners, faces, order);
    }
    (moved, faces, order)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn every_telling_has_the_same_surface(seed in 0u64.., open in any::<bool>(), twice in any::<bool>(), soup in any::<bool>()) {
        let object = lump(6, open);
        let first = told(&object.0, &object.1);
        let (positions, triangles, order) = telling(&object, seed, twice, soup);
        let again = told(&positions, &triangles);
        let what = |s: &Surface| (s.positions.clone(), s.triangles.clone(), s.twin.clone());
        prop_assert_eq!(what(&again.surface), what(&first.surface));
        prop_assert_eq!(&again.surface.sheet_mate, &first.surface.sheet_mate);
        for (i, &f) in order.iter().enumerate() {
            prop_assert_eq!(again.telling.face[i], first.telling.face[f]);
        }
        let more = order.len() as u64 - object.1.len() as u64;
        let repairs = again.surface.repairs;
        prop_assert_eq!(repairs.copies + repairs.shared_faces, more);
    }
}

#[test]
fn two_sheets_of_other_triangles_that_lie_on_each_other_stay_two() {
    // A row of squares; their other sides have the other diagonal.
    let n = 6u32;
    let positions: Vec<[f64; 3]> =
        (0..=n).flat_map(|i| [[f64::from(i), 0., 0.], [f64::from(i), 1., 0.]]).collect();
    let front = (0..n).map(|i| [2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1]);
    let triangles: Vec<[u32; 3]> = front
        .clone()
        .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
        .chain(front.flat_map(|[a, b, c, d]| [[d, c, b], [d, b, a]]))
        .collect();
    let Conditioned { surface, telling } = told(&positions, &triangles);
    let roots = surface.components(|_| true);
    let side = |file: usize| roots[telling.face[file] as usize];
    assert!((0..12).all(|f| side(f) == side(0)) && (12..24).all(|f| side(f) == side(12)));
    assert_ne!(side(0), side(12));
}
