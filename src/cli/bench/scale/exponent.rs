//! How a figure grows with the number of triangles: the exponent of the power that fits it best.

/// Slope of the line of least squares through the logarithms; `None` for fewer than two sizes.
pub fn exponent(points: &[(f64, f64)]) -> Option<f64> {
    let logs: Vec<(f64, f64)> =
        points.iter().filter(|p| p.0 > 0.0 && p.1 > 0.0).map(|p| (p.0.ln(), p.1.ln())).collect();
    let count = logs.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let over: f64 = logs.iter().map(|p| (p.0 - x) * (p.0 - x)).sum();
    let with: f64 = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    (over > 1e-9).then(|| with / over)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_has_its_exponent_and_one_size_none() {
        let points: Vec<(f64, f64)> =
            [1e3, 2e4, 3e5].iter().map(|&n: &f64| (n, 3.0 * n.powf(1.25))).collect();
        assert!((exponent(&points).unwrap() - 1.25).abs() < 1e-12);
        assert_eq!(exponent(&points[..1]), None);
        assert_eq!(exponent(&[(5.0, 1.0), (5.0, 2.0)]), None);
    }
}
