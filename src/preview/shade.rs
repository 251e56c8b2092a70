//! An object, lit: a key light from the upper left, light from the sky and a little from below,
//! dimmed where the surface is hemmed in; seams on top as thin lines.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::camera::Camera;
use super::canvas::{Canvas, fade};
use super::lines::LineMask;
use super::occlusion::{ambient_light, facing};
use super::palette::linear;
use super::raster::{Visible, center};
use crate::contract::{Cancel, Canceled};
use crate::mesh::{NONE, Surface};
use crate::metrics::EdgeTable;
use crate::tasks;

/// Faces that meet at less than about 40° at a vertex are shaded as one smooth surface.
const SMOOTH: f64 = 0.77;
/// Around a vertex of more faces nothing is smoothed: a fan of thousands would cost their square.
const MOST_FACES: usize = 64;
/// A line shows through what is nearer by less than this share of the diagonal.
const LINE_BIAS: f32 = 0.004;

/// A view of an object, ready to be painted more than once.
pub(super) struct View<'a> {
    surface: &'a Surface,
    camera: Camera,
    pub seen: Visible,
    /// Unit normals of faces and of their corners, camera space.
    corner_normals: Vec<[Vec3; 3]>,
    ambient: Vec<f32>,
}

/// How lines are drawn.
pub(super) struct Line {
    pub color: [u8; 3],
    pub thick: f32,
    pub strength: f32,
}

/// Supersampling: pixels of a view a pixel of the picture, each way.
pub(super) const FACTOR: usize = 2;

impl<'a> View<'a> {
    /// A square view, `size` pixels wide before supersampling. `None` where there is nothing to see.
    pub(super) fn new(
        surface: &'a Surface,
        size: usize,
        cancel: &Cancel,
    ) -> Result<Option<Self>, Canceled> {
        let points =
            surface.triangles.iter().flat_map(|t| t.map(|v| surface.positions[v as usize]));
        let Some(camera) = Camera::framing(points, size * FACTOR) else { return Ok(None) };
        let seen = Visible::new(surface, &camera, size * FACTOR, cancel)?;
        let turned = |n: DVec3| camera.turned(n).as_vec3();
        let normals: Vec<Vec3> = surface.normals.iter().map(|n| turned(*n)).collect();
        let ambient = ambient_light(&seen, &camera, &normals, surface.diagonal as f32, FACTOR);
        cancel.check()?;
        let corner_normals = smooth_normals(surface).into_iter().map(|t| t.map(turned)).collect();
        cancel.check()?;
        Ok(Some(Self { surface, camera, seen, corner_normals, ambient }))
    }

    /// How much light a pixel of a face sends back, of what falls on it; `shares`: of the face's corners.
    fn shading(&self, pixel: usize, shares: [f32; 3]) -> f32 {
        let (size, face) = (self.seen.size, self.seen.face[pixel]);
        let point = self.camera.unsee(center(pixel, size), self.seen.nearness[pixel]);
        let [a, b, c] = self.corner_normals[face as usize];
        let normal = (a * shares[0] + b * shares[1] + c * shares[2]).normalize_or_zero();
        let block = (pixel / size / FACTOR) * (size / FACTOR) + pixel % size / FACTOR;
        lit(facing(normal, point), point, self.ambient[block])
    }

    /// Paints the view over `canvas`. `color(face, shares of its corners, pixels a world unit)`.
    pub(super) fn paint(
        &self,
        canvas: &mut Canvas,
        color: impl Fn(u32, [f32; 3], f32) -> Vec3 + Sync,
    ) {
        tasks::even("light", self.seen.face.len(), || {
            canvas.pixels.par_iter_mut().enumerate().for_each(|(pixel, light)| {
                let face = self.seen.face[pixel];
                if face != NONE {
                    let shares = self.seen.shares(self.surface, pixel);
                    let color = color(face, shares, self.camera.pixels(self.seen.nearness[pixel]));
                    *light = color * self.shading(pixel, shares);
                }
            })
        });
    }

    /// Draws the edges that `wanted` picks, where they can be seen.
    pub(super) fn draw_edges(
        &self,
        canvas: &mut Canvas,
        edges: &EdgeTable,
        line: &Line,
        wanted: impl Fn(usize) -> bool,
    ) {
        canvas.lay(&self.lines(edges, line, wanted), linear(line.color));
    }

    /// How much of each pixel the edges that `wanted` picks cover, where they can be seen.
    fn lines(&self, edges: &EdgeTable, line: &Line, wanted: impl Fn(usize) -> bool) -> Vec<f32> {
        let size = self.seen.size;
        let mut mask = LineMask::new(size, size);
        let bias = LINE_BIAS * self.surface.diagonal as f32;
        for e in (0..edges.len()).filter(|&e| wanted(e)) {
            let [a, b] = edges.ends[e].map(|v| self.seen.vertices[v as usize]);
            mask.draw(a.at, b.at, line.thick * FACTOR as f32, |pixel, t| {
                let near = a.nearness + (b.nearness - a.nearness) * t;
                // Depth of the line less the bias against depth of the surface.
                let there = self.seen.nearness[pixel];
                there <= 0.0 || 1.0 / near - bias <= 1.0 / there
            });
        }
        mask.scaled(line.strength)
    }

    /// The view over paper that fades from top to bottom, with the edges that `wanted` picks, at the picture's
    /// own resolution. No canvas of all pixels is kept for it, and a face is shaded once a pixel of the picture;
    /// its colour is asked for in all of them. `color` as for [`View::paint`].
    pub(super) fn picture(
        &self,
        paper: [Vec3; 2],
        color: impl Fn(u32, [f32; 3], f32) -> Vec3 + Sync,
        edges: &EdgeTable,
        line: &Line,
        wanted: impl Fn(usize) -> bool,
    ) -> Canvas {
        let (covered, ink) = (self.lines(edges, line, wanted), linear(line.color));
        let (size, width) = (self.seen.size, self.seen.size / FACTOR);
        let light = |i: usize| {
            let (mut sum, mut shaded) = (Vec3::ZERO, (NONE, 0.0));
            for k in 0..FACTOR * FACTOR {
                let (x, y) = (i % width * FACTOR + k % FACTOR, i / width * FACTOR + k / FACTOR);
                let pixel = y * size + x;
                let face = self.seen.face[pixel];
                let plain = if face == NONE {
                    fade(paper, y, size)
                } else {
                    let shares = self.seen.shares(self.surface, pixel);
                    if shaded.0 != face {
                        shaded = (face, self.shading(pixel, shares));
                    }
                    let scale = self.camera.pixels(self.seen.nearness[pixel]);
                    color(face, shares, scale) * shaded.1
                };
                let lined = covered[pixel];
                sum += if lined == 0.0 { plain } else { plain.lerp(ink, lined) };
            }
            sum / (FACTOR * FACTOR) as f32
        };
        let pixels = tasks::even("light", width * width, || {
            (0..width * width).into_par_iter().map(light).collect()
        });
        Canvas { width, height: width, pixels }
    }

    /// Draws points of the surface as dots of `radius` pixels, where they can be seen; a later one covers
    /// the ones before it. No dot reaches beyond the object's outline.
    pub(super) fn draw_dots(
        &self,
        canvas: &mut Canvas,
        radius: f32,
        dots: impl Iterator<Item = (DVec3, Vec3)>,
    ) {
        let (size, radius) = (self.seen.size, radius * FACTOR as f32);
        let bias = LINE_BIAS * self.surface.diagonal as f32;
        let rows = |middle: f32| {
            let first = (middle - radius).max(0.0) as usize;
            first..((middle + radius).max(0.0) as usize + 1).min(size)
        };
        for (point, color) in dots {
            let dot = self.camera.see(point);
            for y in rows(dot.at.y) {
                for pixel in rows(dot.at.x).map(|x| y * size + x) {
                    let there = self.seen.nearness[pixel];
                    let is_seen = there > 0.0 && 1.0 / dot.nearness - bias <= 1.0 / there;
                    if is_seen && center(pixel, size).distance(dot.at) <= radius {
                        canvas.pixels[pixel] = color;
                    }
                }
            }
        }
    }
}

/// Light on a point of the surface: what its colour is multiplied by.
fn lit(normal: Vec3, point: Vec3, ambient: f32) -> f32 {
    let key = Vec3::new(-0.45, 0.70, 0.55).normalize();
    let fill = Vec3::new(0.80, 0.15, 0.45).normalize();
    let sky = 0.36 + 0.16 * normal.y;
    // Towards its silhouette a surface turns a little darker, which sets parts off each other.
    let edge = 0.82 + 0.18 * normal.dot(-point.normalize_or_zero()).clamp(0.0, 1.0);
    let direct = 0.68 * normal.dot(key).max(0.0) + 0.24 * normal.dot(fill).max(0.0);
    edge * (sky * ambient + direct * (0.35 + 0.65 * ambient))
}

/// Normals of the corners of every face: the mean over the faces around the vertex that meet it
/// smoothly, weighted by area.
fn smooth_normals(surface: &Surface) -> Vec<[DVec3; 3]> {
    let mut starts = vec![0usize; surface.positions.len() + 1];
    for v in surface.triangles.iter().flatten() {
        starts[*v as usize + 1] += 1;
    }
    for i in 1..starts.len() {
        starts[i] += starts[i - 1];
    }
    let mut next = starts.clone();
    let mut around = vec![0u32; 3 * surface.face_count()];
    for (f, t) in surface.triangles.iter().enumerate() {
        for v in t {
            around[next[*v as usize]] = f as u32;
            next[*v as usize] += 1;
        }
    }
    tasks::even("corner normals", surface.face_count(), || {
        surface
            .triangles
            .par_iter()
            .enumerate()
            .map(|(f, t)| {
                let own = surface.normals[f];
                t.map(|v| {
                    let fan = &around[starts[v as usize]..starts[v as usize + 1]];
                    if fan.len() > MOST_FACES {
                        return own;
                    }
                    fan.iter()
                        .map(|g| *g as usize)
                        .filter(|&g| surface.normals[g].dot(own) > SMOOTH)
                        .map(|g| surface.normals[g] * surface.areas[g])
                        .sum::<DVec3>()
                        .try_normalize()
                        .unwrap_or(own)
                })
            })
            .collect()
    })
}
