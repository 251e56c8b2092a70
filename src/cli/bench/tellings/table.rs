//! The tables of the tellings, in Markdown: by telling over all objects, and by object.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use super::measure::{Figures, Row};
use super::variants::Variant;
use crate::cli::bench::cell::number;

type Key<'a> = (&'a str, &'a str, Variant);

/// The value below which this share of the values lies.
fn quantile(mut values: Vec<f64>, share: f64) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let at = (share * values.len().saturating_sub(1) as f64).ceil() as usize;
    values.get(at).copied()
}

/// One line for the terminal.
pub fn brief(row: &Row) -> String {
    let head = format!("{} {} {}: ", row.object, row.variant.name(), row.program);
    match &row.figures {
        None => head + row.error.as_deref().unwrap_or("no figures"),
        Some(f) => format!(
            "{head}{} parts, {} charts, seam {}, Rand {}{}{}, {:.1} s",
            f.parts,
            f.charts,
            number(f.seam, 2),
            number(f.rand, 3),
            if f.same == Some(false) { ", another division" } else { "" },
            if f.valid { "" } else { ", NOT VALID" },
            f.seconds
        ),
    }
}

/// Both tables.
pub fn table(rows: &[Row]) -> String {
    let figures: BTreeMap<Key, &Figures> = rows
        .iter()
        .filter_map(|row| {
            let key = (row.program.as_str(), row.object.as_str(), row.variant);
            Some((key, row.figures.as_ref()?))
        })
        .collect();
    let programs: BTreeSet<&str> = rows.iter().map(|row| row.program.as_str()).collect();
    let variants: BTreeSet<Variant> = rows.iter().map(|row| row.variant).collect();
    let objects: BTreeSet<&str> = rows.iter().map(|row| row.object.as_str()).collect();
    let mut text = String::new();
    for &program in programs.iter().rev() {
        let _ = writeln!(
            text,
            "**{program}**\n\n| telling | objects | valid | same division | charts: worst | charts of first, \
             median | 95th | seam of first, median | 95th | SD − 1 of first | jaggedness of first | seconds of \
             first | Rand, median | adjusted Rand, median | 10th |\n|{}",
            "---|".repeat(15)
        );
        for &variant in &variants {
            text += &line(&figures, program, variant, &objects);
        }
        text += &spread(&figures, program, &objects);
    }
    text += &by_object(&figures, &programs, &variants, &objects);
    text
}

/// One telling by one program, against the first tellings.
fn line(
    figures: &BTreeMap<Key, &Figures>,
    program: &str,
    variant: Variant,
    objects: &BTreeSet<&str>,
) -> String {
    let pairs: Vec<(&Figures, &Figures)> = objects
        .iter()
        .filter_map(|&object| {
            let of = |variant| figures.get(&(program, object, variant)).copied();
            Some((of(variant)?, of(Variant::AsIs)?))
        })
        .collect();
    if pairs.is_empty() {
        return String::new();
    }
    let over = |value: &dyn Fn(&Figures) -> Option<f64>, share| {
        let ratio = |(own, first): &(&Figures, &Figures)| Some(value(own)? / value(first)?);
        quantile(pairs.iter().filter_map(ratio).filter(|r| r.is_finite()).collect(), share)
    };
    let charts = |f: &Figures| Some(f64::from(f.charts));
    let same = pairs.iter().filter(|(own, _)| own.same == Some(true)).count();
    let valid = pairs.iter().filter(|(own, _)| own.valid).count();
    let worst = pairs.iter().map(|(own, _)| own.charts).max().unwrap_or(0);
    let rands: Vec<f64> = pairs.iter().filter_map(|(own, _)| own.rand).collect();
    let adjusted: Vec<f64> = pairs.iter().filter_map(|(own, _)| own.adjusted_rand).collect();
    format!(
        "| {} | {} | {valid} | {} | {worst} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |\n",
        variant.name(),
        pairs.len(),
        if variant.is_exact() { same.to_string() } else { "–".into() },
        number(over(&charts, 0.5), 2),
        number(over(&charts, 0.95), 2),
        number(over(&|f| f.seam, 0.5), 2),
        number(over(&|f| f.seam, 0.95), 2),
        number(over(&|f| f.symmetric_dirichlet.map(|sd| sd - 1.0), 0.5), 2),
        number(over(&|f| f.seam_jaggedness, 0.5), 2),
        number(over(&|f| Some(f.seconds), 0.5), 2),
        number(quantile(rands, 0.5), 3),
        number(quantile(adjusted.clone(), 0.5), 3),
        number(quantile(adjusted, 0.1), 3),
    )
}

/// How far the seams of an object's tellings lie apart.
fn spread(figures: &BTreeMap<Key, &Figures>, program: &str, objects: &BTreeSet<&str>) -> String {
    let of = |object: &&str| {
        let own = figures.iter().filter(|(key, _)| key.0 == program && key.1 == *object);
        let seams: Vec<f64> = own.filter_map(|(_, f)| f.seam).filter(|s| *s > 0.0).collect();
        let best = seams.iter().copied().fold(f64::INFINITY, f64::min);
        let worst = seams.iter().copied().fold(0.0, f64::max);
        (seams.len() > 1).then(|| worst / best)
    };
    let ratios: Vec<f64> = objects.iter().filter_map(of).collect();
    format!(
        "\nWorst over best seam of an object: median {}, 95th percentile {}.\n\n",
        number(quantile(ratios.clone(), 0.5), 2),
        number(quantile(ratios, 0.95), 2)
    )
}

/// Charts and seam of every telling, a line an object.
fn by_object(
    figures: &BTreeMap<Key, &Figures>,
    programs: &BTreeSet<&str>,
    variants: &BTreeSet<Variant>,
    objects: &BTreeSet<&str>,
) -> String {
    let names: Vec<String> = variants.iter().map(|v| v.name()).collect();
    let mut text = format!("| object | program | {} |\n|", names.join(" | "));
    text += &"---|".repeat(2 + names.len());
    text.push('\n');
    for (&object, &program) in
        objects.iter().flat_map(|o| programs.iter().rev().map(move |p| (o, p)))
    {
        let cell = |&variant: &Variant| match figures.get(&(program, object, variant)) {
            Some(f) => format!("{} ({})", f.charts, number(f.seam, 1)),
            None => "–".to_owned(),
        };
        let cells: Vec<String> = variants.iter().map(cell).collect();
        let _ = writeln!(text, "| {object} | {program} | {} |", cells.join(" | "));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_telling_is_held_against_the_first() {
        let row = |variant, charts, seam, same| Row {
            object: "chair".into(),
            variant,
            program: "this".into(),
            error: None,
            figures: Some(Figures {
                valid: true,
                parts: 2,
                charts,
                seam: Some(seam),
                symmetric_dirichlet: Some(1.01),
                seam_jaggedness: Some(1.0),
                packing: 0.8,
                seconds: 2.0,
                rand: Some(0.5),
                adjusted_rand: Some(0.25),
                same,
            }),
        };
        let rows =
            [row(Variant::AsIs, 10, 4.0, Some(true)), row(Variant::Soup, 15, 5.0, Some(false))];
        let text = table(&rows);
        let soup = text.lines().find(|line| line.starts_with("| soup |")).unwrap();
        let start = "| soup | 1 | 1 | 0 | 15 | 1.50 | 1.50 | 1.25 | 1.25 | 1.00 | 1.00 | 1.00 | 0.500 | 0.250 |";
        assert!(soup.starts_with(start), "{soup}");
        assert!(text.contains("seam of an object: median 1.25"));
        assert!(text.contains("| chair | this | 10 (4.0) | 15 (5.0) |"));
    }

    #[test]
    fn quantiles_are_values_that_occur() {
        let values = || vec![3.0, 1.0, 2.0];
        assert_eq!([0.0, 0.5, 0.95].map(|q| quantile(values(), q)), [1.0, 2.0, 3.0].map(Some));
        assert_eq!(quantile(Vec::new(), 0.5), None);
    }
}
