//! The same bytes at any number of threads, in whatever order their tasks end.

use uvsegnet::contract::UnwrapOptions;
use uvsegnet::pipeline::{STACK, Unwrapped};
use uvsegnet::synth::body::{self, BodyStyle};
use uvsegnet::synth::{BodyKind, NoiseKind};
use uvsegnet::tasks;

use super::{example, quick, unwrap};

/// Unwrap with one thread, and with two, three and eight whose tasks end in disorder.
fn assert_same(name: &str, bytes: &[u8], options: &UnwrapOptions) {
    let at = |threads: usize| -> Unwrapped {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK);
        pool.build().unwrap().install(|| unwrap(bytes, None, options).unwrap())
    };
    let one = at(1);
    assert!(one.metrics.deterministic, "{name}: the clock stepped in");
    for (threads, seed) in [(2, 1), (3, 2), (8, 3)] {
        tasks::disturb(seed);
        let other = at(threads);
        tasks::disturb(0);
        let differences = one.differences(&other);
        assert!(differences.is_empty(), "{name}, {threads} threads: {differences:?} differ");
    }
}

#[test]
fn samples_are_the_same_bytes_at_any_number_of_threads() {
    for name in ["chair_small.glb", "chair_fused.glb"] {
        assert_same(name, &std::fs::read(example(name)).unwrap(), &quick());
    }
}

/// One below the size from which a proxy stands for it, a noisy one, and one whose charts are large enough for
/// conjugate gradients.
#[test]
fn bodies_are_the_same_bytes_at_any_number_of_threads() {
    for (kind, triangles, noise) in
        [(BodyKind::Hand, 6_000, 0.0), (BodyKind::Vase, 20_000, 0.25), (BodyKind::Mug, 60_000, 0.0)]
    {
        let noise_kind = NoiseKind::default();
        let style = BodyStyle { triangles, noise, noise_kind, seed: 1, copies: 1 };
        let bytes = body::make(kind, style).glb(kind.as_str());
        let name = format!("{} of {triangles}", kind.as_str());
        assert_same(&name, &bytes, &UnwrapOptions { preview: false, ..quick() });
    }
}
