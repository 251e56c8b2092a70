//! The UV layout as a panel of the preview, drawn as the texture looks (v down).

use glam::{Vec2, Vec3};

use super::canvas::Canvas;
use super::lines::LineMask;
use super::pages::Pages;
use super::palette::{linear, part_color};
use crate::metrics::{EdgeTable, Measured};

/// With more faces their edges would only make the panel grey.
const MOST_FACES: usize = 6_000;

/// Draws the pages onto a canvas, `margin` pixels from its sides. Lines are `unit` pixels wide.
pub(super) fn draw_layout(
    canvas: &mut Canvas,
    input: &Measured,
    edges: &EdgeTable,
    pages: Pages,
    margin: f32,
    unit: f32,
) {
    let room = Vec2::new(canvas.width as f32, canvas.height as f32) - 2.0 * margin;
    let size = Vec2::from(pages.size());
    let scale = (room / size).min_element();
    let low = margin + 0.5 * (room - size * scale);
    let place = |page: u32, uv: [f32; 2]| low + Vec2::from(pages.place(page, uv)) * scale;
    let corners = |page: u32| {
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|corner| place(page, corner))
    };
    for [a, b, c, d] in pages.all().map(corners) {
        canvas.fill([a, b, c], Vec3::ONE);
        canvas.fill([a, c, d], Vec3::ONE);
    }
    for f in 0..input.uvs.len() {
        if input.face_map(f).is_some() && pages.has(input.page(input.chart_of[f])) {
            let hue = linear(part_color(input.part_of[f]));
            let page = input.page(input.chart_of[f]);
            canvas.fill(input.uvs[f].map(|uv| place(page, uv)), Vec3::ONE.lerp(hue, 0.78));
        }
    }
    let drawn = |h: u32| pages.has(input.page(input.chart_of[h as usize / 3]));
    let segment = |h: u32| {
        let (f, k) = (h as usize / 3, h as usize % 3);
        let page = input.page(input.chart_of[f]);
        (place(page, input.uvs[f][k]), place(page, input.uvs[f][(k + 1) % 3]))
    };
    let (width, height) = (canvas.width, canvas.height);
    if input.surface.face_count() <= MOST_FACES {
        let mut mask = LineMask::new(width, height);
        for h in edges.all_half_edges().iter().filter(|h| drawn(**h)) {
            let (a, b) = segment(*h);
            mask.draw(a, b, 0.25 * unit, |_, _| true);
        }
        canvas.lay(&mask.scaled(0.35), Vec3::ONE);
    }
    let mut mask = LineMask::new(width, height);
    for h in (0..edges.len()).flat_map(|e| edges.rim(e)).filter(|h| drawn(*h)) {
        let (a, b) = segment(h);
        mask.draw(a, b, 0.9 * unit, |_, _| true);
    }
    canvas.lay(&mask.scaled(0.75), linear([0x26, 0x2a, 0x33]));
    let mut frame = LineMask::new(width, height);
    for corners in pages.all().map(corners) {
        for i in 0..4 {
            frame.draw(corners[i], corners[(i + 1) % 4], unit, |_, _| true);
        }
    }
    canvas.lay(&frame.scaled(0.8), linear([0xa8, 0xae, 0xb8]));
}
