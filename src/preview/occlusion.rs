//! Ambient occlusion from the depth buffer: McGuire, Osman, Bukowski and Hennessy, "The Alchemy
//! screen-space ambient obscurance algorithm", 2011, doi:10.1145/2018323.2018327. Points around a
//! pixel that stand above its tangent plane darken it.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::camera::Camera;
use super::raster::{Visible, center};
use crate::mesh::NONE;

/// Points a pixel; radius over the diagonal; strength; how far above the plane still is on it.
const POINTS: usize = 14;
const RADIUS: f32 = 0.07;
const STRENGTH: f32 = 1.1;
const BIAS: f32 = 0.0015;

/// Ambient light that reaches each block of `block` × `block` pixels, 0 to 1, smoothed over a few.
pub(super) fn ambient_light(
    seen: &Visible,
    camera: &Camera,
    normals: &[Vec3],
    diagonal: f32,
    block: usize,
) -> Vec<f32> {
    let width = seen.size / block;
    let at = |i: usize| (i / width * block) * seen.size + i % width * block;
    let spirals: Vec<[Vec2; POINTS]> = (0..16).map(|k| spiral(k / 4, k % 4)).collect();
    let raw: Vec<f32> = (0..width * width)
        .into_par_iter()
        .map(|i| {
            let spiral = &spirals[i % width % 4 * 4 + i / width % 4];
            obscurance(seen, camera, normals, diagonal, at(i), spiral)
        })
        .collect();
    (0..width * width)
        .into_par_iter()
        .map(|i| {
            let (x, y, near) = (i % width, i / width, seen.nearness[at(i)]);
            if near == 0.0 {
                return 1.0;
            }
            // The pattern repeats every 4 blocks: a 4 × 4 mean over like depths removes it.
            let (mut sum, mut count) = (0.0, 0.0f32);
            for j in y.saturating_sub(2)..(y + 2).min(width) {
                for k in x.saturating_sub(2)..(x + 2).min(width) {
                    let other = seen.nearness[at(j * width + k)];
                    if (1.0 / other - 1.0 / near).abs() < 0.02 * diagonal {
                        sum += raw[j * width + k];
                        count += 1.0;
                    }
                }
            }
            if count > 0.0 { sum / count } else { raw[i] }
        })
        .collect()
}

/// How far out the point `k` of a spiral lies, 0 to 1.
fn share(k: usize) -> f32 {
    (k as f32 + 0.5) / POINTS as f32
}

/// The ways to the points of a spiral, turned by one of 16 angles: for block (x, y), both mod 4.
fn spiral(x: usize, y: usize) -> [Vec2; POINTS] {
    let turn = (x * 4 + y * 7) as f32 * 2.399;
    std::array::from_fn(|k| {
        let (sin, cos) = (turn + share(k) * 2.0 * std::f32::consts::TAU).sin_cos();
        Vec2::new(cos, sin)
    })
}

fn obscurance(
    seen: &Visible,
    camera: &Camera,
    normals: &[Vec3],
    diagonal: f32,
    pixel: usize,
    spiral: &[Vec2; POINTS],
) -> f32 {
    let face = seen.face[pixel];
    if face == NONE {
        return 1.0;
    }
    let near = seen.nearness[pixel];
    let here = center(pixel, seen.size);
    let point = camera.unsee(here, near);
    let normal = facing(normals[face as usize], point);
    let radius = RADIUS * diagonal;
    let reach = radius * camera.pixels(near);
    let mut sum = 0.0;
    for (k, &way) in spiral.iter().enumerate() {
        let q = here + way * (reach * share(k));
        if q.min_element() < 0.0 || q.max_element() >= seen.size as f32 {
            continue;
        }
        let other = q.y as usize * seen.size + q.x as usize;
        if seen.face[other] == NONE {
            continue;
        }
        let offset = camera.unsee(center(other, seen.size), seen.nearness[other]) - point;
        let distance = offset.length();
        let fade = (1.0 - (distance / (1.6 * radius)).powi(2)).max(0.0);
        let rise = (offset.dot(normal) - BIAS * diagonal).max(0.0);
        sum += fade * rise / (distance + 0.02 * radius);
    }
    (1.0 - STRENGTH * 2.0 * sum / POINTS as f32).clamp(0.0, 1.0)
}

/// A normal turned to the eye, which is at the origin.
pub(super) fn facing(normal: Vec3, point: Vec3) -> Vec3 {
    if normal.dot(point) > 0.0 { -normal } else { normal }
}
