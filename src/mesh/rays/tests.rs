//! The ray caster against trying every face, and against skies that are known.

use super::*;

/// A surface of loose triangles: all that rays need.
fn soup(triangles: &[[DVec3; 3]]) -> Surface {
    let n = triangles.len();
    let positions: Vec<DVec3> = triangles.iter().flatten().copied().collect();
    let (low, high) = bounds(positions.iter().copied());
    Surface {
        diagonal: low.distance(high),
        positions,
        triangles: (0..n as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect(),
        sheet_mate: vec![NONE; n],
        ..Surface::default()
    }
}

fn random(n: usize, mut state: u64) -> Vec<[DVec3; 3]> {
    let mut point = || DVec3::from_array([(); 3].map(|()| uniform(&mut state)));
    (0..n)
        .map(|_| {
            let center = point();
            [(); 3].map(|()| center + (point() - DVec3::splat(0.5)) * 0.2)
        })
        .collect()
}

/// Two triangles of a square of side 2 about the origin, turned so that `normal` is its normal.
fn wall(center: DVec3, normal: DVec3) -> [[DVec3; 3]; 2] {
    let (x, y) = normal.any_orthonormal_pair();
    let p = [center - x - y, center + x - y, center + x + y, center - x + y];
    [[p[0], p[1], p[2]], [p[0], p[2], p[3]]]
}

fn closed_box() -> Vec<[DVec3; 3]> {
    [DVec3::X, DVec3::Y, DVec3::Z]
        .into_iter()
        .flat_map(|n| [n, -n])
        .flat_map(|n| wall(n, n))
        .collect()
}

#[test]
fn hits_are_those_of_trying_every_face() {
    let triangles = random(500, 1);
    let rays = Rays::new(&soup(&triangles));
    let mut state = 2;
    for _ in 0..500 {
        let mut point = || DVec3::from_array([(); 3].map(|()| uniform(&mut state)));
        let (origin, direction) = (point(), point() - DVec3::splat(0.5));
        let all = triangles
            .iter()
            .enumerate()
            .filter_map(|(f, &t)| Some((crossing(origin, direction, t)?, f as u32)))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let hit = rays.closest_hit(origin, direction, f64::INFINITY, NONE);
        assert_eq!(hit.map(|h| (h.distance, h.face)), all);
        assert_eq!(rays.any_hit(origin, direction, f64::INFINITY, NONE), all.is_some());
        if let Some((distance, _)) = all {
            assert!(!rays.any_hit(origin, direction, 0.999 * distance, NONE));
        }
    }
}

#[test]
fn near_faces_are_those_of_trying_every_face() {
    let triangles = random(300, 3);
    let rays = Rays::new(&soup(&triangles));
    let point = DVec3::splat(0.4);
    let mut near = vec![];
    rays.visit_within(point, 0.1, |f, _| near.push(f));
    near.sort_unstable();
    let all: Vec<u32> = (0..300)
        .filter(|&f| nearest_on_triangle(point, triangles[f as usize]).distance(point) <= 0.1)
        .collect();
    assert!(!all.is_empty());
    assert_eq!(near, all);
}

#[test]
fn visibility_is_one_outside_and_none_inside_a_closed_box() {
    let rays = Rays::new(&soup(&closed_box()));
    let see = |p: DVec3, n: DVec3| rays.ambient_visibility(p, n, 64, 7, NONE);
    assert_eq!(see(DVec3::X, DVec3::X), 1.0);
    assert_eq!(see(DVec3::X, -DVec3::X), 0.0);
    assert_eq!(see(DVec3::ZERO, DVec3::Y), 0.0);
}

#[test]
fn visibility_beside_an_endless_wall_is_one_half() {
    // The floor point sees a tall wall at distance 0+: half of the cosine-weighted sky.
    let tall = |t: [DVec3; 3]| t.map(|p| p * 1e4);
    let triangles: Vec<_> = wall(DVec3::X * 1e-6, DVec3::X).into_iter().map(tall).collect();
    let rays = Rays { lift: 1e-6, ..Rays::new(&soup(&triangles)) };
    let seen = rays.ambient_visibility(DVec3::ZERO, DVec3::Z, 4096, 1, NONE);
    assert!((seen - 0.5).abs() < 0.01, "{seen}");
}

#[test]
fn the_paired_sheet_hides_nothing() {
    let [a, b] = wall(DVec3::ZERO, DVec3::Z);
    let turn = |t: [DVec3; 3]| [t[0], t[2], t[1]];
    let mut surface = soup(&[a, b, turn(a), turn(b)]);
    surface.sheet_mate = vec![2, 3, 0, 1];
    let rays = Rays::new(&surface);
    let (p, down) = (surface.centroid(0) + DVec3::Z * 1e-3, -DVec3::Z);
    assert!(!rays.any_hit(p, down, 1.0, 0));
    assert!(rays.any_hit(p, down, 1.0, 1));
}

#[test]
fn large_faces_in_one_place_are_expected_to_cost_more() {
    let small = random(500, 5);
    let about = |t: &[DVec3; 3]| t.map(|p| (p - (t[0] + t[1] + t[2]) / 3.0) * 5.0);
    let large: Vec<_> = small.iter().map(about).collect();
    let visits = |t: &[[DVec3; 3]]| Rays::new(&soup(t)).expected_visits();
    assert!(visits(&small) > 1.0 && visits(&large) > 2.0 * visits(&small));
}

#[test]
fn rays_along_an_axis_pass_between_boxes() {
    let rays = Rays::new(&soup(&closed_box()));
    for (from, along) in [(DVec3::ZERO, DVec3::X), (DVec3::new(0.0, 1.0, 0.0), -DVec3::Z)] {
        let hit = rays.closest_hit(from, along, f64::INFINITY, NONE);
        assert!(hit.is_some_and(|h| (h.distance - 1.0).abs() < 1e-12), "{hit:?}");
    }
}

#[test]
fn nothing_to_hit_is_no_hit() {
    let rays = Rays::new(&Surface::default());
    assert!(!rays.any_hit(DVec3::ZERO, DVec3::X, f64::INFINITY, NONE));
    assert_eq!(rays.ambient_visibility(DVec3::ZERO, DVec3::X, 8, 0, NONE), 1.0);
}
