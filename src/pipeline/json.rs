//! Results as JSON.

use serde_json::Value;

use super::error::Cause;
use crate::contract::Metrics;

/// Digits of a figure in the file.
const DIGITS: usize = 9;

/// What a value is in JSON, for a document that is put together.
pub fn value(value: &impl serde::Serialize) -> Result<Value, Cause> {
    serde_json::to_value(value).map_err(unwritable)
}

pub fn file(metrics: &Metrics) -> Result<Vec<u8>, Cause> {
    serde_json::to_vec_pretty(&rounded(value(metrics)?)).map_err(unwritable)
}

/// The same with figures of at most [`DIGITS`] digits: more would only tell of rounding.
fn rounded(value: Value) -> Value {
    match value {
        Value::Number(number) if number.is_f64() => {
            let text = format!("{:.*e}", DIGITS - 1, number.as_f64().unwrap_or_default());
            text.parse::<f64>().map_or(Value::Number(number), Value::from)
        }
        Value::Array(items) => items.into_iter().map(rounded).collect(),
        Value::Object(map) => map.into_iter().map(|(key, inner)| (key, rounded(inner))).collect(),
        other => other,
    }
}

fn unwritable(error: serde_json::Error) -> Cause {
    Cause::Internal(format!("the result cannot be written as JSON: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::{ArtifactKind, Run};
    use crate::pipeline::{report, scenes};

    #[test]
    fn the_file_has_every_figure_with_nine_digits() {
        let (options, run) = (scenes::options(), Run::quiet());
        let (found, _, atlas) = scenes::atlas(&scenes::squares(2), &options, &run);
        let (scene, engine) = (scenes::scene(&scenes::squares(2)), scenes::engine());
        let result = report::whole(&scene, &found, &atlas, None, &options, &engine, &run).unwrap();
        let file = result.artifact(ArtifactKind::Metrics).unwrap();
        let read: Metrics = serde_json::from_slice(file).unwrap();
        let (told, own) = (read.summary.packing, result.metrics.summary.packing);
        assert!(told != own && (told - own).abs() < 1e-9, "{told} {own}");
        assert_eq!(read.without_cost().charts.len(), result.metrics.charts.len());
        fn numbers(value: &Value, found: &mut Vec<String>) {
            match value {
                Value::Number(number) if number.is_f64() => found.push(number.to_string()),
                Value::Array(items) => items.iter().for_each(|item| numbers(item, found)),
                Value::Object(map) => map.values().for_each(|item| numbers(item, found)),
                _ => {}
            }
        }
        let mut found = Vec::new();
        numbers(&serde_json::from_slice(file).unwrap(), &mut found);
        assert!(found.len() > 100);
        for number in found {
            let digits: String =
                number.split('e').next().unwrap().chars().filter(char::is_ascii_digit).collect();
            assert!(digits.trim_start_matches('0').len() <= 9, "{number}");
        }
    }
}
