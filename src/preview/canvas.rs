//! A rectangle of linear light, and what is drawn in the plane: triangles and lines.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use crate::tasks;

/// An image, row by row from the top.
#[derive(Debug, Clone)]
pub(super) struct Canvas {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<Vec3>,
}

impl Canvas {
    /// A canvas that fades from `top` to `bottom`.
    pub(super) fn gradient(width: usize, height: usize, top: Vec3, bottom: Vec3) -> Self {
        let row = |y: usize| fade([top, bottom], y, height);
        let pixels = (0..height).flat_map(|y| std::iter::repeat_n(row(y), width)).collect();
        Self { width, height, pixels }
    }

    /// Fills a triangle: every pixel whose centre it covers, rows clipped to the canvas.
    pub(super) fn fill(&mut self, corners: [Vec2; 3], color: Vec3) {
        for (y, span) in spans(corners, 0, self.height, self.width) {
            self.pixels[y * self.width + span.start..y * self.width + span.end].fill(color);
        }
    }

    /// Lays `color` over the canvas where `mask` says so.
    pub(super) fn lay(&mut self, mask: &[f32], color: Vec3) {
        tasks::even("pixels", mask.len(), || {
            self.pixels.par_iter_mut().zip(mask).filter(|(_, m)| **m != 0.0).for_each(
                |(pixel, m)| {
                    *pixel = pixel.lerp(color, *m);
                },
            )
        });
    }

    /// The part of the canvas whose top left corner is at (`x`, `y`); it must lie inside.
    pub(super) fn part(&self, x: usize, y: usize, width: usize, height: usize) -> Self {
        let rows = (y..y + height).map(|row| row * self.width + x);
        let pixels = rows.flat_map(|start| &self.pixels[start..start + width]).copied().collect();
        Self { width, height, pixels }
    }

    /// Copies another canvas, of `factor` times the resolution, to (`x`, `y`), averaging blocks.
    pub(super) fn paste_smaller(&mut self, other: &Canvas, factor: usize, x: usize, y: usize) {
        let weight = 1.0 / (factor * factor) as f32;
        for j in 0..other.height / factor {
            for i in 0..other.width / factor {
                let block = (0..factor * factor).map(|k| {
                    other.pixels[(j * factor + k / factor) * other.width + i * factor + k % factor]
                });
                let (px, py) = (x + i, y + j);
                if px < self.width && py < self.height {
                    self.pixels[py * self.width + px] = block.sum::<Vec3>() * weight;
                }
            }
        }
    }
}

/// Row `y` of `height` that fade from the first colour to the second.
pub(super) fn fade([top, bottom]: [Vec3; 2], y: usize, height: usize) -> Vec3 {
    top.lerp(bottom, y as f32 / height.max(2) as f32)
}

/// The pixels of each row in `first..last` whose centres a triangle covers; rows no wider than
/// `width`.
pub(super) fn spans(
    corners: [Vec2; 3],
    first: usize,
    last: usize,
    width: usize,
) -> impl Iterator<Item = (usize, std::ops::Range<usize>)> {
    let low = corners[0].y.min(corners[1].y).min(corners[2].y);
    let high = corners[0].y.max(corners[1].y).max(corners[2].y);
    // Casts from float saturate, so wild coordinates only clip.
    let start = ((low - 0.5).ceil().max(0.0) as usize).max(first);
    let end = ((high - 0.5).ceil().max(0.0) as usize).min(last);
    (start..end.max(start)).filter_map(move |y| {
        let line = y as f32 + 0.5;
        let (mut left, mut right) = (f32::INFINITY, f32::NEG_INFINITY);
        for k in 0..3 {
            // The same order of ends on both sides of an edge: no gap and no overlap between
            // neighbours.
            let (mut a, mut b) = (corners[k], corners[(k + 1) % 3]);
            if (b.y, b.x) < (a.y, a.x) {
                (a, b) = (b, a);
            }
            if a.y <= line && line < b.y {
                let x = a.x + (line - a.y) * (b.x - a.x) / (b.y - a.y);
                left = left.min(x);
                right = right.max(x);
            }
        }
        let start = ((left - 0.5).ceil().max(0.0) as usize).min(width);
        let end = ((right - 0.5).ceil().max(0.0) as usize).min(width);
        (start < end).then_some((y, start..end))
    })
}
