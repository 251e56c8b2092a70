//! Time of one training step: 8 charts of 512 vertices, mappers of width 64, both mappers and all
//! losses, in either form. `cargo bench --bench training`.

use glam::{DVec2, DVec3};
use uvsegnet::contract::{LossForm, Run};
use uvsegnet::device::Device;
use uvsegnet::flatten::{Disk, UvMap};
use uvsegnet::parameterization::{TrainChart, TrainOptions, train};

const CHARTS: u64 = 8;
/// 32 × 16 vertices.
const GRID: [u32; 2] = [31, 15];

/// A strip of a barrel, bent both ways, with its parameters for a start map.
fn barrel() -> (Disk, UvMap) {
    let [columns, rows] = GRID;
    let (mut positions, mut start, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for j in 0..=rows {
        for i in 0..=columns {
            let (u, v) = (f64::from(i) / f64::from(columns), f64::from(j) / f64::from(rows));
            let (angle, height) = (2.4 * (u - 0.5), v - 0.5);
            let radius = 1.0 - 0.9 * height * height;
            positions.push(DVec3::new(radius * angle.sin(), height, radius * angle.cos()));
            start.push(DVec2::new(1.6 * u, v + 0.15 * u * u));
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

/// Steps of one sample; the preparation before the first is part of it.
const STEPS: u32 = 20;

#[divan::bench(args = [LossForm::Sound, LossForm::Paper], sample_count = 7, sample_size = 1)]
fn twenty_steps_of_8_charts_of_512_points(bencher: divan::Bencher, form: LossForm) {
    let (disk, start) = barrel();
    let n = disk.positions.len();
    let chart = |id| TrainChart {
        disk: &disk,
        start: &start,
        normals: disk.positions.iter().map(|p| DVec3::new(p.x, 0.0, p.z).normalize()).collect(),
        rho: vec![0.0; n],
        boundary: vec![0.0; n],
        crease: vec![0.0; n],
        cylinder: None,
        over_cut: None,
        id,
    };
    let charts: Vec<TrainChart> = (0..CHARTS).map(chart).collect();
    let (width, points, seed, wall_share) = (64, 512, 0, 1e9);
    let options = TrainOptions { width, steps: STEPS, points, seed, form, wall_share };
    let device = Device::cpu();
    bencher.counter(divan::counter::ItemsCount::new(STEPS)).bench_local(|| {
        let mut told = |_: u32, _: u32, _: &[usize]| {};
        train(&charts, &options, &device, &Run::quiet(), &mut told).expect("nothing cancels it")
    });
}

/// As in the program.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() {
    divan::main();
}
