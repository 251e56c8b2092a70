//! One training example: points on an object, what part each is of, what that part is called.

use glam::DVec3;

use crate::contract::{Canceled, Run};
use crate::mesh::Surface;
use crate::mesh::rays::Rays;
use crate::sampling::{self, PointCloud, SampleCounts, farthest_points};
use crate::segmentation::point_mae::NetworkCloud;
use crate::segmentation::thickness::thickness;

/// Points of an example: twice what the network sees, so that each step draws others.
pub const POINTS: usize = 4096;

/// Points of an object with their parts.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Example {
    /// Its name.
    pub id: String,
    /// Objects of one family never stand on both sides of a split.
    pub family: String,
    /// Its category.
    pub category: String,
    /// The points. The first half are spread evenly, farthest first; the others lie as sampled.
    pub cloud: NetworkCloud,
    /// Part of each point, −1 unknown.
    pub part: Vec<i32>,
    /// Index into `NAMES` of each point, −1 unknown.
    pub name: Vec<i32>,
}

/// What is known of a surface's faces.
pub struct Labels<'a> {
    /// Part of each face, −1 unknown.
    pub parts: &'a [i32],
    /// Index into the network's names of each face, −1 unknown.
    pub names: &'a [i32],
}

impl Example {
    /// Sample a labelled surface.
    pub fn of_surface(
        surface: &Surface,
        labels: &Labels,
        seed: u64,
        run: &Run,
    ) -> Result<Self, Canceled> {
        let counts = SampleCounts { base: 3 * POINTS, extra: 0.1 };
        let cloud = sampling::sample(surface, counts, seed, run)?;
        let rays = Rays::new(surface);
        let through =
            |cloud: &PointCloud| thickness(surface, &rays, &cloud.positions, &cloud.faces);
        Self::of_cloud(&cloud, labels, through, run)
    }

    /// Draw the points of a dense cloud, farthest first.
    pub fn of_cloud(
        cloud: &PointCloud,
        labels: &Labels,
        through: impl Fn(&PointCloud) -> Vec<f32>,
        run: &Run,
    ) -> Result<Self, Canceled> {
        // The first half farthest first, from four times as many; the rest as the sampling had it.
        let few = POINTS / 2;
        let thin: Vec<u32> = (0..cloud.len().min(4 * few))
            .map(|i| (i * cloud.len() / cloud.len().min(4 * few)) as u32)
            .collect();
        let thin = cloud.subset(&thin);
        let mut order = farthest_points(&thin, few, run)?;
        let mut taken = vec![false; thin.len()];
        order.iter().for_each(|&i| taken[i as usize] = true);
        let others = (0..thin.len() as u32).filter(|&i| !taken[i as usize]);
        // Spread over the faces' order.
        let others: Vec<u32> = others.collect();
        let more = (POINTS - few).min(others.len());
        order.extend((0..more).map(|i| others[i * others.len() / more]));
        let cloud = thin.subset(&order);
        let narrow = |p: &DVec3| p.as_vec3().to_array();
        let of = |labels: &[i32]| cloud.faces.iter().map(|&f| labels[f as usize]).collect();
        let (part, name): (Vec<i32>, Vec<i32>) = (of(labels.parts), of(labels.names));
        let mut network = NetworkCloud {
            positions: cloud.positions.iter().map(narrow).collect(),
            normals: cloud.normals.iter().map(narrow).collect(),
            thickness: through(&cloud),
        };
        network.normalise();
        Ok(Self { cloud: network, part, name, ..Default::default() })
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.part.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.part.is_empty()
    }
}
