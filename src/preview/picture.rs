//! `preview.png`: on the left a checker on the shaded object with its seams, at the top right the
//! object by parts, below it the UV layout; of several pages the first sixteen stand larger below. Without
//! charts the object by parts fills the picture.

use glam::Vec3;
use rayon::prelude::*;

use super::canvas::Canvas;
use super::checker::{Tint, squares};
use super::layout::draw_layout;
use super::pages::Pages;
use super::palette::{encode, linear, part_color};
use super::shade::{FACTOR, Line, View};
use crate::contract::{Cancel, Canceled, Run};
use crate::mesh::NONE;
use crate::metrics::{EdgeTable, Measured};
use crate::tasks;

/// Width and height of the large panel; the small ones are half of it.
pub(super) const LARGE: usize = 768;
pub(super) const SMALL: usize = LARGE / 2;

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum PreviewError {
    /// The run was asked to stop.
    #[error(transparent)]
    Canceled(#[from] Canceled),
    /// The picture could not be written.
    #[error("the preview could not be encoded: {0}")]
    Encoding(#[from] png::EncodingError),
}

/// Bytes that drawing so many faces and pages takes: canvas, depths and faces of the panels, rays and
/// edges of the object, and the canvas of the pages below.
pub fn bytes(faces: usize, pages: u32) -> u64 {
    let panel = LARGE * LARGE + 2 * SMALL * SMALL;
    let below = (LARGE + SMALL) * height_below(pages);
    ((panel + below) * FACTOR * FACTOR) as u64 * 32 + faces as u64 * 256
}

/// Height of the pages below the panels, pixels of the picture.
fn height_below(pages: u32) -> usize {
    Pages::large(pages).map_or(0, |pages| {
        let [across, down] = pages.size();
        ((LARGE + SMALL) as f32 / across * down).round() as usize
    })
}

/// Draws the preview: 1152 × 768 pixels, PNG, and about 288 more for every four of several pages; 768 × 768
/// without charts.
/// `scene` is the object with all its instances, if it has several.
pub fn preview_png(
    input: &Measured,
    scene: Option<&Measured>,
    run: &Run,
) -> Result<Vec<u8>, PreviewError> {
    let cancel = &run.cancel;
    let scene = scene.unwrap_or(input);
    if input.charts == 0 {
        run.count(LARGE * LARGE * FACTOR * FACTOR);
        let edges = EdgeTable::new(scene, |_| true, cancel)?;
        let mut page = Canvas::gradient(LARGE, LARGE, Vec3::ONE, Vec3::ONE);
        page.paste_smaller(&parts_panel(scene, &edges, LARGE, cancel)?, 1, 0, 0);
        return Ok(encode_png(&page, png::Compression::Fast)?);
    }
    let table = |of: &Measured| EdgeTable::new(of, |f| of.face_map(f as usize).is_some(), cancel);
    let edges = table(input)?;
    let own_edges = if std::ptr::eq(scene, input) { None } else { Some(table(scene)?) };
    let scene_edges = own_edges.as_ref().unwrap_or(&edges);
    let large = Pages::large(input.pages);
    let below = height_below(input.pages);
    run.count((LARGE + SMALL) * (LARGE + below) * FACTOR * FACTOR);
    let panels = run.steps(4, 0.1, 1.0);
    let mut page = Canvas::gradient(LARGE + SMALL, LARGE + below, Vec3::ONE, Vec3::ONE);
    let (checker, (parts, layout)) = tasks::join(
        "panels",
        || checker_panel(scene, input, scene_edges, cancel).inspect(|_| panels.add(2)),
        || {
            let layout = || {
                let layout = layout_panel(input, &edges);
                panels.step();
                layout
            };
            let parts =
                || parts_panel(scene, scene_edges, SMALL, cancel).inspect(|_| panels.step());
            tasks::join("panels", parts, layout)
        },
    );
    page.paste_smaller(&checker?, 1, 0, 0);
    page.paste_smaller(&parts?, 1, LARGE, 0);
    page.paste_smaller(&layout, FACTOR, LARGE, SMALL);
    cancel.check()?;
    if let Some(pages) = large {
        let mut strip = background((LARGE + SMALL, below));
        draw_layout(&mut strip, input, &edges, pages, (6 * FACTOR) as f32, FACTOR as f32);
        page.paste_smaller(&strip, FACTOR, 0, LARGE);
    }
    for y in 0..LARGE {
        page.pixels[y * page.width + LARGE] = linear(RULE);
    }
    for x in LARGE..LARGE + SMALL {
        page.pixels[SMALL * page.width + x] = linear(RULE);
    }
    cancel.check()?;
    Ok(encode_png(&page, png::Compression::Fast)?)
}

/// Lines between panels.
const RULE: [u8; 3] = [0xc2, 0xc8, 0xd0];

/// What stands behind everything, at the top and at the bottom.
fn paper() -> [Vec3; 2] {
    [linear([0xee, 0xf1, 0xf5]), linear([0xcd, 0xd4, 0xdd])]
}

fn background((width, height): (usize, usize)) -> Canvas {
    let [top, bottom] = paper();
    Canvas::gradient(width * FACTOR, height * FACTOR, top, bottom)
}

/// A panel on which nothing is.
fn blank(size: usize) -> Canvas {
    let [top, bottom] = paper();
    Canvas::gradient(size, size, top, bottom)
}

/// Each square is as large on every instance as on the measured one.
fn checker_panel(
    input: &Measured,
    object: &Measured,
    edges: &EdgeTable,
    cancel: &Cancel,
) -> Result<Canvas, Canceled> {
    let Some(view) = View::new(input.surface, LARGE, cancel)? else { return Ok(blank(LARGE)) };
    let across = squares(object, input.surface.diagonal);
    // The tint of a face, and how many squares fit into a world unit on it.
    let faces: Vec<Option<(Tint, f32)>> = (0..input.uvs.len())
        .map(|f| {
            let map = input.face_map(f)?;
            let density = (map.uv_area.abs() / map.area).sqrt() as f32;
            Some((Tint::new(input.part_of[f], input.chart_of[f]), across * density))
        })
        .collect();
    let bare = linear(part_color(NONE));
    let color = |face: u32, shares: [f32; 3], pixels: f32| {
        let Some((tint, density)) = &faces[face as usize] else { return bare };
        let [a, b, c] = input.uvs[face as usize];
        let at = |i: usize| across * (a[i] * shares[0] + b[i] * shares[1] + c[i] * shares[2]);
        tint.at([at(0), at(1)], pixels / density)
    };
    let seams = Line { color: [0xb0, 0x10, 0x28], thick: 0.9, strength: 0.9 };
    Ok(view.picture(paper(), color, edges, &seams, |e| edges.cuts[e] > 0))
}

fn parts_panel(
    input: &Measured,
    edges: &EdgeTable,
    size: usize,
    cancel: &Cancel,
) -> Result<Canvas, Canceled> {
    let Some(view) = View::new(input.surface, size, cancel)? else { return Ok(blank(size)) };
    let colors: Vec<Vec3> = input.part_of.iter().map(|p| linear(part_color(*p))).collect();
    let brighter = |c: Vec3| c.lerp(Vec3::ONE, 0.12);
    let color = |face: u32, _: [f32; 3], _: f32| brighter(colors[face as usize]);
    let line = Line { color: [0x20, 0x22, 0x28], thick: 0.5, strength: 0.55 };
    let is_line = |e: usize| if input.charts == 0 { edges.boundary[e] } else { edges.cuts[e] > 0 };
    Ok(view.picture(paper(), color, edges, &line, is_line))
}

fn layout_panel(input: &Measured, edges: &EdgeTable) -> Canvas {
    let mut canvas = background((SMALL, SMALL));
    draw_layout(
        &mut canvas,
        input,
        edges,
        Pages::new(input.pages),
        (12 * FACTOR) as f32,
        FACTOR as f32,
    );
    canvas
}

/// A canvas as PNG.
pub(super) fn encode_png(
    page: &Canvas,
    compression: png::Compression,
) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, page.width as u32, page.height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(compression);
    let mut writer = encoder.write_header()?;
    let colors: Vec<[u8; 3]> = tasks::even("pixels", page.pixels.len(), || {
        page.pixels.par_iter().map(|p| encode(*p)).collect()
    });
    writer.write_image_data(colors.as_flattened())?;
    writer.finish()?;
    Ok(bytes)
}
