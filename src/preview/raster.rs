//! Which face is seen at each pixel, by a depth buffer. Bands of rows are drawn in parallel, each band
//! all its faces in order, so the picture does not depend on the thread count.

use rayon::prelude::*;

use super::camera::{Camera, Seen};
use super::canvas::spans;
use crate::contract::{Cancel, Canceled};
use crate::mesh::{NONE, Surface};
use crate::tasks;

/// Rows a band.
const BAND: usize = 32;
/// Pixels that faces may cover, one over another. No object comes near it; a soup of thousands of
/// large faces would take minutes, so the faces beyond are left out.
const MOST_COVERED: f64 = 4e8;

/// What is seen.
#[derive(Debug, Clone)]
pub(super) struct Visible {
    pub size: usize,
    /// Face at each pixel, or [`NONE`].
    pub face: Vec<u32>,
    /// 1/depth at each pixel, 0 where nothing is.
    pub nearness: Vec<f32>,
    /// Where each vertex is seen.
    pub vertices: Vec<Seen>,
}

impl Visible {
    /// Draws the faces that can be seen. Of two sheets at one place only the one that faces the eye
    /// is drawn; a face without a mate is seen from both sides.
    pub(super) fn new(
        surface: &Surface,
        camera: &Camera,
        size: usize,
        cancel: &Cancel,
    ) -> Result<Self, Canceled> {
        let vertices: Vec<Seen> = surface.positions.iter().map(|p| camera.see(*p)).collect();
        let corners = |f: u32| surface.triangles[f as usize].map(|v| vertices[v as usize]);
        let mut bands: Vec<Vec<u32>> = vec![vec![]; size.div_ceil(BAND)];
        let mut covered = 0.0;
        for f in 0..surface.face_count() as u32 {
            let [a, b, c] = corners(f).map(|s| s.at);
            let towards = (b - a).perp_dot(c - a) < 0.0; // y is down
            if !towards && surface.sheet_mate[f as usize] != NONE {
                continue;
            }
            covered += 0.5 * f64::from((b - a).perp_dot(c - a).abs());
            if covered > MOST_COVERED {
                break;
            }
            let (low, high) = (a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y));
            let first = low.max(0.0) as usize / BAND;
            let last = (high.max(0.0) as usize / BAND + 1).min(bands.len());
            for band in bands.get_mut(first..last).unwrap_or_default() {
                band.push(f);
            }
        }
        cancel.check()?;
        let mut face = vec![NONE; size * size];
        let mut nearness = vec![0.0f32; size * size];
        tasks::even("raster", bands.len(), || {
            face.par_chunks_mut(BAND * size)
                .zip(nearness.par_chunks_mut(BAND * size))
                .enumerate()
                .for_each(|(i, (face, nearness))| {
                    let top = i * BAND;
                    let bottom = (top + BAND).min(size);
                    for &f in &bands[i] {
                        draw(f, corners(f), size, top..bottom, face, nearness);
                    }
                })
        });
        cancel.check()?;
        Ok(Self { size, face, nearness, vertices })
    }

    /// Shares of a face's corners at the centre of a pixel, true to perspective.
    pub(super) fn shares(&self, surface: &Surface, pixel: usize) -> [f32; 3] {
        let corners =
            surface.triangles[self.face[pixel] as usize].map(|v| self.vertices[v as usize]);
        let p = center(pixel, self.size);
        let twist = |i: usize, j: usize| (corners[i].at - p).perp_dot(corners[j].at - p);
        let shares = [
            twist(1, 2) * corners[0].nearness,
            twist(2, 0) * corners[1].nearness,
            twist(0, 1) * corners[2].nearness,
        ];
        let sum: f32 = shares.iter().sum();
        if sum == 0.0 { [1.0 / 3.0; 3] } else { shares.map(|s| (s / sum).clamp(0.0, 1.0)) }
    }
}

/// The centre of a pixel.
pub(super) fn center(pixel: usize, width: usize) -> glam::Vec2 {
    glam::Vec2::new((pixel % width) as f32 + 0.5, (pixel / width) as f32 + 0.5)
}

/// Draws one face into a band of rows.
fn draw(
    f: u32,
    corners: [Seen; 3],
    size: usize,
    rows: std::ops::Range<usize>,
    face: &mut [u32],
    nearness: &mut [f32],
) {
    let [a, b, c] = corners;
    let (e, g) = (b.at - a.at, c.at - a.at);
    let twist = e.perp_dot(g);
    if twist == 0.0 {
        return;
    }
    // 1/depth is linear on the screen.
    let (p, q) = (b.nearness - a.nearness, c.nearness - a.nearness);
    let slope = glam::Vec2::new(p * g.y - q * e.y, q * e.x - p * g.x) / twist;
    for (y, span) in spans(corners.map(|s| s.at), rows.start, rows.end, size) {
        for x in span {
            let offset = glam::Vec2::new(x as f32 + 0.5, y as f32 + 0.5) - a.at;
            let near = a.nearness + slope.dot(offset);
            let pixel = (y - rows.start) * size + x;
            if near > nearness[pixel] {
                nearness[pixel] = near;
                face[pixel] = f;
            }
        }
    }
}
