//! The tables of the scale benchmark, in Markdown.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::body::{Figures, Row};
use super::exponent::exponent;
use crate::cli::bench::cell::number;

/// From how many triangles on exponents are fitted: below, fixed costs tell.
pub const FITTED: u32 = 20_000;

/// One line for the terminal.
pub fn brief(row: &Row) -> String {
    let case = &row.case;
    let mut text = format!(
        "{} {} triangles, noise {:.3}, {} pieces, {}: ",
        case.body.as_str(),
        case.triangles,
        case.noise,
        case.copies,
        row.program
    );
    let _ = match &row.figures {
        None => write!(text, "{}", row.error.as_deref().unwrap_or("no figures")),
        Some(f) => write!(
            text,
            "{:.1} s, {} MiB, {} charts, seam {}, SD {}{}",
            f.seconds,
            number(f.peak_memory_mib, 0),
            f.charts,
            number(f.seam, 2),
            number(f.symmetric_dirichlet, 4),
            if f.valid { "" } else { ", NOT VALID" }
        ),
    };
    text
}

/// What is one curve of the plot: a program and a noise of one piece, or a number of pieces.
pub fn curve(row: &Row) -> String {
    match row.case.copies {
        1 => format!("{}, noise {:.2}", row.program, row.case.noise),
        copies => format!("{}, {copies} pieces", row.program),
    }
}

/// Every mesh, the seconds of the stages, and how they grow.
pub fn table(rows: &[Row]) -> String {
    let mut text = String::from(
        "| body | triangles | noise | pieces | program | seconds | MiB | valid | parts | charts | small | \
         seam/√A | mean SD − 1 | jaggedness | covered |\n",
    );
    text += &format!("|{}\n", "---|".repeat(15));
    for row in rows {
        let case = &row.case;
        let _ = write!(
            text,
            "| {} | {} | {:.3} | {} | {} |",
            case.body.as_str(),
            row.figures.as_ref().map_or(u64::from(case.triangles), |f| f.triangles),
            case.noise,
            case.copies,
            row.program
        );
        let _ = match &row.figures {
            None => writeln!(text, " {} {}", row.error.as_deref().unwrap_or(""), "|".repeat(10)),
            Some(f) => writeln!(
                text,
                " {:.2} | {} | {} | {} | {} | {} | {} | {} | {} | {:.2} |",
                f.seconds,
                number(f.peak_memory_mib, 0),
                if f.valid { "yes" } else { "NO" },
                f.parts,
                f.charts,
                f.small_charts.map_or("–".into(), |n| n.to_string()),
                number(f.seam, 2),
                number(f.symmetric_dirichlet.map(|e| e - 1.0), 4),
                number(f.seam_jaggedness, 3),
                f.packing
            ),
        };
    }
    text += &stages(rows);
    text += &exponents(rows);
    text
}

/// Seconds of each stage.
type Seconds<'a> = BTreeMap<&'a str, f64>;

/// Share of each stage in the seconds, by program and size.
fn stages(rows: &[Row]) -> String {
    let mut names: Vec<&str> = Vec::new();
    let mut sums: BTreeMap<(u32, &str), (f64, Seconds)> = BTreeMap::new();
    for (row, f) in measured(rows) {
        let sum = sums.entry((row.case.triangles, &row.program)).or_default();
        sum.0 += f.triangles as f64;
        for (name, seconds) in &f.stages {
            if !names.contains(&name.as_str()) {
                names.push(name);
            }
            *sum.1.entry(name).or_default() += seconds;
        }
    }
    let mut text = format!(
        "\nMicroseconds a triangle:\n\n| triangles | program | {} |\n|{}\n",
        names.join(" | "),
        "---|".repeat(names.len() + 2)
    );
    for ((triangles, program), (faces, seconds)) in &sums {
        let cells: Vec<String> = names
            .iter()
            .map(|name| format!("{:.2}", 1e6 * seconds.get(name).unwrap_or(&0.0) / faces))
            .collect();
        let _ = writeln!(text, "| {triangles} | {program} | {} |", cells.join(" | "));
    }
    text
}

/// Exponents of time and memory, from [`FITTED`] triangles on.
fn exponents(rows: &[Row]) -> String {
    let mut curves: BTreeMap<String, Vec<&Figures>> = BTreeMap::new();
    for (row, f) in measured(rows).filter(|(row, _)| row.case.triangles >= FITTED) {
        curves.entry(curve(row)).or_default().push(f);
    }
    let mut text =
        String::from("\n| | exponent of time | of memory | of charts |\n|---|---|---|---|\n");
    for (name, figures) in &curves {
        let of = |of: &dyn Fn(&Figures) -> Option<f64>| {
            let points = figures.iter().filter_map(|f| Some((f.triangles as f64, of(f)?)));
            number(exponent(&points.collect::<Vec<_>>()), 2)
        };
        let _ = writeln!(
            text,
            "| {name} | {} | {} | {} |",
            of(&|f| Some(f.seconds)),
            of(&|f| f.peak_memory_mib),
            of(&|f| Some(f64::from(f.charts)))
        );
    }
    text
}

/// Rows that have figures.
pub fn measured(rows: &[Row]) -> impl Iterator<Item = (&Row, &Figures)> {
    rows.iter().filter_map(|row| Some((row, row.figures.as_ref()?)))
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::cli::bench::scale::body::Case;
    use crate::synth::{BodyKind, NoiseKind};

    /// Two sizes, of which the larger takes `seconds` and the smaller four; and one that failed.
    pub fn rows(seconds: f64) -> Vec<Row> {
        let row = |triangles: u32, seconds: Option<f64>| Row {
            case: Case {
                body: BodyKind::Hand,
                triangles,
                noise: 0.0,
                noise_kind: NoiseKind::Normal,
                copies: 1,
            },
            program: "this".into(),
            error: seconds.is_none().then(|| "no memory".into()),
            figures: seconds.map(|seconds| Figures {
                triangles: u64::from(triangles),
                seconds,
                stages: vec![("charts".into(), 0.5 * seconds)],
                peak_memory_mib: Some(300.0),
                valid: true,
                parts: 2,
                charts: 7,
                seam: Some(5.0),
                symmetric_dirichlet: Some(1.01),
                packing: 0.7,
                small_charts: None,
                seam_jaggedness: None,
            }),
        };
        vec![row(100_000, Some(4.0)), row(1_000_000, Some(seconds)), row(2_000_000, None)]
    }

    #[test]
    fn the_table_has_every_mesh_its_stages_and_the_exponents() {
        let text = table(&rows(40.0));
        assert!(
            text.contains("| hand | 100000 | 0.000 | 1 | this | 4.00 | 300 | yes | 2 | 7 | – |")
        );
        assert!(text.contains("| hand | 2000000 | 0.000 | 1 | this | no memory"), "{text}");
        assert!(text.contains("| 100000 | this | 20.00 |"), "microseconds a triangle: {text}");
        assert!(text.contains("| this, noise 0.00 | 1.00 | 0.00 | 0.00 |"), "{text}");
        assert!(table(&rows(400.0)).contains("| this, noise 0.00 | 2.00 |"));
    }
}
