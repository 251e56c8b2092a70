//! The option `density`: relative texel densities of parts, written as `0=2,seat=0.5`.

/// Least and greatest factor.
const RANGE: std::ops::RangeInclusive<f64> = 0.01..=100.0;

/// Parts, by number or name, and their factors, in the order given. The error says what would be
/// right.
pub fn weights(text: &str) -> Result<Vec<(&str, f64)>, String> {
    let mut weights: Vec<(&str, f64)> = Vec::new();
    for entry in text.split(',').filter(|e| !e.trim().is_empty()) {
        let (part, factor) = entry
            .rsplit_once('=')
            .map(|(part, factor)| (part.trim(), factor.trim()))
            .filter(|(part, _)| !part.is_empty())
            .ok_or("parts and factors, as in 0=2,seat=0.5")?;
        let factor = factor.parse().ok().filter(|f| RANGE.contains(f));
        let factor = factor.ok_or_else(|| format!("a factor from 0.01 to 100 for {part:?}"))?;
        if weights.iter().any(|w| w.0 == part) {
            return Err(format!("one factor for {part:?}"));
        }
        weights.push((part, factor));
    }
    Ok(weights)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_and_factors_are_read() {
        assert_eq!(weights(" 0=2, left = leg=0.5 ,"), Ok(vec![("0", 2.0), ("left = leg", 0.5)]));
        assert_eq!(weights(""), Ok(Vec::new()));
        for wrong in ["seat", "=2", "seat=", "seat=nan", "seat=0", "a=1,a=1"] {
            assert!(weights(wrong).is_err(), "{wrong}");
        }
    }
}
