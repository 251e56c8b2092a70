//! Time of one training step: 8 charts of 512 vertices, mappers of width 64, both mappers and all
//! losses, in either form. `cargo bench --bench training`.

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
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

fn step(c: &mut Criterion) {
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
    let device = Device::cpu();
    for form in [LossForm::Sound, LossForm::Paper] {
        c.bench_function(&format!("training step, {CHARTS} × {n} × 64, {form}"), |b| {
            b.iter_custom(|steps| {
                // Only the steps count, not the preparation before the first or the Chamfer distance
                // after the last; 3/5 of the steps are sure to be taken.
                let asked = u32::try_from(2 * steps).unwrap_or(u32::MAX).max(8);
                let options = TrainOptions {
                    width: 64,
                    steps: asked,
                    points: 512,
                    seed: 0,
                    form,
                    wall_share: 1e9,
                };
                let (mut begun, mut taken) = (Instant::now(), Duration::ZERO);
                let mut told = |step: u32, _: u32, _: &[usize]| {
                    if step == 0 {
                        begun = Instant::now();
                    } else if u64::from(step) == steps {
                        taken = begun.elapsed();
                    }
                };
                let trained = train(&charts, &options, &device, &Run::quiet(), &mut told);
                black_box(trained.expect("nothing cancels a quiet run"));
                taken
            });
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10).measurement_time(Duration::from_secs(15));
    targets = step
}
criterion_main!(benches);
