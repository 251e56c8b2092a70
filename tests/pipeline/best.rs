//! More work is never worse: `quality = best` against `balanced`, in the objective of the charts and in the
//! share of the page that is covered, over the samples and ten bodies that are made for it.

use uvsegnet::contract::{Quality, UnwrapOptions};
use uvsegnet::synth::{self, SynthKind, SynthStyle, SynthVariant};

use super::{SAMPLES, example, unwrap};

/// Coverage is measured on single-precision coordinates.
const ROUNDING: f64 = 1e-7;

fn assert_no_worse(name: &str, bytes: &[u8]) {
    let by = |quality| {
        let options =
            UnwrapOptions { quality, steps: 10, points: 64, width: 16, ..Default::default() };
        let atlas = unwrap(bytes, None, &options).unwrap().metrics.atlas;
        (atlas.objective, atlas.packing_efficiency.covered)
    };
    let (best, balanced) = (by(Quality::Best), by(Quality::Balanced));
    assert!(best.0 <= balanced.0, "{name}: {best:?} against {balanced:?}");
    assert!(best.1 >= balanced.1 - ROUNDING, "{name}: {best:?} against {balanced:?}");
}

#[test]
fn best_is_never_worse_than_balanced_on_the_samples() {
    for name in SAMPLES {
        assert_no_worse(name, &std::fs::read(example(name)).unwrap());
    }
}

#[test]
fn best_is_never_worse_than_balanced_on_bodies_made_for_it() {
    let kinds = SynthKind::ALL.iter().cycle().take(10);
    for (seed, kind) in (11..).zip(kinds) {
        let style = SynthStyle { variant: SynthVariant::SingleMesh, triangles: 300 };
        assert_no_worse(kind.as_str(), &synth::make(*kind, seed, style).glb());
    }
}
