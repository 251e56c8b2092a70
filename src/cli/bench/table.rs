//! The table of the quality benchmark, from its lines.

use std::fmt::Write;
use std::path::Path;

use anyhow::{Context, Result};
use serde_json::Value;

/// An object is developable when this share of its area is, tubular when that share is.
const DEVELOPABLE: f64 = 0.9;
const TUBULAR: f64 = 0.5;

/// Counts as equal, of seam lengths and distortions that were summed in another order.
const ROUNDING: f64 = 1e-5;

/// Read the lines of a file.
pub fn read(path: &Path) -> Result<Vec<Value>> {
    let text =
        std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let lines = text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty());
    lines
        .map(|(i, l)| {
            serde_json::from_str(l)
                .with_context(|| format!("{} line {}: not JSON", path.display(), i + 1))
        })
        .collect()
}

/// One object in a line for the terminal.
pub fn brief(line: &Value) -> String {
    let name = line["object"].as_str().unwrap_or("?");
    if let Some(error) = line["error"].as_str() {
        return format!("{name}: {error}");
    }
    let (ours, peer) = (&line["ours"], &line["peer"]);
    format!(
        "{name}: {} triangles, {} charts (peer {}), seam {:.2} ({:.2}), symmetric Dirichlet {:.4} \
         ({:.4}), packing {:.2}, {:.1} s{}",
        line["triangles"],
        ours["charts"],
        peer["charts"],
        number(ours, "seam"),
        number(peer, "seam"),
        number(ours, "symmetric_dirichlet"),
        number(peer, "symmetric_dirichlet"),
        number(ours, "packing"),
        number(ours, "seconds"),
        if ours["valid"] == true { "" } else { ", NOT VALID" },
    )
}

/// The whole table, in Markdown.
pub fn table(lines: &[Value]) -> String {
    let unwrapped: Vec<&Value> = lines.iter().filter(|l| l["ours"].is_object()).collect();
    let mut text = format!(
        "{} objects, {} unwrapped, {} refused or failed\n\n",
        lines.len(),
        unwrapped.len(),
        lines.len() - unwrapped.len()
    );
    let classes: [Class; 4] = [
        ("developable", |share| share >= DEVELOPABLE),
        ("tubular", |share| (TUBULAR..DEVELOPABLE).contains(&share)),
        ("free-form", |share| share < TUBULAR),
        ("all", |_| true),
    ];
    let columns: Vec<Vec<&Value>> = classes
        .iter()
        .map(|(_, of)| {
            let own = |l: &&&Value| of(number(&l["ours"], "developable"));
            unwrapped.iter().filter(own).copied().collect()
        })
        .collect();
    let _ = writeln!(text, "| | {} |", classes.map(|c| c.0).join(" | "));
    let _ = writeln!(text, "|---|{}", "---|".repeat(classes.len()));
    for (name, figure) in ROWS {
        let cells: Vec<String> = columns.iter().map(|lines| figure(lines)).collect();
        let _ = writeln!(text, "| {name} | {} |", cells.join(" | "));
    }
    let failed = lines.iter().filter(|l| l["error"].is_string());
    for line in failed {
        let _ = writeln!(text, "\n{}", brief(line));
    }
    text
}

/// A class of objects: its name, and which shares of developable area belong to it.
type Class = (&'static str, fn(f64) -> bool);

/// A row: what it is called, and its figure over the objects of a class.
type Row = (&'static str, fn(&[&Value]) -> String);

const ROWS: [Row; 22] = [
    ("objects", |l| l.len().to_string()),
    ("valid", |l| count(l, |l| l["ours"]["valid"] == true)),
    ("valid by the independent measure", |l| {
        let measured: Vec<&Value> = l.iter().copied().filter(|l| l["judge"].is_object()).collect();
        count(&measured, |l| l["judge"]["meshes"][0]["validity"]["valid"] == true)
    }),
    ("symmetric Dirichlet, median", |l| quantile(l, 0.5, |l| ours(l, "symmetric_dirichlet"))),
    ("… 95th percentile", |l| quantile(l, 0.95, |l| ours(l, "symmetric_dirichlet"))),
    ("… of the peer, median", |l| {
        quantile(l, 0.5, |l| figure(&l["peer"], "symmetric_dirichlet"))
    }),
    ("σ1/σ2 − 1, median", |l| quantile(l, 0.5, |l| ours(l, "angular"))),
    ("area distortion − 1, median", |l| quantile(l, 0.5, |l| ours(l, "area"))),
    ("charts, median", |l| quantile(l, 0.5, |l| ours(l, "charts"))),
    ("charts / the peer's, median", |l| quantile(l, 0.5, |l| ratio(l, "charts", "charts"))),
    ("charts / the peer's on the raw mesh", |l| {
        quantile(l, 0.5, |l| ratio(l, "charts", "raw_charts"))
    }),
    ("seam / √area, median", |l| quantile(l, 0.5, |l| ours(l, "seam"))),
    ("seam / the peer's, median", |l| quantile(l, 0.5, |l| ratio(l, "seam", "seam"))),
    ("fewer charts and shorter seams at the peer's distortion", dominance),
    ("avoidable seam, median", |l| quantile(l, 0.5, |l| ours(l, "avoidable"))),
    ("part boundary that is seam, given labels, median", |l| {
        quantile(l, 0.5, |l| figure(&l["along_labels"]["alignment"], "recall"))
    }),
    ("… precision, F1, ceiling", |l| {
        ["precision", "f1", "ceiling"]
            .map(|name| quantile(l, 0.5, |l| figure(&l["along_labels"]["alignment"], name)))
            .join(", ")
    }),
    ("packing, median", |l| quantile(l, 0.5, |l| ours(l, "packing"))),
    ("narrowest gutter, texels", |l| quantile(l, 0.0, |l| ours(l, "min_gutter_texels"))),
    ("seconds, median", |l| quantile(l, 0.5, |l| ours(l, "seconds"))),
    ("seconds, longest", |l| quantile(l, 1.0, |l| ours(l, "seconds"))),
    ("gain of training, best", |l| quantile(l, 1.0, |l| ours(l, "gain"))),
];

fn figure(value: &Value, name: &str) -> Option<f64> {
    value[name].as_f64()
}

fn ours(line: &Value, name: &str) -> Option<f64> {
    figure(&line["ours"], name)
}

/// Our figure over the peer's; nothing where the peer has none.
fn ratio(line: &Value, name: &str, theirs: &str) -> Option<f64> {
    let peer = figure(&line["peer"], theirs).filter(|p| *p > 0.0)?;
    Some(ours(line, name)? / peer)
}

fn number(value: &Value, name: &str) -> f64 {
    figure(value, name).unwrap_or(f64::NAN)
}

fn count(lines: &[&Value], holds: fn(&Value) -> bool) -> String {
    format!("{} of {}", lines.iter().filter(|l| holds(l)).count(), lines.len())
}

/// A quantile over the objects that have the figure (nearest rank).
fn quantile(lines: &[&Value], share: f64, of: impl Fn(&Value) -> Option<f64>) -> String {
    let mut values: Vec<f64> = lines.iter().filter_map(|l| of(l)).collect();
    values.sort_by(f64::total_cmp);
    let rank = (share * values.len() as f64).ceil() as usize;
    match values.get(rank.saturating_sub(1)) {
        Some(x) if x.abs() >= 100.0 || x.fract() == 0.0 => format!("{x:.0}"),
        Some(x) if x.abs() < 1e-3 => format!("{x:.1e}"),
        Some(x) => format!("{x:.4}"),
        None => "–".into(),
    }
}

/// On how many objects we need fewer charts and shorter seams (or as few, where there is nothing to
/// save: one chart) with no more distortion than the peer.
fn dominance(lines: &[&Value]) -> String {
    let both: Vec<&Value> = lines
        .iter()
        .copied()
        .filter(|l| l["matched"].is_object() && l["peer"].is_object())
        .collect();
    count(&both, |l| dominates(&l["matched"], &l["peer"]))
}

/// Whether figures have fewer charts than the peer's, no longer seams and no more distortion.
pub fn dominates(ours: &Value, peer: &Value) -> bool {
    let charts = number(ours, "charts");
    number(ours, "symmetric_dirichlet") <= number(peer, "symmetric_dirichlet") + ROUNDING
        && (charts < number(peer, "charts") || charts == 1.0)
        && number(ours, "seam") <= number(peer, "seam") + ROUNDING
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn line(charts: u32, theirs: u32, developable: f64) -> Value {
        let side =
            |charts: u32| json!({ "charts": charts, "seam": 1.0, "symmetric_dirichlet": 1.0 });
        let mut ours = side(charts);
        ours["developable"] = developable.into();
        ours["valid"] = true.into();
        json!({ "object": "a", "triangles": 2, "ours": ours, "matched": side(charts), "peer": side(theirs) })
    }

    #[test]
    fn objects_are_counted_in_their_class() {
        let lines = [
            line(2, 4, 0.95),
            line(3, 4, 0.6),
            line(4, 4, 0.1),
            json!({"object": "b", "error": "no"}),
        ];
        let text = table(&lines);
        assert!(text.starts_with("4 objects, 3 unwrapped, 1 refused"));
        assert!(text.contains("| objects | 1 | 1 | 1 | 3 |"), "{text}");
        assert!(
            text.contains("| charts / the peer's, median | 0.5000 | 0.7500 | 1 | 0.7500 |"),
            "{text}"
        );
        let dominance = "fewer charts and shorter seams at the peer's distortion";
        assert!(
            text.contains(&format!("| {dominance} | 1 of 1 | 1 of 1 | 0 of 1 | 2 of 3 |")),
            "{text}"
        );
        assert!(text.contains("b: no"));
    }
}
