//! The instances of meshes that are scaled unevenly against the one that is measured: the same coordinates
//! are more distorted there.

use glam::DMat3;
use rayon::prelude::*;

use super::distortion::Dirichlet;
use super::{FaceMap, Measured};
use crate::mesh::NONE;

/// Symmetric Dirichlet energy of some faces after a linear transform of the object, each chart at its own
/// best scale; `None` where nothing of them has area.
pub fn transformed_dirichlet(input: &Measured, faces: &[u32], transform: DMat3) -> Option<f64> {
    let mut faces: Vec<u32> =
        faces.iter().copied().filter(|&f| input.chart_of[f as usize] != NONE).collect();
    faces.sort_by_key(|&f| (input.chart_of[f as usize], f));
    let charts: Vec<&[u32]> =
        faces.chunk_by(|&a, &b| input.chart_of[a as usize] == input.chart_of[b as usize]).collect();
    let energies: Vec<Dirichlet> = charts
        .par_iter()
        .map(|chart| {
            let map = |&f: &u32| {
                let corners = input.surface.corners(f as usize).map(|p| transform * p);
                FaceMap::new(corners, input.uvs[f as usize])
            };
            let maps: Vec<FaceMap> = chart.iter().filter_map(map).collect();
            Dirichlet::of(maps.iter())
        })
        .collect();
    Dirichlet::each(energies.into_iter())
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::fixtures;
    use super::*;

    #[test]
    fn a_square_stretched_to_twice_its_length_has_the_energy_of_that() {
        let corners = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
        let corners = corners.map(DVec3::from_array).to_vec();
        let surface = fixtures::surface(corners, vec![[0, 1, 2], [0, 2, 3]]);
        let uvs = [[[0.0, 0.0], [0.5, 0.0], [0.5, 0.5]], [[0.0, 0.0], [0.5, 0.5], [0.0, 0.5]]];
        let by = |chart: u32, x: f64| {
            let chart_of = [chart; 2];
            let input = fixtures::measured(&surface, &uvs, &chart_of, &[0, 0]);
            transformed_dirichlet(&input, &[0, 1], DMat3::from_diagonal(DVec3::new(x, 1.0, 1.0)))
        };
        assert!((by(0, 1.0).unwrap() - 1.0).abs() < 1e-12);
        // ½ √((¼ + 1)(4 + 1))
        assert!((by(0, 2.0).unwrap() - 1.25).abs() < 1e-12);
        assert_eq!(by(NONE, 1.0), None);
    }
}
