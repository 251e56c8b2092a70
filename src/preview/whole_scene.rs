//! The object with every instance of its meshes where the scene shows it: what the pictures are drawn of.
//! All figures are of the meshes alone.

use std::collections::HashMap;

use glam::{DMat3, DMat4, DVec3};

use crate::mesh::{NONE, Surface};
use crate::metrics::Measured;

/// Triangles that a picture has at most; instances beyond are left out.
const MOST_FACES: usize = 400_000;

/// An object with its instances.
pub struct WholeScene {
    surface: Surface,
    uvs: Vec<[[f32; 2]; 3]>,
    chart_of: Vec<u32>,
    part_of: Vec<u32>,
}

/// Faces of a picture of an object of `own` faces with instances of so many more.
pub fn drawn_faces(own: usize, instances: usize) -> usize {
    (own + instances).min(MOST_FACES.max(own))
}

impl WholeScene {
    /// The object in `input`, and faces and a transform for each instance besides.
    pub fn new<'f>(input: &Measured, instances: impl Iterator<Item = (&'f [u32], DMat4)>) -> Self {
        let mut scene = Self {
            surface: input.surface.clone(),
            uvs: input.uvs.to_vec(),
            chart_of: input.chart_of.to_vec(),
            part_of: input.part_of.to_vec(),
        };
        for (faces, transform) in instances {
            if scene.uvs.len() + faces.len() <= MOST_FACES {
                scene.add(input, faces, transform);
            }
        }
        let (low, high) = scene
            .surface
            .positions
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
                (low.min(*p), high.max(*p))
            });
        // What the picture is framed by.
        scene.surface.diagonal = low.distance(high);
        scene
    }

    /// The view that the pictures are taken of.
    pub fn measured<'a>(&'a self, input: &Measured<'a>) -> Measured<'a> {
        Measured {
            surface: &self.surface,
            uvs: &self.uvs,
            chart_of: &self.chart_of,
            part_of: &self.part_of,
            boundary_labels: None,
            ..*input
        }
    }

    fn add(&mut self, input: &Measured, faces: &[u32], transform: DMat4) {
        let (from, to) = (input.surface, &mut self.surface);
        // Normals turn as the inverse transpose does, up to its sign.
        let linear = DMat3::from_mat4(transform);
        let turn = linear.inverse().transpose() * linear.determinant().signum();
        let first = to.triangles.len() as u32;
        let face_of: HashMap<u32, u32> = faces.iter().copied().zip(first..).collect();
        let mut vertex_of = HashMap::new();
        for &f in faces {
            let f = f as usize;
            to.triangles.push(from.triangles[f].map(|v| {
                *vertex_of.entry(v).or_insert_with(|| {
                    to.positions.push(transform.transform_point3(from.positions[v as usize]));
                    to.positions.len() as u32 - 1
                })
            }));
            to.normals.push((turn * from.normals[f]).normalize_or_zero());
            to.areas.push(from.areas[f]);
            to.origins.push(from.origins[f]);
            to.sheet_mate.push(NONE);
            for &twin in &from.twin[3 * f..3 * f + 3] {
                // Twins of another mesh stay where they are.
                let there = if twin == NONE { None } else { face_of.get(&(twin / 3)) };
                to.twin.push(there.map_or(NONE, |g| 3 * g + twin % 3));
            }
            self.uvs.push(input.uvs[f]);
            self.chart_of.push(input.chart_of[f]);
            self.part_of.push(input.part_of[f]);
        }
        to.existing_seams = Vec::new();
        to.labels = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::fixtures;

    #[test]
    fn an_instance_is_placed_with_all_that_its_faces_have() {
        let corners = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
        let corners = corners.map(DVec3::from_array).to_vec();
        let surface = fixtures::surface(corners, vec![[0, 1, 2], [0, 2, 3]]);
        let uvs = [[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]];
        let input = fixtures::measured(&surface, &uvs, &[0, 0], &[0, 1]);
        let there =
            DMat4::from_translation(DVec3::Z * 5.0) * DMat4::from_scale(DVec3::new(2.0, 1.0, -1.0));
        let scene = WholeScene::new(&input, [(&[0u32, 1][..], there)].into_iter());
        let seen = scene.measured(&input);
        let s = seen.surface;
        assert_eq!((s.face_count(), seen.part_of, seen.charts), (4, &[0, 1, 0, 1][..], 1));
        assert_eq!(s.corners(2), [[0., 0., 5.], [2., 0., 5.], [2., 1., 5.]].map(DVec3::from_array));
        assert_eq!(s.twin[3 * 2 + 2], 3 * 3, "the two halves still meet, in the other place");
        assert_eq!(s.twin[2], 3);
        assert!(s.normals[2].distance(s.normals[0] * s.normals[0].dot(s.normals[2])) < 1e-12);
        assert!(s.diagonal > 5.0);
        assert_eq!(seen.uvs[3], input.uvs[1]);
    }

    #[test]
    fn what_is_too_much_for_a_picture_is_left_out() {
        let surface = Surface { triangles: vec![[0; 3]; 2], ..Surface::default() };
        let many = vec![0; MOST_FACES];
        let input = fixtures::measured(&surface, &[[[0.0; 2]; 3]; 2], &[NONE; 2], &[NONE; 2]);
        let scene = WholeScene::new(&input, [(&many[..], DMat4::IDENTITY)].into_iter());
        assert_eq!(scene.measured(&input).surface.face_count(), 2);
        assert_eq!(drawn_faces(2, 5), 7);
        assert_eq!(drawn_faces(2, MOST_FACES), MOST_FACES);
        assert_eq!(drawn_faces(2 * MOST_FACES, 5), 2 * MOST_FACES);
    }
}
