//! The dense cloud (paper 2.1.2): base points spread over each face in proportion to its area, then
//! extra blue-noise points on the faces at salient edges.

use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{EdgeField, base, blue_noise};
use crate::contract::{Canceled, Run};
use crate::mesh::Surface;
use crate::tasks;

/// Most points of a dense cloud. A surface with more usable faces has faces without a point.
pub const DENSE_CAP: usize = 200_000;

/// Points on a surface. All four lists have the same length.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PointCloud {
    /// Positions, world units.
    pub positions: Vec<DVec3>,
    /// Unit normals of the points' faces.
    pub normals: Vec<DVec3>,
    /// The face that each point lies on.
    pub faces: Vec<u32>,
    /// Edge sensitivity, 0 (far from any salient edge) to 1 (on a sharp one).
    pub sensitivity: Vec<f32>,
}

impl PointCloud {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// The points of these indices, in this order.
    pub fn subset(&self, indices: &[u32]) -> Self {
        fn pick<T: Copy>(from: &[T], indices: &[u32]) -> Vec<T> {
            indices.iter().map(|&i| from[i as usize]).collect()
        }
        Self {
            positions: pick(&self.positions, indices),
            normals: pick(&self.normals, indices),
            faces: pick(&self.faces, indices),
            sensitivity: pick(&self.sensitivity, indices),
        }
    }

    pub(super) fn push(&mut self, position: DVec3, normal: DVec3, face: u32) {
        self.positions.push(position);
        self.normals.push(normal);
        self.faces.push(face);
    }
}

/// How many points to place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampleCounts {
    /// Base points over the whole surface (N_total of the paper).
    pub base: usize,
    /// Extra points on the faces at salient edges, over the base points.
    pub extra: f64,
}

impl SampleCounts {
    /// The dense cloud of a surface with this many faces: four base points a face, at least 8,192,
    /// so that with the extra points it stays under [`DENSE_CAP`].
    pub fn dense(faces: usize) -> Self {
        let extra = 0.25;
        let most = (DENSE_CAP as f64 / (1.0 + extra)) as usize;
        // Past the point where each face can have one, all of the cloud goes to that.
        if faces > most {
            return Self { base: DENSE_CAP, extra: 0.0 };
        }
        Self { base: (4 * faces).clamp(8192, most.max(8192)), extra }
    }
}

/// Sample a surface. Base points first, in face order, then the extra ones. The same surface,
/// counts and seed give the same cloud.
pub fn sample(
    surface: &Surface,
    counts: SampleCounts,
    seed: u64,
    run: &Run,
) -> Result<PointCloud, Canceled> {
    let field = tasks::link("edge field", || EdgeField::new(surface, run))?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let areas = &surface.areas;
    let shares = base::allocate(areas, counts.base);
    let mut cloud = PointCloud::default();
    for (face, &share) in shares.iter().enumerate() {
        if face % 65536 == 0 {
            run.cancel.check()?;
        }
        for _ in 0..share {
            let point = point_on(surface, face, &mut rng);
            cloud.push(point, surface.normals[face], face as u32);
        }
    }

    let edge_faces: Vec<u32> = (0..surface.face_count() as u32)
        .filter(|&f| field.salient_face[f as usize] && areas[f as usize] > 0.0)
        .collect();
    // In proportion to what the edge faces hold already, so that a cube (all edge faces) and a
    // sphere with one groove are both denser at their edges by the same factor.
    let held: u64 = edge_faces.iter().map(|&f| u64::from(shares[f as usize])).sum();
    let wanted = ((2.0 * held as f64).min(counts.base as f64) * counts.extra) as usize;
    let (extra, _) = tasks::link("blue noise", || {
        blue_noise::scatter(surface, &edge_faces, wanted, &mut rng, run)
    })?;
    cloud.positions.extend(extra.positions);
    cloud.normals.extend(extra.normals);
    cloud.faces.extend(extra.faces);

    let (points, faces) = (&cloud.positions, &cloud.faces);
    let sensitivity = |i: usize| field.at(surface, faces[i] as usize, points[i]) as f32;
    cloud.sensitivity = tasks::fill("sensitivity", points.len(), sensitivity);
    Ok(cloud)
}

/// A uniform point of a face: (u, v) with u + v > 1 is folded back (paper Eq. 4).
pub(super) fn point_on(surface: &Surface, face: usize, rng: &mut ChaCha8Rng) -> DVec3 {
    let (mut u, mut v): (f64, f64) = (rng.random(), rng.random());
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    let [a, b, c] = surface.corners(face);
    u * a + v * b + (1.0 - u - v) * c
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
