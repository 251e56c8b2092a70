//! Ambient occlusion from the depth buffer: McGuire, Osman, Bukowski and Hennessy, "The Alchemy
//! screen-space ambient obscurance algorithm", 2011, doi:10.1145/2018323.2018327. Points around a
//! pixel that stand above its tangent plane darken it.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::camera::Camera;
use super::raster::Visible;
use crate::tasks;

/// Points a pixel; radius over the diagonal; strength; how far above the plane still is on it.
const POINTS: usize = 10;
const RADIUS: f32 = 0.07;
const STRENGTH: f32 = 1.1;
const BIAS: f32 = 0.0015;

/// What is seen at the first pixel of each block, in single precision: looked at so often that it is worth
/// keeping small.
struct Blocks {
    width: usize,
    /// Depth, 0 where nothing is.
    depths: Vec<f32>,
    /// Camera space at depth 1: x of each column, y of each row.
    across: Vec<f32>,
    up: Vec<f32>,
}

impl Blocks {
    fn new(seen: &Visible, camera: &Camera, block: usize) -> Self {
        let width = seen.size / block;
        let depth = |i: usize| match seen.nearness[first_pixel(i, width, block, seen.size)] {
            0.0 => 0.0,
            near => 1.0 / near,
        };
        let middle = |i: usize| (i * block) as f32 + 0.5;
        let ray = |i: usize| camera.unsee(Vec2::splat(middle(i)), 1.0);
        Self {
            width,
            depths: tasks::even("occlusion", width * width, || {
                (0..width * width).into_par_iter().map(depth).collect()
            }),
            across: (0..width).map(|x| ray(x).x).collect(),
            up: (0..width).map(|y| ray(y).y).collect(),
        }
    }

    /// The point in camera space at (`x`, `y`), where something is.
    fn point(&self, x: usize, y: usize) -> Option<Vec3> {
        let depth = self.depths[y * self.width + x];
        (depth > 0.0).then(|| Vec3::new(self.across[x], self.up[y], -1.0) * depth)
    }
}

/// The first pixel of block `i`, of `width` a row.
fn first_pixel(i: usize, width: usize, block: usize, size: usize) -> usize {
    i / width * block * size + i % width * block
}

/// Ambient light that reaches each block of `block` × `block` pixels, 0 to 1, smoothed over a few.
pub(super) fn ambient_light(
    seen: &Visible,
    camera: &Camera,
    normals: &[Vec3],
    diagonal: f32,
    block: usize,
) -> Vec<f32> {
    let blocks = Blocks::new(seen, camera, block);
    let width = blocks.width;
    let spirals: Vec<[Vec2; POINTS]> = (0..16).map(|k| spiral(k / 4, k % 4)).collect();
    let radius = RADIUS * diagonal;
    let raw: Vec<f32> = tasks::even("occlusion", width * width, || {
        (0..width * width)
            .into_par_iter()
            .map(|i| {
                let (x, y) = (i % width, i / width);
                let Some(point) = blocks.point(x, y) else { return 1.0 };
                let pixel = first_pixel(i, width, block, seen.size);
                let normal = facing(normals[seen.face[pixel] as usize], point);
                let reach = radius * camera.pixels(seen.nearness[pixel]) / block as f32;
                let spiral = spirals[x % 4 * 4 + y % 4].map(|way| way * reach);
                obscurance(&blocks, [x, y], (point, normal), diagonal, &spiral)
            })
            .collect()
    });
    tasks::even("occlusion", width * width, || {
        (0..width * width)
            .into_par_iter()
            .map(|i| {
                let (x, y, depth) = (i % width, i / width, blocks.depths[i]);
                if depth == 0.0 {
                    return 1.0;
                }
                // The pattern repeats every 4 blocks: a 4 × 4 mean over like depths removes it.
                let (mut sum, mut count) = (0.0, 0.0f32);
                for j in y.saturating_sub(2)..(y + 2).min(width) {
                    for k in x.saturating_sub(2)..(x + 2).min(width) {
                        let other = blocks.depths[j * width + k];
                        if (other - depth).abs() < 0.02 * diagonal {
                            sum += raw[j * width + k];
                            count += 1.0;
                        }
                    }
                }
                if count > 0.0 { sum / count } else { raw[i] }
            })
            .collect()
    })
}

/// How far out the point `k` of a spiral lies, 0 to 1.
fn share(k: usize) -> f32 {
    (k as f32 + 0.5) / POINTS as f32
}

/// The ways to the points of a spiral of radius 1, turned by one of 16 angles: for block (x, y), both mod 4.
fn spiral(x: usize, y: usize) -> [Vec2; POINTS] {
    let turn = (x * 4 + y * 7) as f32 * 2.399;
    std::array::from_fn(|k| {
        let (sin, cos) = (turn + share(k) * 2.0 * std::f32::consts::TAU).sin_cos();
        Vec2::new(cos, sin) * share(k)
    })
}

/// `spiral`: ways in blocks.
fn obscurance(
    blocks: &Blocks,
    [x, y]: [usize; 2],
    (point, normal): (Vec3, Vec3),
    diagonal: f32,
    spiral: &[Vec2; POINTS],
) -> f32 {
    let here = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
    let radius = RADIUS * diagonal;
    let fading = (1.6 * radius).powi(-2);
    let mut sum = 0.0;
    for way in spiral {
        let q = here + *way;
        if q.min_element() < 0.0 || q.max_element() >= blocks.width as f32 {
            continue;
        }
        let Some(other) = blocks.point(q.x as usize, q.y as usize) else { continue };
        let offset = other - point;
        let rise = offset.dot(normal) - BIAS * diagonal;
        let squared = offset.length_squared();
        if rise > 0.0 {
            let fade = (1.0 - squared * fading).max(0.0);
            sum += fade * rise / (squared.sqrt() + 0.02 * radius);
        }
    }
    (1.0 - STRENGTH * 2.0 * sum / POINTS as f32).clamp(0.0, 1.0)
}

/// A normal turned to the eye, which is at the origin.
pub(super) fn facing(normal: Vec3, point: Vec3) -> Vec3 {
    if normal.dot(point) > 0.0 { -normal } else { normal }
}
