//! Extra points on the faces at salient edges, no two of them close together: Poisson-disk samples
//! by dart throwing on the surface (Cook, "Stochastic sampling in computer graphics", 1986,
//! doi:10.1145/7529.8927; after Bridson, "Fast Poisson disk sampling in arbitrary dimensions",
//! 2007, doi:10.1145/1278780.1278807, conflicts are looked up in a grid).

use glam::DVec3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::cloud::{PointCloud, point_on};
use crate::contract::{Canceled, Run};
use crate::mesh::Surface;

/// Throws for each wanted point. With the radius below about nine in ten points find a place.
const THROWS: usize = 6;
/// Points on surfaces that face away from each other (a thin board, two sheets) do not conflict.
const OPPOSITE: f64 = -0.5;

/// The radius at which `wanted` points fill `area` to three quarters of what random packing of
/// disks allows (0.547 covered by disks of half the radius).
pub(super) fn radius(area: f64, wanted: usize) -> f64 {
    (0.75 * 0.547 * 4.0 * area / (std::f64::consts::PI * wanted.max(1) as f64)).sqrt()
}

/// Throw points on the given faces until `wanted` have landed or every throw is spent. Returns the
/// points added and the least distance between them.
pub(super) fn scatter(
    surface: &Surface,
    faces: &[u32],
    wanted: usize,
    rng: &mut ChaCha8Rng,
    run: &Run,
) -> Result<(PointCloud, f64), Canceled> {
    let mut cloud = PointCloud::default();
    let mut sums = Vec::with_capacity(faces.len());
    let mut area = 0.0;
    for &f in faces {
        area += surface.areas[f as usize];
        sums.push(area);
    }
    let radius = radius(area, wanted);
    if wanted == 0 || area <= 0.0 {
        return Ok((cloud, radius));
    }
    let mut grid = Grid::new(wanted, radius);
    for throw in 0..THROWS * wanted {
        if throw % 4096 == 0 {
            run.cancel.check()?;
        }
        if cloud.positions.len() == wanted {
            break;
        }
        let pick = rng.random::<f64>() * area;
        let place = sums.partition_point(|&s| s <= pick).min(faces.len() - 1);
        let face = faces[place];
        let point = point_on(surface, face as usize, rng);
        let normal = surface.normals[face as usize];
        let conflict = grid.near(point).any(|i| {
            cloud.positions[i].distance_squared(point) < radius * radius
                && cloud.normals[i].dot(normal) > OPPOSITE
        });
        if !conflict {
            grid.insert(point, cloud.positions.len() as u32);
            cloud.push(point, normal, face);
        }
    }
    Ok((cloud, radius))
}

/// Buckets of points by hashed cell; a cell is two radii wide, so a disk meets at most eight.
/// Two cells may share a bucket: the distance tells.
struct Grid {
    radius: f64,
    mask: u64,
    head: Vec<u32>,
    next: Vec<u32>,
}

const END: u32 = u32::MAX;

impl Grid {
    fn new(points: usize, radius: f64) -> Self {
        let size = (2 * points).next_power_of_two();
        Self { radius, mask: size as u64 - 1, head: vec![END; size], next: vec![] }
    }

    fn bucket(&self, cell: [i64; 3]) -> usize {
        const ODD: [u64; 3] = [0x9E37_79B9_7F4A_7C15, 0xC2B2_AE3D_27D4_EB4F, 0x1656_67B1_9E37_79F9];
        let mixed =
            (0..3).fold(0u64, |h, a| (h ^ cell[a] as u64).wrapping_mul(ODD[a]).rotate_left(29));
        ((mixed ^ (mixed >> 31)) & self.mask) as usize
    }

    fn cell(&self, p: DVec3) -> [i64; 3] {
        (p / (2.0 * self.radius)).to_array().map(|x| x.floor() as i64)
    }

    fn insert(&mut self, p: DVec3, index: u32) {
        let bucket = self.bucket(self.cell(p));
        self.next.push(self.head[bucket]);
        self.head[bucket] = index;
    }

    fn near(&self, p: DVec3) -> impl Iterator<Item = usize> {
        let (low, high) = (self.cell(p - self.radius), self.cell(p + self.radius));
        let cells = (low[0]..=high[0]).flat_map(move |x| {
            (low[1]..=high[1]).flat_map(move |y| (low[2]..=high[2]).map(move |z| [x, y, z]))
        });
        cells.flat_map(move |cell| {
            let mut at = self.head[self.bucket(cell)];
            std::iter::from_fn(move || {
                let found = (at != END).then_some(at as usize)?;
                at = self.next[found];
                Some(found)
            })
        })
    }
}
