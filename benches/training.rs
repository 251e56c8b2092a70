//! Time of one training step: 8 charts of 512 vertices, mappers of width 64, both mappers and all
//! losses, in either form. `cargo bench --bench training`.

#[path = "../tests/shared/barrel.rs"]
mod barrel;

use barrel::Barrel;
use uvsegnet::contract::{LossForm, Run, Stage};
use uvsegnet::device::Device;
use uvsegnet::parameterization::{TrainChart, TrainOptions, train};

const CHARTS: u64 = 8;
/// 32 × 16 vertices.
const QUADS: [u32; 2] = [31, 15];

/// Steps of one sample; the preparation before the first is part of it.
const STEPS: u32 = 20;

#[divan::bench(args = [LossForm::Sound, LossForm::Paper], sample_count = 7, sample_size = 1)]
fn twenty_steps_of_8_charts_of_512_points(bencher: divan::Bencher, form: LossForm) {
    let [columns, rows] = QUADS;
    let barrel = Barrel::new(columns, rows);
    let charts: Vec<TrainChart> = (0..CHARTS).map(|id| barrel.chart(id)).collect();
    let (width, points, seed, stage) = (64, 512, 0, Stage::Train);
    let options = TrainOptions { width, steps: STEPS, points, seed, form, stage };
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
