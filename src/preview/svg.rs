//! The UV layout as SVG, drawn as the texture looks (v down, as in glTF): one group a part with its
//! name as title, one path a chart, the triangles inside as thin lines.

use std::fmt::Write;

use super::outline::outlines;
use super::pages::Pages;
use super::palette::{hex, part_color};
use crate::contract::{Cancel, Canceled};
use crate::mesh::NONE;
use crate::metrics::{EdgeTable, Measured};

/// Width and height of a page, user units.
const SIDE: f32 = 1000.0;
/// With more faces only the outlines are drawn.
const MOST_FACES: usize = 20_000;

/// Draws the layout. `part_names` may be shorter than the parts are many. Fails only if canceled.
pub fn uv_layout_svg(
    input: &Measured,
    part_names: &[String],
    cancel: &Cancel,
) -> Result<String, Canceled> {
    let edges = EdgeTable::new(input, |f| input.face_map(f as usize).is_some(), cancel)?;
    let outlines = outlines(input, &edges);
    cancel.check()?;
    let pages = Pages::new(input.pages);
    let inner = inner_lines(input, pages, &edges);
    let mut part_of = vec![NONE; input.charts];
    for (f, chart) in input.chart_of.iter().enumerate() {
        if let Some(part) = part_of.get_mut(*chart as usize) {
            *part = input.part_of[f];
        }
    }
    // By part, then by chart.
    let mut order: Vec<(u32, usize)> = part_of.iter().copied().zip(0..).collect();
    order.sort_unstable();
    let [width, height] = pages.size().map(|length| length * SIDE);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
         height=\"{height}\" stroke-linejoin=\"round\">\n\
         <title>UV layout: {} charts, {} texels a side</title>\n",
        input.charts, input.page_size
    );
    for page in pages.all() {
        let [x, y] = pages.place(page, [0.0, 1.0]).map(|length| length * SIDE);
        // Formatting into a string cannot fail.
        let _ = writeln!(
            svg,
            "<rect x=\"{x}\" y=\"{y}\" width=\"{SIDE}\" height=\"{SIDE}\" fill=\"#ffffff\" stroke=\"#c8ccd2\"/>"
        );
    }
    for group in order.chunk_by(|a, b| a.0 == b.0) {
        cancel.check()?;
        let part = group[0].0;
        let color = part_color(part);
        let dark = color.map(|c| (u32::from(c) * 55 / 100) as u8);
        let name = part_names.get(part as usize).map_or("no part", String::as_str);
        // Formatting into a string cannot fail.
        let _ = writeln!(
            svg,
            "<g fill=\"{}\" fill-opacity=\"0.35\" fill-rule=\"evenodd\" stroke=\"{}\">\n<title>{}</title>",
            hex(color),
            hex(dark),
            escape(name)
        );
        for (_, chart) in group {
            let mut path = String::new();
            for line in &outlines[*chart] {
                for (i, uv) in line.iter().enumerate() {
                    let at = pages.place(input.page(*chart as u32), *uv);
                    point(&mut path, if i == 0 { 'M' } else { 'L' }, at);
                }
                path.push('Z');
            }
            let _ = writeln!(svg, "<path stroke-width=\"1.2\" d=\"{path}\"/>");
            if !inner[*chart].is_empty() {
                let _ = writeln!(
                    svg,
                    "<path fill=\"none\" stroke-width=\"0.35\" stroke-opacity=\"0.55\" d=\"{}\"/>",
                    inner[*chart]
                );
            }
        }
        svg.push_str("</g>\n");
    }
    svg.push_str("</svg>\n");
    Ok(svg)
}

/// The edges within each chart, as path data. Length: charts.
fn inner_lines(input: &Measured, pages: Pages, edges: &EdgeTable) -> Vec<String> {
    let mut lines = vec![String::new(); input.charts];
    if input.surface.face_count() > MOST_FACES {
        return lines;
    }
    for e in 0..edges.len() {
        // Both lists ascend, and different UV edges are numbered as they first appear.
        let mut rim = edges.rim(e).peekable();
        let mut drawn = None;
        for (h, uv_edge) in edges.half_edges(e) {
            if rim.next_if_eq(&h).is_some() || drawn.is_some_and(|d| uv_edge <= d) {
                continue;
            }
            let (f, k) = (h as usize / 3, h as usize % 3);
            if let Some(line) = lines.get_mut(input.chart_of[f] as usize) {
                drawn = Some(uv_edge);
                let at = |k: usize| pages.place(input.page(input.chart_of[f]), input.uvs[f][k]);
                point(line, 'M', at(k));
                point(line, 'L', at((k + 1) % 3));
            }
        }
    }
    lines
}

/// One step of a path, two decimals.
fn point(path: &mut String, command: char, [x, y]: [f32; 2]) {
    let _ = write!(path, "{command}{:.2} {:.2}", x * SIDE, y * SIDE);
}

/// Text as XML wants it; characters that XML 1.0 forbids are left out.
fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c if c < ' ' && !matches!(c, '\t' | '\n' | '\r') => {}
            '\u{FFFE}' | '\u{FFFF}' => {}
            c => out.push(c),
        }
    }
    out
}
