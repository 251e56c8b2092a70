//! The plot of the scale benchmark: seconds over triangles, a curve a program and noise or number of pieces
//! (geometric means over the bodies).

use std::collections::BTreeMap;

use super::body::Row;
use super::table::{curve, measured};
use crate::cli::bench::plot::{self, Curve};

/// Draw it.
pub fn plot(rows: &[Row]) -> String {
    let mut curves: BTreeMap<String, BTreeMap<u32, Vec<(f64, f64)>>> = BTreeMap::new();
    for (row, f) in measured(rows) {
        let point = (f.triangles as f64, f.seconds);
        curves.entry(curve(row)).or_default().entry(row.case.triangles).or_default().push(point);
    }
    let mean = |points: &Vec<(f64, f64)>| {
        let of = |of: fn(&(f64, f64)) -> f64| {
            (points.iter().map(|p| of(p).ln()).sum::<f64>() / points.len() as f64).exp()
        };
        (of(|p| p.0), of(|p| p.1))
    };
    let curves: Vec<Curve> = curves
        .into_iter()
        .map(|(name, sizes)| (name, sizes.values().map(mean).collect()))
        .collect();
    plot::plot(&curves, "triangles", " s")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::bench::scale::table::tests::rows;

    #[test]
    fn a_power_is_a_straight_line_between_the_decades() {
        let svg = plot(&rows(40.0));
        // 10^5 to 10^6 triangles and 1 to 100 seconds: a point on the left and one on the right margin.
        assert!(svg.contains("<polyline points=\"70.0,391.5 830.0,161.5\""), "{svg}");
        assert_eq!(svg.matches("<circle").count(), 2);
        assert!(svg.contains(">this, noise 0.00</text>") && svg.ends_with("</svg>\n"));
        assert_eq!(plot(&[]), "<svg xmlns=\"http://www.w3.org/2000/svg\"/>\n");
    }
}
