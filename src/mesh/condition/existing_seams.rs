//! Seams that the file's own texture coordinates have: where an artist has cut before. A new cut that
//! can follow them is cheaper (docs/method.md, 4.1).

use super::file::FileFaces;
use crate::mesh::{NONE, Scene, Surface};

/// Corners whose coordinates are this close, over the coordinates' range, are together.
const TOGETHER: f32 = 1e-5;

/// Coordinates that fall apart at more than this share of the edges are of single faces, and say
/// nothing.
const SCATTERED: f64 = 0.5;

/// Whether each half-edge of the surface is such a seam; empty where the file says nothing.
pub fn existing_seams(scene: &Scene, file: &FileFaces, surface: &Surface) -> Vec<bool> {
    if scene.primitives.iter().all(|p| p.texcoords().is_none()) {
        return Vec::new();
    }
    let twin = &surface.twin;
    let mut of_file: Vec<[[f32; 2]; 3]> = Vec::with_capacity(file.triangles.len());
    for primitive in &scene.primitives {
        match primitive.texcoords() {
            Some(texcoords) => of_file.extend(texcoords),
            None => of_file.resize(of_file.len() + primitive.triangles.len(), [[f32::NAN; 2]; 3]),
        }
    }
    let corner = |h: usize| {
        let face = surface.origins[h / 3].face as usize;
        let vertex = surface.triangles[h / 3][h % 3];
        let k = file.welded[face].iter().position(|&v| v == vertex);
        // The vertex of a cap that its face does not have has none either.
        k.map_or([f32::NAN; 2], |k| of_file[face][k])
    };
    let corners: Vec<[f32; 2]> = (0..twin.len()).map(corner).collect();
    let known = || corners.iter().flatten().filter(|x| x.is_finite());
    let low = known().copied().fold(f32::INFINITY, f32::min);
    let high = known().copied().fold(f32::NEG_INFINITY, f32::max);
    let near = TOGETHER * (high - low);
    let next = |h: usize| h - h % 3 + (h + 1) % 3;
    // Absent coordinates are apart from none.
    let apart =
        |h: usize, t: usize| (0..2).any(|axis| (corners[h][axis] - corners[t][axis]).abs() > near);
    let seams: Vec<bool> = (0..twin.len())
        .map(|h| {
            let t = twin[h];
            t != NONE && (apart(h, next(t as usize)) || apart(next(h), t as usize))
        })
        .collect();
    let inner = twin.iter().filter(|t| **t != NONE).count() as f64;
    let count = seams.iter().filter(|s| **s).count() as f64;
    if count > 0.0 && count <= SCATTERED * inner { seams } else { Vec::new() }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::contract::{Run, Winding};
    use crate::mesh::{Attribute, TEXCOORD, Values, condition};

    /// A strip of two quads whose coordinates jump by `gap` at the edge between them, and by `step` at
    /// every face.
    fn strip(gap: f32, step: f32) -> Scene {
        let positions = (0..6).map(|i| DVec3::new(f64::from(i % 3), f64::from(i / 3), 0.0));
        let triangles = vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]];
        let at = |face: usize, v: u32| {
            [(v % 3) as f32 + if face < 2 { 0.0 } else { gap }, (v / 3) as f32 + face as f32 * step]
        };
        let texcoords =
            triangles.iter().enumerate().flat_map(|(f, t): (usize, &[u32; 3])| t.map(|v| at(f, v)));
        let set = Attribute {
            name: TEXCOORD.to_owned(),
            values: Values::floats(texcoords.collect()),
            corners: Some((0..4).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect()),
        };
        let mut scene = Scene::from_triangles(positions.collect(), triangles);
        scene.primitives[0].attributes.push(set);
        scene
    }

    fn conditioned(scene: &Scene) -> Surface {
        condition(scene, Winding::Surface, &Run::quiet()).unwrap().surface
    }

    fn seams_of(scene: &Scene) -> Vec<bool> {
        conditioned(scene).existing_seams
    }

    #[test]
    fn a_seam_is_where_coordinates_part() {
        let surface = conditioned(&strip(1.0, 0.0));
        let seams: Vec<usize> = (0..12).filter(|&h| surface.existing_seams[h]).collect();
        let ends = |&h: &usize| [surface.from(h as u32), surface.to(h as u32)].map(|v| v / 2);
        assert_eq!(seams.iter().map(ends).collect::<Vec<_>>(), [[1, 1]; 2], "between the quads");
        assert!(seams_of(&strip(0.0, 0.0)).is_empty());
    }

    #[test]
    fn coordinates_of_single_faces_say_nothing() {
        let mut scene = strip(0.0, 10.0);
        assert!(seams_of(&scene).is_empty());
        scene.primitives[0].attributes.clear();
        assert!(seams_of(&scene).is_empty());
    }
}
