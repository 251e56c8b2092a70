//! The table of the quality benchmark, from its lines.

use std::fmt::Write;

use super::row::{Measured, Row};
use crate::contract::BoundaryAlignment;

/// An object is developable when this share of its area is, tubular when that share is.
const DEVELOPABLE: f64 = 0.9;
const TUBULAR: f64 = 0.5;

/// One object in a line for the terminal.
pub fn brief(row: &Row) -> String {
    let name = &row.object;
    let Some(m) = &row.measured else {
        return format!("{name}: {}", row.error.as_deref().unwrap_or("no figures"));
    };
    let (ours, peer) = (&m.ours, m.peer.as_ref());
    let number = |x: Option<f64>| x.unwrap_or(f64::NAN);
    format!(
        "{name}: {} triangles, {} charts (peer {}), seam {:.2} ({:.2}), symmetric Dirichlet {:.4} \
         ({:.4}), packing {:.2}, {:.1} s{}",
        m.triangles,
        ours.charts,
        peer.map_or("none".into(), |p| p.charts.to_string()),
        number(ours.seam),
        number(peer.map(|p| p.seam)),
        number(ours.symmetric_dirichlet),
        number(peer.map(|p| p.symmetric_dirichlet)),
        ours.packing,
        ours.seconds,
        if ours.valid { "" } else { ", NOT VALID" },
    )
}

/// The whole table, in Markdown.
pub fn table(rows: &[Row]) -> String {
    let unwrapped: Vec<&Measured> = rows.iter().filter_map(|r| r.measured.as_ref()).collect();
    let mut text = format!(
        "{} objects, {} unwrapped, {} refused or failed\n\n",
        rows.len(),
        unwrapped.len(),
        rows.len() - unwrapped.len()
    );
    let classes: [Class; 4] = [
        ("developable", |share| share >= DEVELOPABLE),
        ("tubular", |share| (TUBULAR..DEVELOPABLE).contains(&share)),
        ("free-form", |share| share < TUBULAR),
        ("all", |_| true),
    ];
    let columns: Vec<Vec<&Measured>> = classes
        .iter()
        .map(|(_, of)| {
            let own = |m: &&&Measured| of(m.ours.developable.unwrap_or(f64::NAN));
            unwrapped.iter().filter(own).copied().collect()
        })
        .collect();
    let _ = writeln!(text, "| | {} |", classes.map(|c| c.0).join(" | "));
    let _ = writeln!(text, "|---|{}", "---|".repeat(classes.len()));
    for (name, figure) in FIGURES {
        let cells: Vec<String> = columns.iter().map(|objects| figure(objects)).collect();
        let _ = writeln!(text, "| {name} | {} |", cells.join(" | "));
    }
    for row in rows.iter().filter(|r| r.measured.is_none()) {
        let _ = writeln!(text, "\n{}", brief(row));
    }
    text
}

/// A class of objects: its name, and which shares of developable area belong to it.
type Class = (&'static str, fn(f64) -> bool);

/// A line of the table: what it is called, and its figure over the objects of a class.
type Figure = (&'static str, fn(&[&Measured]) -> String);

const FIGURES: [Figure; 22] = [
    ("objects", |m| m.len().to_string()),
    ("valid", |m| count(m, |m| m.ours.valid)),
    ("valid by the independent measure", |m| {
        let measured: Vec<&Measured> =
            m.iter().copied().filter(|m| m.independent.is_some()).collect();
        count(&measured, |m| {
            m.independent.as_ref().is_some_and(|j| j["meshes"][0]["validity"]["valid"] == true)
        })
    }),
    ("symmetric Dirichlet, median", |m| quantile(m, 0.5, |m| m.ours.symmetric_dirichlet)),
    ("… 95th percentile", |m| quantile(m, 0.95, |m| m.ours.symmetric_dirichlet)),
    ("… of the peer, median", |m| {
        quantile(m, 0.5, |m| m.peer.as_ref().map(|p| p.symmetric_dirichlet))
    }),
    ("σ1/σ2 − 1, median", |m| quantile(m, 0.5, |m| m.ours.angular)),
    ("area distortion − 1, median", |m| quantile(m, 0.5, |m| m.ours.area)),
    ("charts, median", |m| quantile(m, 0.5, |m| Some(f64::from(m.ours.charts)))),
    ("charts / the peer's, median", |m| {
        quantile(m, 0.5, |m| {
            m.peer.as_ref().and_then(|p| ratio(m.ours.charts.into(), p.charts.into()))
        })
    }),
    ("charts / the peer's on the raw mesh", |m| {
        quantile(m, 0.5, |m| {
            m.peer.as_ref().and_then(|p| ratio(m.ours.charts.into(), p.raw_charts.into()))
        })
    }),
    ("seam / √area, median", |m| quantile(m, 0.5, |m| m.ours.seam)),
    ("seam / the peer's, median", |m| {
        quantile(m, 0.5, |m| ratio(m.ours.seam?, m.peer.as_ref()?.seam))
    }),
    ("fewer charts and shorter seams at the peer's distortion", dominance),
    ("avoidable seam, median", |m| quantile(m, 0.5, |m| m.ours.avoidable)),
    ("part boundary that is seam, given labels, median", |m| {
        quantile(m, 0.5, |m| alignment(m, |a| a.recall))
    }),
    ("… precision, F1, ceiling", |m| {
        let figures: [fn(&BoundaryAlignment) -> f64; 3] =
            [|a| a.precision, |a| a.f1, |a| a.ceiling];
        figures.map(|figure| quantile(m, 0.5, |m| alignment(m, figure))).join(", ")
    }),
    ("packing, median", |m| quantile(m, 0.5, |m| Some(m.ours.packing))),
    ("narrowest gutter, texels", |m| quantile(m, 0.0, |m| m.ours.min_gutter_texels)),
    ("seconds, median", |m| quantile(m, 0.5, |m| Some(m.ours.seconds))),
    ("seconds, longest", |m| quantile(m, 1.0, |m| Some(m.ours.seconds))),
    ("gain of training, best", |m| quantile(m, 1.0, |m| m.ours.gain)),
];

/// Our figure over the peer's; nothing where the peer's is zero.
fn ratio(ours: f64, theirs: f64) -> Option<f64> {
    (theirs > 0.0).then(|| ours / theirs)
}

/// A figure of the seams against the boundaries of given labels.
fn alignment(m: &Measured, figure: fn(&BoundaryAlignment) -> f64) -> Option<f64> {
    m.along_labels.as_ref()?.alignment.as_ref().map(figure)
}

fn count(objects: &[&Measured], holds: fn(&Measured) -> bool) -> String {
    format!("{} of {}", objects.iter().filter(|m| holds(m)).count(), objects.len())
}

/// A quantile over the objects that have the figure (nearest rank).
fn quantile(objects: &[&Measured], share: f64, of: impl Fn(&Measured) -> Option<f64>) -> String {
    let mut values: Vec<f64> = objects.iter().filter_map(|m| of(m)).collect();
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
fn dominance(objects: &[&Measured]) -> String {
    let both: Vec<&Measured> =
        objects.iter().copied().filter(|m| m.matched.is_some() && m.peer.is_some()).collect();
    count(&both, |m| m.matched.as_ref().zip(m.peer.as_ref()).is_some_and(|(m, p)| m.dominates(p)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::bench::row::{PeerFigures, ResultFigures};

    fn row(charts: u32, theirs: u32, developable: f64) -> Row {
        let ours = ResultFigures {
            valid: true,
            charts,
            seam: Some(1.0),
            symmetric_dirichlet: Some(1.0),
            developable: Some(developable),
            ..ResultFigures::default()
        };
        let peer = PeerFigures {
            charts: theirs,
            raw_charts: theirs,
            seam: 1.0,
            symmetric_dirichlet: 1.0,
            seconds: 0.1,
        };
        let measured = Measured {
            triangles: 2,
            double_sided: 0,
            matched: Some(ours.clone()),
            ours,
            along_labels: None,
            peer: Some(peer),
            independent: None,
        };
        Row { object: "a".into(), measured: Some(measured), error: None }
    }

    #[test]
    fn objects_are_counted_in_their_class() {
        let lines = [
            row(2, 4, 0.95),
            row(3, 4, 0.6),
            row(4, 4, 0.1),
            Row { object: "b".into(), error: Some("no".into()), measured: None },
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

    /// An interrupted benchmark goes on from the lines that it wrote.
    #[test]
    fn a_line_is_read_as_it_was_written() {
        let failed = Row { object: "b".into(), error: Some("no".into()), measured: None };
        for row in [row(2, 4, 0.5), failed] {
            let line = serde_json::to_string(&row).unwrap();
            let again: Row = serde_json::from_str(&line).unwrap();
            assert_eq!(serde_json::to_string(&again).unwrap(), line);
            assert_eq!(again.measured.is_some(), row.measured.is_some());
        }
    }
}
