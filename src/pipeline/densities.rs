//! The option `density` on the parts of an object.

use crate::contract::{OptionError, UnwrapOptions, density_weights};
use crate::segmentation::Part;

/// Parts that an error names, at most.
const NAMED: usize = 20;

/// Texel density of each part relative to the others. A key that is the number of a part means that
/// part, any other the parts of that name.
pub fn densities(parts: &[Part], options: &UnwrapOptions) -> Result<Vec<f64>, OptionError> {
    let wrong = |detail| OptionError { pointer: "/density".into(), detail };
    let asked = density_weights(options.density.as_deref().unwrap_or_default())
        .map_err(|want| wrong(format!("must be {want}")))?;
    let mut densities = vec![1.0; parts.len()];
    for (key, factor) in asked {
        let number = parts.iter().position(|p| p.id.to_string() == key);
        let named = (0..parts.len()).filter(|&i| parts[i].name == key);
        let meant: Vec<usize> = number.map_or_else(|| named.collect(), |i| vec![i]);
        if meant.is_empty() {
            let known: Vec<String> =
                parts.iter().take(NAMED).map(|p| format!("{} ({})", p.id, p.name)).collect();
            let more = if parts.len() > NAMED { ", \u{2026}" } else { "" };
            let known = known.join(", ");
            return Err(wrong(format!("there is no part {key:?}; the parts are {known}{more}")));
        }
        meant.into_iter().for_each(|i| densities[i] = factor);
    }
    Ok(densities)
}
