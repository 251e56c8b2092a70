//! Whole jobs on the samples, from bytes to artifacts, with default options.
//! `cargo bench --bench pipeline`. Where the time of a job goes stands in its own metrics (`cost`);
//! `stages` measures each stage by itself.

use uvsegnet::contract::{Limits, MeshKind, Quality, Run, UnwrapOptions};
use uvsegnet::device::Device;
use uvsegnet::pipeline::{Engine, Input, unwrap_input};

const SAMPLES: [&str; 5] = ["chair", "chair_small", "table", "laptop", "skateboard"];

fn job(bencher: divan::Bencher, sample: &str, quality: Quality) {
    let path = format!("{}/examples/{sample}.glb", env!("CARGO_MANIFEST_DIR"));
    let bytes = std::fs::read(path).expect("the samples are in the tree");
    let input = Input::new(MeshKind::Glb, &bytes);
    let options = UnwrapOptions { quality, ..Default::default() };
    let (limits, engine) = (Limits::default(), Engine::new(Device::cpu()));
    bencher.bench_local(|| {
        unwrap_input(&input, &options, &limits, &engine, &Run::quiet()).expect("samples are sound")
    });
}

#[divan::bench(args = SAMPLES, sample_count = 5, sample_size = 1)]
fn balanced(bencher: divan::Bencher, sample: &str) {
    job(bencher, sample, Quality::Balanced);
}

#[divan::bench(args = SAMPLES, sample_count = 5, sample_size = 1)]
fn fast(bencher: divan::Bencher, sample: &str) {
    job(bencher, sample, Quality::Fast);
}

/// As in the program.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() {
    divan::main();
}
