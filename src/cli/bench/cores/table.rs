//! The tables of the cores benchmark, in Markdown, and its curves.

use std::fmt::Write;

use super::plan::THREADS;
use super::{Measured, Row};
use crate::cli::bench::cell::number;
use crate::cli::bench::plot::Curve;

/// What so many threads took.
fn measured(row: &Row, threads: usize) -> Option<&Measured> {
    row.measured.iter().find(|m| m.threads == threads)
}

/// One line for the terminal.
pub fn brief(row: &Row) -> String {
    let seconds = |threads| number(measured(row, threads).map(|m| m.seconds), 2);
    let whole = &row.plan.whole;
    format!(
        "{}: {} s on one thread, {} on two ({} expected), span {}",
        row.name,
        seconds(1),
        seconds(2),
        number(whole.expected(2), 2),
        number(Some(whole.span), 2)
    )
}

/// The seconds to expect over threads: one over the share of the time that is left.
pub fn curves(rows: &[Row]) -> Vec<Curve> {
    let curve = |row: &Row| {
        let whole = &row.plan.whole;
        let point =
            |&threads: &usize| Some((threads as f64, whole.work / whole.expected(threads)?));
        (row.name.clone(), THREADS.iter().filter_map(point).collect())
    };
    rows.iter().map(curve).collect()
}

/// Every object, its stages, and what its longest chain is made of.
pub fn table(rows: &[Row]) -> String {
    let mut text = String::from(
        "| | triangles | T1, s | T2 | T1 / T2 | T2 expected | off | T4 | T16 | T64 | span | T1 / span | MiB a \
         thread |\n",
    );
    text += &format!("|{}\n", "---|".repeat(13));
    for row in rows {
        let [one, two] = [1, 2].map(|threads| measured(row, threads));
        let ratio = |a: Option<f64>, b: Option<f64>| Some(a? / b?);
        let [t1, t2] = [one, two].map(|m| m.map(|m| m.seconds));
        let whole = &row.plan.whole;
        let of = |threads| whole.expected(threads);
        let (span, recorded) = (Some(whole.span), Some(whole.work));
        // The recording costs a little itself: its proportions count.
        let off = ratio(ratio(of(2), recorded), ratio(t2, t1)).map(|r| 100.0 * (r - 1.0));
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {} % | {} | {} | {} | {} | {} | {} |",
            row.name,
            row.triangles,
            number(t1, 2),
            number(t2, 2),
            number(ratio(t1, t2), 2),
            number(of(2), 2),
            number(off, 1),
            number(of(4), 2),
            number(of(16), 2),
            number(of(64), 2),
            number(span, 2),
            number(ratio(recorded, span), 1),
            number(row.memory_a_thread, 0),
        );
    }
    for row in rows {
        text += &stages(row);
        text += &links(row);
    }
    text
}

/// The stages of an object.
fn stages(row: &Row) -> String {
    let mut text = format!(
        "\n{}, by stage:\n\n| stage | T1, s | T2 | T1 recorded | T2 expected | T16 | span | T1 / span |\n|{}\n",
        row.name,
        "---|".repeat(8)
    );
    for stage in &row.plan.stages {
        let took = |threads| {
            let stages = &measured(row, threads)?.stages;
            Some(stages.iter().find(|s| s.0 == stage.name)?.1)
        };
        let _ = writeln!(
            text,
            "| {} | {} | {} | {:.2} | {} | {} | {} | {} |",
            stage.name,
            number(took(1), 2),
            number(took(2), 2),
            stage.work,
            number(stage.expected(2), 2),
            number(stage.expected(16), 2),
            number(Some(stage.span), 2),
            number(Some(stage.work / stage.span), 1)
        );
    }
    text
}

/// What the longest chain is made of.
fn links(row: &Row) -> String {
    let plan = &row.plan;
    let mut text = format!(
        "\n{}, the longest links of the longest chain ({:.2} s):\n\n| | on the chain, s | in all, s |\n|---|---|---|\n",
        row.name, plan.whole.span
    );
    for link in &plan.links {
        let _ = writeln!(text, "| {} | {:.3} | {:.2} |", link.name, link.chain, link.work);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::bench::cores::plan::{Link, Plan, Span};

    #[test]
    fn the_table_holds_what_is_expected_against_what_was_measured() {
        let span = |name: &str, by: f64| Span {
            name: name.into(),
            work: 8.0 * by,
            span: 2.0 * by,
            on: [8.0, 5.0, 3.0, 2.5, 2.0].map(|s| s * by).to_vec(),
        };
        let plan = Plan {
            whole: span("all", 1.0),
            stages: vec![span("charts", 0.5)],
            links: vec![Link { name: "union".into(), chain: 1.5, work: 6.0 }],
        };
        let took = |threads, seconds| Measured {
            threads,
            seconds,
            stages: vec![("charts".into(), 0.5 * seconds)],
        };
        let row = Row {
            name: "body".into(),
            triangles: 100,
            measured: vec![took(1, 4.0), took(2, 2.0)],
            memory_a_thread: Some(30.0),
            plan,
        };
        let text = table(std::slice::from_ref(&row));
        let line = "| body | 100 | 4.00 | 2.00 | 2.00 | 5.00 | 25.0 % | 3.00 | 2.50 | 2.00 | 2.00 | 4.0 | 30 |";
        assert!(text.contains(line), "{text}");
        assert!(
            text.contains("| charts | 2.00 | 1.00 | 4.00 | 2.50 | 1.25 | 1.00 | 4.0 |"),
            "{text}"
        );
        assert!(text.contains("| union | 1.500 | 6.00 |"), "{text}");
        assert_eq!(curves(&[row])[0].1[..2], [(1.0, 1.0), (2.0, 1.6)]);
    }
}
