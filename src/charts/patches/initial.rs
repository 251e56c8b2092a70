//! The patches by themselves, before any two are joined: what a cut starts from, to be looked at.

use rayon::prelude::*;

use super::sides::sides;
use super::tube;
use crate::charts::build::{ChartOptions, pieces};
use crate::charts::component::patchwork;
use crate::charts::limits::ChartLimits;
use crate::charts::limits::visibility::visibility;
use crate::charts::part_mesh::PartMesh;
use crate::contract::{Canceled, Run};
use crate::mesh::{NONE, Surface};

/// The patch of each face that [`build`](crate::charts::build) starts from, the sides of tubes among them; [`NONE`]
/// where `part_of` is, and for faces without area. Numbers go from 0 without a gap, in order of part.
/// Length: faces.
pub fn initial_patches(
    surface: &Surface,
    part_of: &[u32],
    options: &ChartOptions,
    run: &Run,
) -> Result<Vec<u32>, Canceled> {
    let limits = ChartLimits::of(surface, options);
    let visibility = visibility(surface, run)?;
    let part = |f: u32| part_of[f as usize];
    let mut faces: Vec<u32> = (0..part_of.len() as u32).filter(|&f| part(f) != NONE).collect();
    faces.sort_by_key(|&f| part(f));
    let whole: Vec<Vec<u32>> = faces
        .chunk_by(|&f, &g| part(f) == part(g))
        .flat_map(|faces| pieces(&PartMesh::new(surface, faces.to_vec())))
        .collect();
    let cut = |faces: Vec<u32>| {
        let piece = PartMesh::new(surface, faces).seen(visibility.as_deref());
        let sides = sides(&piece, tube::fit(&piece).as_ref(), limits.bound);
        let patch_of = patchwork(&piece, &sides, &limits, run)?.chart_of;
        Ok((piece.faces, patch_of))
    };
    let cut: Result<Vec<_>, Canceled> = whole.into_par_iter().map(cut).collect();
    let mut patch_of = vec![NONE; part_of.len()];
    let mut first = 0;
    for (faces, own) in cut? {
        for (&f, &patch) in faces.iter().zip(&own) {
            patch_of[f as usize] = first + patch;
        }
        first += own.iter().max().map_or(0, |&most| most + 1);
    }
    Ok(patch_of)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::contract::{UnwrapOptions, Winding};
    use crate::mesh::{Scene, condition};

    #[test]
    fn a_cube_of_two_parts_has_a_patch_a_side_and_none_crosses_its_part() {
        let positions: Vec<DVec3> = (0..8)
            .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
            .collect();
        let sides: [[u32; 4]; 6] =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let run = Run::quiet();
        let scene = Scene::from_triangles(positions, triangles);
        let surface = condition(&scene, Winding::Surface, &run).unwrap().surface;
        // The upper side is cut along its diagonal by a border of parts, the lower one is in none.
        let part_of = surface.from_file_order(&[1, 1, 1, 1, 1, 1, 1, 4, 1, 1, NONE, NONE]);
        let options = ChartOptions::from(&UnwrapOptions::default());
        let found = initial_patches(&surface, &part_of, &options, &run).unwrap();
        let mut patch_of = [0; 12];
        for (origin, &patch) in surface.origins.iter().zip(&found) {
            patch_of[origin.face as usize] = patch;
        }
        for side in [0, 2, 4, 8] {
            assert_eq!(patch_of[side], patch_of[side + 1], "{patch_of:?}");
        }
        assert_eq!(patch_of[10..], [NONE; 2]);
        let mut numbers: Vec<u32> = patch_of[..10].to_vec();
        numbers.sort_unstable();
        numbers.dedup();
        // The five sides of the first part, and the one face of the other, last.
        assert_eq!(numbers, [0, 1, 2, 3, 4, 5]);
        assert_eq!(patch_of[7], 5);
    }
}
