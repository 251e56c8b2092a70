//! What the descent promises: it reaches known optima, flips nothing and ends.

use super::*;
use crate::flatten::count_flips;
use crate::flatten::{certify, lscm, quality, samples, start_map, tutte};
use glam::DVec3;
use proptest::prelude::*;
use std::f64::consts::TAU;

fn run(disk: &Disk, start: &UvMap, iterations: u32) -> Slim {
    let options = SlimOptions { iterations, tolerance: 1e-7, ..Default::default() };
    Slim::descend(disk, start, &options, &Cancel::default()).unwrap()
}

#[test]
fn the_gradient_agrees_with_finite_differences() {
    let disk = samples::barrel(6, 4);
    let uv = tutte(&disk).unwrap();
    let mut descent = Descent::new(&disk, uv, &SlimOptions::default());
    let mut system = BlockSystem::new(descent.uv.len(), disk.triangles.clone()).unwrap();
    let gradient = descent.assemble(&mut system, true);
    for (v, force) in gradient.into_iter().enumerate() {
        for (axis, want) in [(DVec2::X, force.x), (DVec2::Y, force.y)] {
            let mut at = |h: f64| {
                let kept = descent.uv[v];
                descent.uv[v] += axis * h;
                let energy = descent.energy(&descent.uv);
                descent.uv[v] = kept;
                energy
            };
            let difference = (at(1e-6) - at(-1e-6)) / 2e-6;
            assert!((difference - want).abs() < 1e-5 * (1.0 + want.abs()), "{difference} {want}");
        }
    }
}

#[test]
fn a_cut_cylinder_reaches_the_isometry_from_tutte() {
    let disk = samples::tube(24, 8, TAU, 0.5, 0.5, 2.0);
    let slim = run(&disk, &tutte(&disk).unwrap(), 200);
    let q = quality(&disk, &slim.uv);
    assert!(slim.converged && q.mean - 1.0 < 1e-6, "{} {:?}", slim.energies.len(), q);
    assert!(certify(&disk, &slim.uv).is_injective());
}

#[test]
fn the_barrel_reaches_one_optimum_from_all_starts() {
    let disk = samples::barrel(32, 16);
    let from = |start: UvMap| {
        let slim = run(&disk, &start, 400);
        assert!(slim.energies.windows(2).all(|e| e[1] < e[0]), "monotone");
        assert!(certify(&disk, &slim.uv).is_injective());
        slim.energies[slim.energies.len() - 1]
    };
    let (conformal, circle) = (from(lscm(&disk).unwrap()), from(tutte(&disk).unwrap()));
    assert!((conformal - circle).abs() < 1e-5, "{conformal} {circle}");
    assert!(conformal < 1.02 && conformal > 1.001, "{conformal}");
}

#[test]
fn never_worse_than_the_start_and_at_the_area_of_the_surface() {
    let disk = samples::barrel(20, 10);
    let start = tutte(&disk).unwrap();
    for iterations in [0, 1, 3] {
        let slim = run(&disk, &start, iterations);
        assert!(quality(&disk, &slim.uv).mean <= quality(&disk, &start).mean);
        assert!((crate::flatten::scale(&disk, &slim.uv) - 1.0).abs() < 1e-9);
    }
}

#[test]
fn a_start_with_flips_comes_back() {
    let (disk, uv) = samples::plane(3, 3, 1.0, 1.0);
    let mut bad = uv;
    bad[5] = DVec2::new(0.9, 0.9);
    let back = slim(&disk, &bad, &SlimOptions::default(), &Cancel::default()).unwrap();
    assert!(count_flips(&disk, &back) > 0);
    assert!(run(&disk, &bad, 5).energies.is_empty());
}

#[test]
fn the_target_and_cancel_end_it() {
    let disk = samples::barrel(20, 10);
    let start = tutte(&disk).unwrap();
    let target = SlimOptions { target: Some(1.05), ..Default::default() };
    let slim = Slim::descend(&disk, &start, &target, &Cancel::default()).unwrap();
    assert!(slim.converged && *slim.energies.last().unwrap() <= 1.05);
    // Near the optimum no step promises to come to an isometry.
    let near = run(&disk, &start, 12).uv;
    let hopeless = SlimOptions { give_up: Some(2.5), newton: true, ..Default::default() };
    let slim = Slim::descend(&disk, &near, &hopeless, &Cancel::default()).unwrap();
    assert!(!slim.converged && slim.energies.len() == 1, "{:?}", slim.energies);
    let cancel = Cancel::default();
    cancel.cancel();
    assert_eq!(Slim::descend(&disk, &start, &target, &cancel), Err(Canceled));
}

#[test]
fn keeping_the_boundary_simple_keeps_the_map_injective() {
    // A flat strip wound 1.3 times: its isometry overlaps.
    let disk = samples::bent(64, 3, |x, y| {
        let radius = 0.6 + y;
        let spiral = DVec2::from_angle(1.3 * TAU * x) * radius;
        spiral.extend(0.0)
    });
    let start = tutte(&disk).unwrap();
    let free = run(&disk, &start, 100);
    assert!(!certify(&disk, &free.uv).simple_boundary);
    let options = SlimOptions { iterations: 100, keep_simple: true, ..Default::default() };
    let kept = Slim::descend(&disk, &start, &options, &Cancel::default()).unwrap();
    assert!(certify(&disk, &kept.uv).is_injective());
    assert!(quality(&disk, &kept.uv).mean < quality(&disk, &start).mean);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn descent_is_monotone_and_never_flips(
        seed in prop::collection::vec(-0.3..0.3f64, 64),
        squeeze in -6.0..0.0f64,
    ) {
        // Slivers included: the grid is squeezed by up to 1e-6.
        let disk = samples::bent(7, 7, |x, y| {
            let k = (7.0 * y).round() as usize * 8 + (7.0 * x).round() as usize;
            DVec3::new(x, y * 10f64.powf(squeeze), seed[k] * 10f64.powf(squeeze))
        });
        let (start, _) = start_map(&disk, None);
        let slim = run(&disk, &start, 30);
        prop_assert!(slim.energies.windows(2).all(|e| e[1] < e[0]));
        prop_assert_eq!(count_flips(&disk, &slim.uv), 0);
        prop_assert!(quality(&disk, &slim.uv).mean <= quality(&disk, &start).mean);
        prop_assert_eq!(&run(&disk, &start, 30), &slim);
    }
}
