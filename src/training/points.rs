//! Examples from data sets that have points and no surface: normals are estimated, a label that stands at
//! several places is several parts, thickness is unknown.

use std::num::NonZeroUsize;
use std::path::Path;

use glam::{DMat3, DVec3};
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;

use super::example::{Example, Labels};
use super::folder::{FolderError, error};
use crate::contract::Run;
use crate::mesh::{DisjointSets, least_eigenvector};
use crate::sampling::PointCloud;

/// Neighbours that a plane is fitted to.
const PLANE: usize = 12;

/// Points of one label belong together within this multiple of the distance to the fourth neighbour.
const GAP: f64 = 2.5;

/// Labelled points.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LabelledPoints {
    /// Positions.
    pub positions: Vec<DVec3>,
    /// Unit normals, or none.
    pub normals: Vec<DVec3>,
    /// Part of each point, −1 unknown.
    pub parts: Vec<i32>,
    /// Index into the network's names of each point, −1 unknown.
    pub names: Vec<i32>,
}

impl LabelledPoints {
    /// The example of these points; `path` is named if they are none.
    pub fn example(mut self, path: &Path, run: &Run) -> Result<Example, FolderError> {
        if self.positions.is_empty() {
            return Err(error(path, "has no points"));
        }
        if let Some(i) = self.positions.iter().position(|p| !p.is_finite()) {
            return Err(error(path, format!("point {i} is not finite")));
        }
        if self.normals.is_empty() {
            self.normals = normals(&self.positions);
        }
        let count = self.positions.len();
        // Each point is a face of its own, so that labels are found by point.
        let cloud = PointCloud {
            positions: self.positions,
            normals: self.normals,
            faces: (0..count as u32).collect(),
            sensitivity: vec![0.0; count],
        };
        let labels = Labels { parts: &self.parts, names: &self.names };
        let through = |cloud: &PointCloud| vec![0.0; cloud.len()];
        Example::of_cloud(&cloud, &labels, through, run).map_err(|e| error(path, e))
    }

    /// Divide labels that tell only the kind of a part into their connected components.
    pub fn divided(mut self) -> Self {
        self.parts = pieces(&self.positions, &self.parts);
        self
    }
}

/// The nearest neighbours of each point, itself first.
fn neighbours(at: &[[f64; 3]], count: usize) -> Vec<Vec<(u32, f64)>> {
    let count = NonZeroUsize::new(count.min(at.len())).unwrap_or(NonZeroUsize::MIN);
    let Ok(tree) = ImmutableKdTree::<f64, 3>::new_from_slice(at) else { return Vec::new() };
    let near = |p: &[f64; 3]| {
        let found = tree.query(p).nearest_n::<SquaredEuclidean<f64>>(count).execute();
        found.iter().map(|hit| (hit.item, hit.distance.sqrt())).collect()
    };
    at.par_iter().map(near).collect()
}

/// Normals of the planes through each point's neighbours, away from the middle of the cloud.
fn normals(positions: &[DVec3]) -> Vec<DVec3> {
    let at: Vec<[f64; 3]> = positions.iter().map(|p| p.to_array()).collect();
    let middle = positions.iter().sum::<DVec3>() / positions.len().max(1) as f64;
    let normal = |near: &Vec<(u32, f64)>| {
        let of = || near.iter().map(|&(i, _)| positions[i as usize]);
        let mean = of().sum::<DVec3>() / near.len().max(1) as f64;
        let spread = of()
            .map(|p| p - mean)
            .fold(DMat3::ZERO, |m, d| m + DMat3::from_cols(d * d.x, d * d.y, d * d.z));
        let n = least_eigenvector(spread);
        if n.dot(mean - middle) < 0.0 { -n } else { n }
    };
    neighbours(&at, PLANE).par_iter().map(normal).collect()
}

/// Connected components of each label, numbered in order of first point; −1 stays.
fn pieces(positions: &[DVec3], labels: &[i32]) -> Vec<i32> {
    let at: Vec<[f64; 3]> = positions.iter().map(|p| p.to_array()).collect();
    let near = neighbours(&at, 16);
    let mut sets = DisjointSets::new(positions.len());
    for (i, near) in (0u32..).zip(&near) {
        let reach = GAP * near.get(4).or(near.last()).map_or(0.0, |n| n.1);
        for &(j, distance) in near {
            if distance <= reach && labels[i as usize] == labels[j as usize] {
                sets.join(i, j);
            }
        }
    }
    let mut numbers = std::collections::HashMap::new();
    (0u32..)
        .zip(labels)
        .map(|(i, &label)| {
            let next = numbers.len() as i32;
            if label < 0 { -1 } else { *numbers.entry(sets.root(i)).or_insert(next) }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lattice of points on the square [0, 1]² × {z}.
    fn sheet(z: f64, shift: f64) -> impl Iterator<Item = DVec3> {
        (0..400)
            .map(move |i| DVec3::new(f64::from(i % 20) / 20.0 + shift, f64::from(i / 20) / 20.0, z))
    }

    #[test]
    fn normals_stand_on_sheets_and_point_outwards() {
        let positions: Vec<DVec3> = sheet(0.0, 0.0).chain(sheet(1.0, 0.0)).collect();
        for (p, n) in positions.iter().zip(normals(&positions)) {
            let out = if p.z > 0.5 { DVec3::Z } else { -DVec3::Z };
            assert!(n.distance(out) < 1e-9, "{p} {n}");
        }
    }

    #[test]
    fn a_label_at_two_places_is_two_parts() {
        let positions: Vec<DVec3> = sheet(0.0, 0.0).chain(sheet(0.0, 3.0)).collect();
        let mut labels = vec![5; 800];
        labels[7] = -1;
        let parts = pieces(&positions, &labels);
        assert_eq!((parts[0], parts[7], parts[399], parts[400], parts[799]), (0, -1, 0, 1, 1));
    }
}
