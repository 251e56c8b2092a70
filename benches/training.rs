//! Time of one training step: 8 charts of 512 vertices, mappers of width 64, both mappers and all
//! losses, in either form; and of each loss alone. `cargo bench --bench training`.

#[path = "../tests/shared/barrel.rs"]
mod barrel;

use barrel::Barrel;
use glam::DVec2;
use uvsegnet::contract::{LossForm, Run, Stage};
use uvsegnet::device::Device;
use uvsegnet::parameterization::losses::{Annealing, ChartTerms, LossContext, Term, TermValues};
use uvsegnet::parameterization::{TrainChart, TrainOptions, train};

const CHARTS: u64 = 8;
/// 32 × 16 vertices.
const QUADS: [u32; 2] = [31, 15];

/// Steps of one sample; the preparation before the first is part of it.
const STEPS: u32 = 20;

#[divan::bench(args = [LossForm::Sound, LossForm::Paper], sample_count = 7, sample_size = 1)]
fn twenty_steps_of_8_charts_of_512_points(bencher: divan::Bencher, form: LossForm) {
    let barrel = barrel();
    let charts: Vec<TrainChart> = (0..CHARTS).map(|id| barrel.chart(id)).collect();
    let (width, points, seed, stage) = (64, 512, 0, Stage::Train);
    let options = TrainOptions { width, steps: STEPS, points, seed, form, stage };
    let device = Device::cpu();
    bencher.counter(divan::counter::ItemsCount::new(STEPS)).bench_local(|| {
        let mut told = |_: u32, _: u32, _: &[usize]| {};
        train(&charts, &options, &device, &Run::quiet(), &mut told).expect("nothing cancels it")
    });
}

/// The losses of a form that such a chart has; none of them: the scale of the map alone.
fn losses() -> Vec<(LossForm, Option<Term>)> {
    let of = |form| {
        let terms = terms(&barrel(), form);
        let has: Vec<Term> = Term::ALL.into_iter().filter(|&term| terms.has(term)).collect();
        has.into_iter().map(move |term| (form, Some(term))).chain([(form, None)])
    };
    [LossForm::Sound, LossForm::Paper].into_iter().flat_map(of).collect()
}

fn barrel() -> Barrel {
    let [columns, rows] = QUADS;
    Barrel::new(columns, rows)
}

fn terms(barrel: &Barrel, form: LossForm) -> ChartTerms {
    ChartTerms::new(barrel.chart(0).disk, LossContext { form, ..Default::default() })
}

#[divan::bench(args = losses())]
fn a_loss_and_its_gradient(bencher: divan::Bencher, (form, term): &(LossForm, Option<Term>)) {
    let barrel = barrel();
    let terms = terms(&barrel, *form);
    let mut weights = TermValues::default();
    if let Some(term) = term {
        weights[*term as usize] = 1.0;
    }
    let mut gradient = vec![DVec2::ZERO; barrel.start.len()];
    bencher.bench_local(|| {
        let (uv, at) = (&barrel.start, Annealing::at(0.0));
        terms.evaluate_sum(&weights, uv, terms.scale(uv), at, &mut gradient)
    });
}

/// As in the program.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() {
    divan::main();
}
