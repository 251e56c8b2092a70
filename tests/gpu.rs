//! The GPU against the CPU: one small seeded chart is trained on both, and the maps agree. Built with
//! the feature `gpu` only (`tests/run --gpu`); software Vulkan will do.
#![cfg(feature = "gpu")]

use glam::{DVec2, DVec3};
use uvsegnet::contract::{LossForm, Run};
use uvsegnet::device::{self, Device, DeviceChoice};
use uvsegnet::flatten::{Disk, UvMap};
use uvsegnet::parameterization::{TrainChart, TrainOptions, train};

/// A strip of a barrel, 12 × 8 vertices, and a skewed start.
fn barrel() -> (Disk, UvMap) {
    let (columns, rows) = (11u32, 7u32);
    let (mut positions, mut start, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for j in 0..=rows {
        for i in 0..=columns {
            let (u, v) = (f64::from(i) / f64::from(columns), f64::from(j) / f64::from(rows));
            let (angle, height) = (2.0 * (u - 0.5), v - 0.5);
            let radius = 1.0 - 0.8 * height * height;
            positions.push(DVec3::new(radius * angle.sin(), height, radius * angle.cos()));
            start.push(DVec2::new(1.5 * u, v + 0.1 * u * u));
        }
    }
    for j in 0..rows {
        for i in 0..columns {
            let a = j * (columns + 1) + i;
            let above = a + columns + 1;
            triangles.extend([[a, a + 1, above + 1], [a, above + 1, above]]);
        }
    }
    (Disk::new(positions, triangles), start)
}

#[test]
fn both_devices_train_the_same_map() {
    let gpu = device::choose(&"gpu".parse::<DeviceChoice>().unwrap()).unwrap();
    device::probe(&gpu).unwrap();
    let (disk, start) = barrel();
    let n = disk.positions.len();
    let chart = TrainChart {
        disk: &disk,
        start: &start,
        normals: disk.positions.iter().map(|p| DVec3::new(p.x, 0.0, p.z).normalize()).collect(),
        rho: vec![0.0; n],
        boundary: vec![0.0; n],
        crease: vec![0.0; n],
        cylinder: None,
        over_cut: None,
        id: 1,
    };
    let (form, wall_share) = (LossForm::Sound, 1e9);
    let options = TrainOptions { width: 16, steps: 6, points: 96, seed: 3, form, wall_share };
    let on = |device: &Device| {
        let mut told = |_: u32, _: u32, _: &[usize]| {};
        train(std::slice::from_ref(&chart), &options, device, &Run::quiet(), &mut told).unwrap()
    };
    let (here, there) = (on(&Device::cpu()), on(&gpu));
    let apart =
        here[0].uv.iter().zip(&there[0].uv).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    assert!(apart < 1e-4, "the maps are {apart} apart on a chart 1.5 across");
    assert!(
        here[0].uv.iter().zip(&start).any(|(a, b)| a.distance(*b) > 1e-3),
        "nothing was learned"
    );
}
