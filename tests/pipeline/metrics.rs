//! What metrics.json says of two samples, figure by figure: tests/pipeline/snapshots holds it. A change that
//! means to change it is accepted with `INSTA_UPDATE=always cargo test --release --test pipeline metrics`.

use serde_json::Value;
use uvsegnet::contract::{ArtifactKind, Quality, StopAfter, UnwrapOptions};

use super::{quick, unwrap_example};

/// The metrics, without what depends on the run, the release and the weights, and with numbers of six digits:
/// the rest of them is the processor's.
fn metrics(name: &str, options: &UnwrapOptions) -> Value {
    let result = unwrap_example(name, options);
    let json = result.artifact(ArtifactKind::Metrics).unwrap();
    let mut metrics: Value = serde_json::from_slice(json).unwrap();
    for key in ["cost", "engine", "weights"] {
        assert!(!metrics[key].is_null(), "{key}");
        metrics[key] = "…".into();
    }
    metrics["summary"]["seconds"] = "…".into();
    round(&mut metrics, 6);
    metrics
}

/// What comes out of the network, in single precision: processors differ in the sixth digit, and with two
/// none of these numbers is near where rounding goes up or down.
const HEARD: [&str; 3] = ["boundary", "confidence", "name_confidence"];

/// Round every number to so many significant digits, and to a millionth; to two what the network says.
fn round(value: &mut Value, digits: usize) {
    match value {
        Value::Number(number) if number.is_f64() => {
            let exact = number.as_f64().unwrap();
            let short: f64 = format!("{exact:.*e}", digits - 1).parse().unwrap();
            // Adding 0 makes one of the two zeros.
            *value = ((short * 1e6).round() / 1e6 + 0.0).into();
        }
        Value::Array(values) => values.iter_mut().for_each(|value| round(value, digits)),
        Value::Object(entries) => {
            for (key, value) in entries.iter_mut() {
                round(value, if HEARD.contains(&key.as_str()) { 2 } else { digits });
            }
        }
        _ => {}
    }
}

#[test]
fn of_a_whole_job() {
    let options = UnwrapOptions { quality: Quality::Fast, ..quick() };
    insta::assert_yaml_snapshot!(metrics("chair_small.glb", &options));
}

#[test]
fn of_a_job_that_ends_with_its_parts() {
    let options = UnwrapOptions { stop_after: Some(StopAfter::Segmentation), ..quick() };
    insta::assert_yaml_snapshot!(metrics("chair_fused.glb", &options));
}
