//! A plot of curves on two logarithmic axes, as SVG.

use std::fmt::Write;

/// Width, height and margin, user units.
const SIZE: [f64; 2] = [900.0, 600.0];
const MARGIN: f64 = 70.0;

const COLORS: [&str; 8] =
    ["#1f77b4", "#d62728", "#2ca02c", "#9467bd", "#ff7f0e", "#8c564b", "#17becf", "#7f7f7f"];

/// A name, and points.
pub type Curve = (String, Vec<(f64, f64)>);

/// What a value may lie beyond a decade by rounding alone.
const ROUNDING: f64 = 1e-6;

/// Decades that hold every value.
fn decades(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let low = (values.clone().fold(f64::INFINITY, f64::min).log10() + ROUNDING).floor();
    let high = (values.fold(0.0, f64::max).log10() - ROUNDING).ceil();
    [low, high.max(low + 1.0)]
}

/// Draw it. `across`: what the horizontal axis shows; `unit`: what follows a number of the other.
pub fn plot(curves: &[Curve], across: &str, unit: &str) -> String {
    let all = || curves.iter().flat_map(|(_, points)| points.iter().copied());
    if all().next().is_none() {
        return "<svg xmlns=\"http://www.w3.org/2000/svg\"/>\n".to_owned();
    }
    let (wide, up) = (decades(all().map(|p| p.0)), decades(all().map(|p| p.1)));
    let place = |x: f64, y: f64| {
        let share = |v: f64, [low, high]: [f64; 2]| (v.log10() - low) / (high - low);
        let (x, y) = (share(x, wide), share(y, up));
        (MARGIN + x * (SIZE[0] - 2.0 * MARGIN), SIZE[1] - MARGIN - y * (SIZE[1] - 2.0 * MARGIN))
    };
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" font-family=\"sans-serif\" \
         font-size=\"13\">\n<rect width=\"{0}\" height=\"{1}\" fill=\"#ffffff\"/>\n",
        SIZE[0], SIZE[1]
    );
    // Formatting into a string cannot fail.
    let mut line = |from: (f64, f64), to: (f64, f64), label: &str, anchor: &str, at: (f64, f64)| {
        let _ = writeln!(
            svg,
            "<path d=\"M{:.1} {:.1}L{:.1} {:.1}\" stroke=\"#d0d4da\"/><text x=\"{:.1}\" y=\"{:.1}\" \
             text-anchor=\"{anchor}\">{label}</text>",
            from.0, from.1, to.0, to.1, at.0, at.1
        );
    };
    for decade in wide[0] as i32..=wide[1] as i32 {
        let value = 10f64.powi(decade);
        let (foot, head) = (place(value, 10f64.powf(up[0])), place(value, 10f64.powf(up[1])));
        line(foot, head, &format!("{value}"), "middle", (foot.0, foot.1 + 20.0));
    }
    for decade in up[0] as i32..=up[1] as i32 {
        let value = 10f64.powi(decade);
        let (left, right) = (place(10f64.powf(wide[0]), value), place(10f64.powf(wide[1]), value));
        line(left, right, &format!("{value}{unit}"), "end", (left.0 - 8.0, left.1 + 4.0));
    }
    let _ = writeln!(
        svg,
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{across}</text>",
        0.5 * SIZE[0],
        SIZE[1] - 25.0
    );
    for (i, (name, points)) in curves.iter().enumerate() {
        let color = COLORS[i % COLORS.len()];
        let path: Vec<String> = points
            .iter()
            .map(|&(x, y)| {
                let (x, y) = place(x, y);
                format!("{x:.1},{y:.1}")
            })
            .collect();
        let _ = writeln!(
            svg,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2\"/>",
            path.join(" ")
        );
        for &(x, y) in points {
            let (x, y) = place(x, y);
            let _ = writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"{color}\"/>");
        }
        let _ = writeln!(
            svg,
            "<text x=\"{:.1}\" y=\"{:.1}\" fill=\"{color}\">{name}</text>",
            MARGIN + 10.0,
            MARGIN + 18.0 * i as f64
        );
    }
    svg + "</svg>\n"
}
