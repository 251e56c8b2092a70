//! What the stages make of one object, a picture each: samples, parts, patches, charts, the charts' maps,
//! the page. Every picture has a square panel on the left and what explains it on the right.

use std::collections::BTreeSet;

use glam::{Vec2, Vec3};

use super::canvas::Canvas;
use super::layout::draw_layout;
use super::lines::LineMask;
use super::pages::Pages;
use super::palette::{linear, part_color};
use super::picture::{PreviewError, encode_png};
use super::ramp::{COLD_TO_WARM, PALE_TO_WARM, fill};
use super::shade::{FACTOR, Line, View};
use super::shelves::Shelves;
use super::text;
use crate::contract::{Canceled, Run};
use crate::mesh::{NONE, Surface};
use crate::metrics::{EdgeTable, FaceMap, Measured};
use crate::sampling::PointCloud;

/// Width and height of each picture, pixels.
pub const STAGE_SIZE: [u32; 2] = [WIDTH as u32, PANEL as u32];

const WIDTH: usize = 850;
/// Side of the panel; what is right of it explains it.
const PANEL: usize = 660;
/// Free room between the panel's sides and a drawing in the plane.
const MARGIN: usize = 20;
/// Where the explanation begins.
const LEGEND: [usize; 2] = [PANEL + 10, 40];
/// Pixels from one line of it to the next.
const STEP: usize = text::LINE + 6;

/// Radius of a sample's dot, pixels.
const DOT: f32 = 1.3;
/// Space between charts that stand side by side, pixels.
const GAP: usize = 12;
/// Colours that neighbours can be told apart by.
const COLORS: u32 = 36;
/// Tops for the scale of distortion; the first that as much of the surface stays below is taken.
const TOPS: [f64; 9] = [1.01, 1.02, 1.05, 1.1, 1.2, 1.5, 2.0, 5.0, 10.0];
const BELOW: f64 = 0.98;

const PAPER: [u8; 3] = [0xf6, 0xf7, 0xf9];
const INK: [u8; 3] = [0x20, 0x22, 0x28];
/// The object below its samples.
const PALE: [u8; 3] = [0xee, 0xec, 0xe6];
const BORDER: Line = Line { color: INK, thick: 0.8, strength: 0.7 };
const SEAM: Line = Line { color: [0xd0, 0x10, 0x28], thick: 1.6, strength: 0.95 };

/// One object, ready to be drawn after each of its stages. All pictures are PNG, of [`STAGE_SIZE`].
pub struct StagePictures<'a> {
    input: &'a Measured<'a>,
    maps: Vec<Option<FaceMap>>,
    edges: EdgeTable,
    view: Option<View<'a>>,
}

impl<'a> StagePictures<'a> {
    /// Looks at a result.
    pub fn new(input: &'a Measured<'a>, run: &Run) -> Result<Self, Canceled> {
        let maps: Vec<_> = (0..input.uvs.len()).map(|f| input.face_map(f)).collect();
        let edges = EdgeTable::new(input, |f| maps[f as usize].is_some(), &run.cancel)?;
        let view = View::new(input.surface, PANEL, &run.cancel)?;
        Ok(Self { input, maps, edges, view })
    }

    /// The samples on the object, coloured by edge sensitivity.
    pub fn samples(&self, cloud: &PointCloud) -> Result<Vec<u8>, PreviewError> {
        let mut panel = panel();
        if let Some(view) = &self.view {
            view.paint(&mut panel, |_, _, _| linear(PALE));
            // The rarer warm ones on top.
            let mut order: Vec<usize> = (0..cloud.len()).collect();
            order.sort_by(|&a, &b| cloud.sensitivity[a].total_cmp(&cloud.sensitivity[b]));
            let dot = |i: usize| (cloud.positions[i], COLD_TO_WARM.at(cloud.sensitivity[i]));
            view.draw_dots(&mut panel, DOT, order.into_iter().map(dot));
        }
        let mut page =
            page(&panel, &[format!("{} samples", cloud.len()), "edge sensitivity".into()]);
        let numbers = ["0", "0.25", "0.5", "0.75", "1"].map(String::from);
        COLD_TO_WARM.draw_bar(&mut page, below(3), &numbers, linear(INK));
        Ok(encode(&page)?)
    }

    /// The object by parts. `names`: one a part.
    pub fn parts(&self, names: &[String]) -> Result<Vec<u8>, PreviewError> {
        let part_of = self.input.part_of;
        let panel = self.by_number(
            part_of,
            |p| linear(part_color(p)),
            &BORDER,
            |e| self.divides(part_of, e),
        );
        let mut page = page(&panel, &[format!("{} parts", self.input.parts)]);
        name_parts(&mut page, 2, names);
        Ok(encode(&page)?)
    }

    /// The object by patches. `patch_of`: one a face, [`NONE`] for none.
    pub fn patches(&self, patch_of: &[u32]) -> Result<Vec<u8>, PreviewError> {
        let (count, colors) = apart(self.input.surface, patch_of);
        let panel =
            self.by_number(patch_of, |p| shade(&colors, p), &BORDER, |e| self.divides(patch_of, e));
        Ok(encode(&page(&panel, &[format!("{count} patches")]))?)
    }

    /// The object by charts, seams in red.
    pub fn charts(&self) -> Result<Vec<u8>, PreviewError> {
        let chart_of = self.input.chart_of;
        let (_, colors) = apart(self.input.surface, chart_of);
        let paler = |c: u32| shade(&colors, c).lerp(Vec3::ONE, 0.25);
        let panel = self.by_number(chart_of, paler, &SEAM, |e| self.edges.cuts[e] > 0);
        let mut page = page(&panel, &[format!("{} charts", self.input.charts)]);
        let at = below(1);
        fill(&mut page, [at[0], at[1] + text::LINE / 2], [22, 2], linear(SEAM.color));
        text::write(&mut page, "seam", [at[0] + 32, at[1]], WIDTH - at[0] - 32, linear(INK));
        Ok(encode(&page)?)
    }

    /// The charts' maps side by side, triangles coloured by symmetric Dirichlet energy, each chart at its own
    /// scale s as docs/method.md has it.
    pub fn maps(&self) -> Result<Vec<u8>, PreviewError> {
        let energies = self.energies();
        let top = top(&energies, &self.maps);
        let mut panel = panel();
        let unit = FACTOR as f32;
        let corner = Vec2::splat(MARGIN as f32 * unit);
        let room = Vec2::splat(PANEL as f32 * unit) - 2.0 * corner;
        let shelves = Shelves::new(self.input, corner, room, GAP as f32 * unit);
        let place =
            |f: usize, k: usize| shelves.place(self.input.chart_of[f], self.input.uvs[f][k % 3]);
        for (f, energy) in energies.iter().enumerate() {
            if let Some(energy) = energy {
                let share = ((energy - 1.0) / (top - 1.0)) as f32;
                panel.fill([0, 1, 2].map(|k| place(f, k)), PALE_TO_WARM.at(share));
            }
        }
        let segment = |h: u32| {
            let (f, k) = (h as usize / 3, h as usize % 3);
            [place(f, k), place(f, k + 1)]
        };
        let inner = self.edges.all_half_edges().iter().copied();
        let rim = (0..self.edges.len()).flat_map(|e| self.edges.rim(e));
        draw(&mut panel, inner.map(segment), 0.25, 0.3);
        draw(&mut panel, rim.map(segment), 1.0, 0.85);
        let title =
            [format!("{} maps", self.input.charts), "symmetric Dirichlet".into(), "energy".into()];
        let mut page = page(&panel, &title);
        let hottest = energies.iter().flatten().copied().fold(1.0, f64::max);
        let numbers: Vec<String> = (0..5)
            .map(|i| {
                let beyond = if i == 4 && hottest > top { " and more" } else { "" };
                let number = 1.0 + (top - 1.0) * f64::from(i) / 4.0;
                format!("{}{beyond}", (1e4 * number).round() / 1e4)
            })
            .collect();
        PALE_TO_WARM.draw_bar(&mut page, below(4), &numbers, linear(INK));
        Ok(encode(&page)?)
    }

    /// The packed page, or pages, charts filled by the colour of their part. `names`: one a part.
    pub fn page(&self, names: &[String]) -> Result<Vec<u8>, PreviewError> {
        let mut panel = panel();
        let pages = Pages::new(self.input.pages);
        draw_layout(
            &mut panel,
            self.input,
            &self.edges,
            pages,
            (MARGIN * FACTOR) as f32,
            FACTOR as f32,
        );
        let size = self.input.page_size;
        let pages = match self.input.pages {
            0 | 1 => format!("page, {size} x {size}"),
            more => format!("{more} pages, {size} x {size}"),
        };
        let mut page = page(&panel, &[pages, format!("{} charts", self.input.charts)]);
        name_parts(&mut page, 3, names);
        Ok(encode(&page)?)
    }

    /// The object, each face in the colour of its number, with the edges that `lined` picks.
    fn by_number(
        &self,
        number: &[u32],
        color: impl Fn(u32) -> Vec3 + Sync,
        line: &Line,
        lined: impl Fn(usize) -> bool,
    ) -> Canvas {
        let mut panel = panel();
        if let Some(view) = &self.view {
            let brighter = |c: Vec3| c.lerp(Vec3::ONE, 0.12);
            view.paint(&mut panel, |face, _, _| brighter(color(number[face as usize])));
            view.draw_edges(&mut panel, &self.edges, line, lined);
        }
        panel
    }

    /// Whether an edge stands between faces of different numbers that continue one another.
    fn divides(&self, number: &[u32], e: usize) -> bool {
        self.edges.half_edges(e).any(|(h, _)| {
            let t = self.input.surface.twin[h as usize];
            t != NONE && number[h as usize / 3] != number[t as usize / 3]
        })
    }

    /// The symmetric Dirichlet energy of each face, its chart at scale 1.
    fn energies(&self) -> Vec<Option<f64>> {
        let mut totals = vec![(0.0, 0.0); self.input.charts];
        for (map, &chart) in self.maps.iter().zip(self.input.chart_of) {
            if let Some(map) = map {
                totals[chart as usize].0 += map.uv_area.abs();
                totals[chart as usize].1 += map.area;
            }
        }
        let energy = |(map, &chart): (&Option<FaceMap>, &u32)| {
            let map = map.as_ref()?;
            let (uv, area) = totals[chart as usize];
            let [p, q] = [map.sigma1, map.sigma2].map(|s| s * s * area / uv);
            Some(0.25 * (p + q + 1.0 / p + 1.0 / q))
        };
        self.maps.iter().zip(self.input.chart_of).map(energy).collect()
    }
}

/// The top of the scale: as little as [`BELOW`] of the surface allows.
fn top(energies: &[Option<f64>], maps: &[Option<FaceMap>]) -> f64 {
    let areas = || energies.iter().zip(maps).filter_map(|(e, m)| Some(((*e)?, m.as_ref()?.area)));
    let all: f64 = areas().map(|(_, area)| area).sum();
    let held = |top: f64| areas().filter(|(e, _)| *e <= top).map(|(_, area)| area).sum::<f64>();
    let last = TOPS[TOPS.len() - 1];
    TOPS.into_iter().find(|&top| held(top) >= BELOW * all).unwrap_or(last)
}

/// How many numbers there are, and a colour for each: its own of [`COLORS`], or the next that no
/// neighbour has.
fn apart(surface: &Surface, number: &[u32]) -> (usize, Vec<Vec3>) {
    let count = number.iter().filter(|n| **n != NONE).max().map_or(0, |&most| most as usize + 1);
    let mut around = vec![BTreeSet::new(); count];
    for (h, &t) in surface.twin.iter().enumerate().filter(|(_, t)| **t != NONE) {
        let (own, other) = (number[h / 3], number[t as usize / 3]);
        // Those with the lower numbers have their colours first.
        if own != NONE && other < own {
            around[own as usize].insert(other);
        }
    }
    let mut chosen: Vec<u32> = Vec::with_capacity(count);
    for (own, around) in (0u32..).zip(&around) {
        let taken = |color: &u32| around.iter().any(|&n| chosen[n as usize] == *color);
        let wanted = (own..own + COLORS).map(|c| c % COLORS).find(|color| !taken(color));
        chosen.push(wanted.unwrap_or(own % COLORS));
    }
    (count, chosen.into_iter().map(|color| linear(part_color(color))).collect())
}

fn shade(colors: &[Vec3], number: u32) -> Vec3 {
    colors.get(number as usize).copied().unwrap_or_else(|| linear(part_color(NONE)))
}

/// Lines over a panel.
fn draw(panel: &mut Canvas, segments: impl Iterator<Item = [Vec2; 2]>, thick: f32, strength: f32) {
    let mut mask = LineMask::new(panel.width, panel.height);
    for [a, b] in segments {
        mask.draw(a, b, thick * FACTOR as f32, |_, _| true);
    }
    panel.lay(&mask.scaled(strength), linear(INK));
}

/// An empty panel, before it is made smaller.
fn panel() -> Canvas {
    let paper = linear(PAPER);
    Canvas::gradient(PANEL * FACTOR, PANEL * FACTOR, paper, paper)
}

/// A picture: its panel, and lines of text at the head of the explanation.
fn page(panel: &Canvas, lines: &[String]) -> Canvas {
    let paper = linear(PAPER);
    let mut page = Canvas::gradient(WIDTH, PANEL, paper, paper);
    page.paste_smaller(panel, FACTOR, 0, 0);
    for (i, line) in lines.iter().enumerate() {
        let at = below(i);
        text::write(&mut page, line, at, WIDTH - at[0], linear(INK));
    }
    page
}

/// Where a line of the explanation begins.
fn below(line: usize) -> [usize; 2] {
    [LEGEND[0], LEGEND[1] + line * STEP]
}

/// The parts' colours with their names from line `first` on, as many as there is room for.
fn name_parts(page: &mut Canvas, first: usize, names: &[String]) {
    let room = (PANEL - LEGEND[1]) / STEP - first - 1;
    for (i, name) in names.iter().take(room).enumerate() {
        let [x, y] = below(first + i);
        fill(
            page,
            [x, y + 1],
            [text::LINE - 2; 2],
            linear(part_color(i as u32)).lerp(Vec3::ONE, 0.12),
        );
        text::write(page, name, [x + 26, y], WIDTH - x - 26, linear(INK));
    }
    if names.len() > room {
        let more = format!("and {} more", names.len() - room);
        text::write(page, &more, below(first + room), WIDTH - LEGEND[0], linear(INK));
    }
}

fn encode(page: &Canvas) -> Result<Vec<u8>, png::EncodingError> {
    encode_png(page, png::Compression::High)
}
