//! The classical unwrapper (`uvunwrap`: normal-cone segmentation, LSCM and ARAP, split until valid)
//! as the last resort for a chart that nothing else flattens. Its islands come back as disks of
//! their own with maps that are proved injective; what it leaves out, or what single precision has
//! spoilt, comes back as single triangles, which always pass.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};

use glam::{DVec2, DVec3};

use super::disk::flatten_triangle;
use super::injective::certify;
use super::jacobian::rescale;
use super::{Disk, FlattenError, UvMap};

/// One island: a disk with an injective map.
#[derive(Debug, Clone)]
pub struct Island {
    /// Faces of the input, ascending: triangle i of the disk is face `faces[i]`.
    pub faces: Vec<u32>,
    /// The faces as a mesh of their own.
    pub disk: Disk,
    /// Vertex of the input that each vertex of the disk stands for.
    pub vertices: Vec<u32>,
    /// The map, scaled to the 3D area.
    pub uv: UvMap,
}

/// Page on which the islands are laid out; large, since its coordinates are single precision.
const PAGE: u32 = 4096;

/// Unwrap triangles over `positions`. Every face comes back in exactly one island; faces without
/// area come back alone, with a map without area, and so do the faces of an island that is not proved
/// injective, and all where the unwrapper breaks down. Errors when the unwrapper refuses the mesh (indices out of range, positions not finite).
pub fn unwrap_classically(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
) -> Result<Vec<Island>, FlattenError> {
    let islands = match classical_islands(positions, triangles) {
        Err(FlattenError::ClassicalBroke) => {
            let alone = |f| single_triangle(positions, triangles, f);
            return Ok((0..triangles.len() as u32).map(alone).collect());
        }
        islands => islands?,
    };
    let (proved, others): (Vec<Island>, Vec<Island>) = islands.into_iter().partition(|island| {
        island.faces.len() == 1 || certify(&island.disk, &island.uv).is_injective()
    });
    let alone = others.iter().flat_map(|island| &island.faces);
    let mut islands = proved;
    islands.extend(alone.map(|&f| single_triangle(positions, triangles, f)));
    islands.sort_by_key(|island| island.faces[0]);
    Ok(islands)
}

/// The islands as the unwrapper makes them, proved or not; some have holes. Every face comes back in
/// exactly one; a face that the unwrapper left out comes back alone.
pub fn classical_islands(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
) -> Result<Vec<Island>, FlattenError> {
    let (center, size) = frame(positions);
    let single: Vec<[f32; 3]> =
        positions.iter().map(|&p| ((p - center) / size).as_vec3().to_array()).collect();
    let indices = triangles.as_flattened();
    let options = uvunwrap::Options {
        density: uvunwrap::Density::Auto { page_size: PAGE },
        padding: 0,
        packing: uvunwrap::Packing::Fast,
        ..Default::default()
    };
    let input = [uvunwrap::MeshInput::new(&single, indices)];
    let atlas = catch_unwind(AssertUnwindSafe(|| uvunwrap::generate(&input, &options)))
        .map_err(|_| FlattenError::ClassicalBroke)??;
    let page = DVec2::new(f64::from(atlas.width), f64::from(atlas.height));
    let mesh = &atlas.meshes[0];

    let corner = |f: usize, k: usize| &mesh.vertices[mesh.indices[3 * f + k] as usize];
    let mut groups: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    let mut alone = Vec::new();
    for f in 0..triangles.len() {
        // A face that was left out borrows one chart vertex for all its corners.
        let flat = corner(f, 0).uv == corner(f, 1).uv && corner(f, 1).uv == corner(f, 2).uv;
        match corner(f, 0).chart.filter(|_| !flat) {
            Some(chart) => groups.entry(chart).or_default().push(f as u32),
            None => alone.push(f as u32),
        }
    }
    let mut islands = Vec::new();
    for faces in groups.into_values() {
        let at = |f: u32, k: usize| DVec2::from(corner(f as usize, k).uv.map(f64::from)) * page;
        islands.push(glue(positions, triangles, &faces, at));
    }
    islands.extend(alone.into_iter().map(|f| single_triangle(positions, triangles, f)));
    islands.sort_by_key(|island| island.faces[0]);
    Ok(islands)
}

/// Centre and size of the bounding box, so that single precision is used well.
fn frame(positions: &[DVec3]) -> (DVec3, f64) {
    let low = positions.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = positions.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let size = (high - low).max_element();
    let size = if size > 0.0 && size.is_finite() { size } else { 1.0 };
    (if low.is_finite() && high.is_finite() { 0.5 * (low + high) } else { DVec3::ZERO }, size)
}

/// An island of `faces`: corners at one position and one UV are one vertex.
fn glue(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    faces: &[u32],
    at: impl Fn(u32, usize) -> DVec2,
) -> Island {
    let mut known: BTreeMap<[u64; 5], u32> = BTreeMap::new();
    let (mut vertices, mut uv, mut local) = (Vec::new(), Vec::new(), Vec::new());
    for &f in faces {
        local.push([0, 1, 2].map(|k| {
            let (v, p) = (triangles[f as usize][k], at(f, k));
            let q = positions[v as usize];
            let key = [q.x, q.y, q.z, p.x, p.y].map(f64::to_bits);
            *known.entry(key).or_insert_with(|| {
                vertices.push(v);
                uv.push(p);
                vertices.len() as u32 - 1
            })
        }));
    }
    let disk = Disk::new(vertices.iter().map(|&v| positions[v as usize]).collect(), local);
    let uv = rescale(&disk, uv);
    Island { faces: faces.to_vec(), disk, vertices, uv }
}

/// One face, laid flat.
fn single_triangle(positions: &[DVec3], triangles: &[[u32; 3]], face: u32) -> Island {
    let vertices = triangles[face as usize];
    let corners = vertices.map(|v| positions[v as usize]);
    let uv = flatten_triangle(corners[0], corners[1], corners[2]).to_vec();
    let disk = Disk::new(corners.to_vec(), vec![[0, 1, 2]]);
    Island { faces: vec![face], disk, vertices: vertices.to_vec(), uv }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::{quality, samples};

    fn check(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<Island> {
        let islands = unwrap_classically(positions, triangles).unwrap();
        let mut seen: Vec<u32> = islands.iter().flat_map(|i| i.faces.clone()).collect();
        seen.sort_unstable();
        assert_eq!(seen, (0..triangles.len() as u32).collect::<Vec<_>>());
        for island in &islands {
            for (t, &f) in island.disk.triangles.iter().zip(&island.faces) {
                let names = t.map(|v| positions[island.vertices[v as usize] as usize]);
                assert_eq!(names, triangles[f as usize].map(|v| positions[v as usize]));
            }
            if island.disk.area() > 0.0 {
                assert!(certify(&island.disk, &island.uv).is_injective());
                assert!(quality(&island.disk, &island.uv).mean < 1.5);
            }
        }
        islands
    }

    #[test]
    fn a_sphere_comes_back_as_valid_islands() {
        let disk = samples::bent(24, 12, |x, y| {
            let (a, b) = (std::f64::consts::TAU * x, std::f64::consts::PI * (0.02 + 0.96 * y));
            DVec3::new(a.cos() * b.sin(), a.sin() * b.sin(), b.cos()) * 40.0 + DVec3::splat(7.0)
        });
        let islands = check(&disk.positions, &disk.triangles);
        assert!(islands.len() > 1 && islands.len() < 60, "{}", islands.len());
    }

    #[test]
    fn faces_without_area_and_slivers_come_back_alone() {
        let (disk, _) = samples::plane(4, 4, 1.0, 1.0);
        let mut positions = disk.positions.clone();
        positions.extend([DVec3::new(0.5, 0.0, 1.0), DVec3::new(0.5, 1e-9, 1.5)]);
        let mut triangles = disk.triangles.clone();
        triangles.push([0, 1, 1]);
        triangles.push([0, 25, 26]);
        let islands = check(&positions, &triangles);
        assert_eq!(islands.iter().filter(|i| i.faces.len() == 1).count(), 2);
    }

    #[test]
    fn what_cannot_be_read_is_an_error() {
        assert!(unwrap_classically(&[DVec3::NAN; 3], &[[0, 1, 2]]).is_err());
        assert!(unwrap_classically(&[DVec3::ZERO; 3], &[[0, 1, 7]]).is_err());
        assert_eq!(unwrap_classically(&[], &[]).unwrap().len(), 0);
    }
}
