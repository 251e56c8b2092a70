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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::SegmentationSource;

    /// Parts 0 to 3: a seat, two legs of one name, and one whose name is the number of another.
    fn parts() -> Vec<Part> {
        let source = SegmentationSource::Authored;
        let part = |(id, name): (u32, &str)| Part {
            id,
            name: name.into(),
            source,
            confidence: 1.0,
            name_confidence: None,
        };
        (0..).zip(["seat", "leg", "leg", "0"]).map(part).collect()
    }

    fn asked(density: Option<&str>) -> Result<Vec<f64>, OptionError> {
        let density = density.map(str::to_owned);
        densities(&parts(), &UnwrapOptions { density, ..Default::default() })
    }

    #[test]
    fn a_number_is_one_part_and_a_name_all_of_that_name() {
        assert_eq!(asked(None).unwrap(), [1.0; 4]);
        assert_eq!(asked(Some("leg=2,3=0.5")).unwrap(), [1.0, 2.0, 2.0, 0.5]);
        // A number comes before a name.
        assert_eq!(asked(Some("0=4")).unwrap(), [4.0, 1.0, 1.0, 1.0]);
        assert_eq!(asked(Some("leg=2,1=3")).unwrap(), [1.0, 3.0, 2.0, 1.0], "the later one holds");
    }

    #[test]
    fn a_key_of_no_part_is_an_error_that_names_the_parts() {
        let error = asked(Some("seat=2,arm=3")).unwrap_err();
        assert_eq!(error.pointer, "/density");
        let said = "there is no part \"arm\"; the parts are 0 (seat), 1 (leg), 2 (leg), 3 (0)";
        assert_eq!(error.detail, said);
        assert!(asked(Some("seat")).unwrap_err().detail.starts_with("must be "));
    }
}
