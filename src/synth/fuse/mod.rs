//! The union of an object's parts as one closed manifold body whose parts share edges: parts as
//! signed distances (`distance`), their union on a grid as a manifold quad mesh (`cubes`), its
//! vertices moved onto the parts' surfaces (`shape`), decimated to the wanted size (`decimate`). Each
//! face is labelled with the part that it lies on.

mod cubes;
mod decimate;
mod distance;
mod shape;

use glam::DVec3;

use super::SynthPart;
use distance::Parts;

/// One closed manifold body with a part number a face.
#[derive(Debug, Clone, PartialEq)]
pub struct FusedBody {
    /// Vertex positions, metres.
    pub positions: Vec<DVec3>,
    /// Vertex triples, wound outwards.
    pub triangles: Vec<[u32; 3]>,
    /// Index into the object's parts. Length: faces.
    pub labels: Vec<u32>,
}

/// Parts below this share of the whole area do not decide the grid: they stay as bumps.
const SMALL: f64 = 0.02;
/// Most samples along the diagonal: what is thinner than that stays as a bump.
const MOST: f64 = 200.0;
/// How many triangles the grid gives for each one that is wanted.
const SURPLUS: f64 = 2.5;

/// Fuse closed solids that overlap. The body has about `wanted` triangles, more where shape and
/// topology need them.
pub(super) fn fuse(parts: &[SynthPart], wanted: usize) -> FusedBody {
    let sizes: Vec<(f64, f64)> = parts.iter().map(area_and_volume).collect();
    let area: f64 = sizes.iter().map(|s| s.0).sum();
    // 2 V / A is the thickness of a plate and the radius of a rod.
    let thinnest = sizes
        .iter()
        .filter(|s| s.0 > SMALL * area)
        .map(|s| 2.0 * s.1 / s.0)
        .fold(f64::INFINITY, f64::min);
    let parts = Parts::new(parts);
    let spacing = (2.0 * area / (SURPLUS * wanted as f64))
        .sqrt()
        .min(0.7 * thinnest)
        .max(parts.low.distance(parts.high) / MOST);
    let near = parts.near(2.5 * spacing);
    let (mut positions, quads) = cubes::surface(&parts, &near, spacing);
    shape::fit(&mut positions, &quads, &near, spacing);
    let triangles = shape::split(&positions, &quads);
    let (positions, triangles) = decimate::decimate(positions, triangles, wanted);
    let label = |t: &[u32; 3]| {
        let centre = t.iter().map(|&v| positions[v as usize]).sum::<DVec3>() / 3.0;
        near.closest(centre).map_or(0, |c| c.part)
    };
    let labels = triangles.iter().map(label).collect();
    FusedBody { positions, triangles, labels }
}

fn area_and_volume(part: &SynthPart) -> (f64, f64) {
    let corners = |t: &[u32; 3]| t.map(|v| part.positions[v as usize]);
    part.triangles.iter().map(corners).fold((0.0, 0.0), |(area, volume), [a, b, c]| {
        (area + 0.5 * (b - a).cross(c - a).length(), volume + a.dot(b.cross(c)) / 6.0)
    })
}
