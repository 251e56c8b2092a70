//! Boundary features (paper 2.2.1, Eq. 5 and 6): ρ, the share of a point's neighbours with another
//! label, and I, whether ρ exceeds 0.3. The paper's radius of 0.02 finds about one neighbour at 2,048
//! points on an object of unit size; here the radius is the larger of that and the distance within
//! which a point typically has 16 neighbours.

use std::num::NonZero;

use glam::DVec3;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;

use crate::sampling::PointCloud;
use crate::tasks;

/// The paper's radius, in units of the object's size.
const RADIUS: f64 = 0.02;

/// Neighbours that a radius should find.
const NEIGHBOURS: NonZero<usize> = NonZero::new(16).unwrap();

/// τ: a point with a larger ρ is a boundary point.
const THRESHOLD: f64 = 0.3;

/// A labelled cloud that answers for any position.
pub struct BoundaryFeatures {
    tree: Option<ImmutableKdTree<f64, 3>>,
    labels: Vec<u32>,
    radius: f64,
}

impl BoundaryFeatures {
    /// From a cloud and the part of each of its points.
    pub fn new(cloud: &PointCloud, labels: &[u32]) -> Self {
        let points: Vec<[f64; 3]> = cloud.positions.iter().map(|p| p.to_array()).collect();
        let (low, high) = cloud
            .positions
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)));
        let size = if points.is_empty() { 0.0 } else { (high - low).max_element() };
        let tree = ImmutableKdTree::new_from_slice(&points).ok();
        let mut features = Self { tree, labels: labels.to_vec(), radius: RADIUS * size };
        // The median distance to the 16th neighbour, over a fixed sample of the points.
        let stride = (points.len() / 256).max(1);
        let mut distances: Vec<f64> =
            points.iter().step_by(stride).filter_map(|p| features.reach(p)).collect();
        distances.sort_by(f64::total_cmp);
        if let Some(&median) = distances.get(distances.len() / 2) {
            features.radius = features.radius.max(median);
        }
        features
    }

    /// Radius of a neighbourhood, world units.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// ρ and I at each position. The label of a position is that of the nearest point.
    pub fn at(&self, positions: &[DVec3]) -> (Vec<f64>, Vec<f64>) {
        let rho: Vec<f64> = tasks::even("boundary", positions.len(), || {
            positions.par_iter().map(|p| self.rho(&p.to_array())).collect()
        });
        let boundary = rho.iter().map(|&r| if r > THRESHOLD { 1.0 } else { 0.0 }).collect();
        (rho, boundary)
    }

    fn rho(&self, p: &[f64; 3]) -> f64 {
        let Some(tree) = &self.tree else { return 0.0 };
        let nearest = tree.query(p).nearest_one::<SquaredEuclidean<f64>>().execute().item;
        let own = self.labels[nearest as usize];
        let within = self.radius * self.radius;
        let found = tree.query(p).within::<SquaredEuclidean<f64>>(within).unsorted().execute();
        let others = found.iter().filter(|n| self.labels[n.item as usize] != own).count();
        others as f64 / found.len().max(1) as f64
    }

    /// Distance to the 16th neighbour.
    fn reach(&self, p: &[f64; 3]) -> Option<f64> {
        // A point of the cloud finds itself too.
        let most = NEIGHBOURS.saturating_add(1);
        let found = self.tree.as_ref()?.query(p).nearest_n::<SquaredEuclidean<f64>>(most).execute();
        found.iter().map(|n| n.distance.sqrt()).max_by(f64::total_cmp)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two half planes of points, labelled 0 and 1 at x = 0.
    fn halves() -> BoundaryFeatures {
        let mut cloud = PointCloud::default();
        for i in 0..40 {
            for j in 0..40 {
                cloud.positions.push(DVec3::new(i as f64 / 20.0 - 0.975, j as f64 / 20.0, 0.0));
            }
        }
        let labels: Vec<u32> = cloud.positions.iter().map(|p| u32::from(p.x > 0.0)).collect();
        BoundaryFeatures::new(&cloud, &labels)
    }

    #[test]
    fn the_radius_finds_neighbours() {
        let features = halves();
        assert!(features.radius() >= 0.02 * 1.95 && features.radius() < 0.2);
    }

    #[test]
    fn points_at_a_border_are_boundary_points() {
        let features = halves();
        let at = [DVec3::new(0.02, 1.0, 0.0), DVec3::new(0.8, 1.0, 0.0)];
        let (rho, boundary) = features.at(&at);
        assert!(rho[0] > THRESHOLD && rho[0] < 0.6, "{rho:?}");
        assert_eq!((rho[1], boundary), (0.0, vec![1.0, 0.0]));
    }
}
