//! The object with every instance of its meshes where the scene shows it: what the pictures are drawn of.
//! All figures are of the meshes alone.

use glam::{DMat3, DMat4};

use crate::mesh::{NONE, Surface};
use crate::metrics::Measured;

/// Triangles that a picture has at most; instances beyond are left out.
const MOST_FACES: usize = 400_000;

/// An object with its instances.
pub struct Shown {
    surface: Surface,
    uvs: Vec<[[f32; 2]; 3]>,
    chart_of: Vec<u32>,
    part_of: Vec<u32>,
}

impl Shown {
    /// Faces and a transform for each instance besides those that stand in `input` already. `None` where there
    /// are no others.
    pub fn new<'f>(
        input: &Measured,
        instances: impl Iterator<Item = (&'f [u32], DMat4)>,
    ) -> Option<Self> {
        let mut shown = Self {
            surface: input.surface.clone(),
            uvs: input.uvs.to_vec(),
            chart_of: input.chart_of.to_vec(),
            part_of: input.part_of.to_vec(),
        };
        let before = shown.uvs.len();
        for (faces, transform) in instances {
            if shown.uvs.len() + faces.len() <= MOST_FACES {
                shown.add(input, faces, transform);
            }
        }
        if shown.uvs.len() == before {
            return None;
        }
        let (low, high) = shown
            .surface
            .positions
            .iter()
            .fold((glam::DVec3::INFINITY, glam::DVec3::NEG_INFINITY), |(low, high), p| {
                (low.min(*p), high.max(*p))
            });
        shown.surface.diagonal = low.distance(high);
        Some(shown)
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
        let mut vertex_of = std::collections::HashMap::new();
        let mut face_of = std::collections::HashMap::new();
        for (new, &f) in (first..).zip(faces) {
            face_of.insert(f, new);
            let corners = from.triangles[f as usize].map(|v| {
                *vertex_of.entry(v).or_insert_with(|| {
                    let p = transform.transform_point3(from.positions[v as usize]);
                    to.positions.push(p);
                    to.positions.len() as u32 - 1
                })
            });
            to.triangles.push(corners);
        }
        for &f in faces {
            let f = f as usize;
            to.usable.push(from.usable[f]);
            to.normals.push((turn * from.normals[f]).normalize_or_zero());
            to.areas.push(from.areas[f]);
            to.reversed.push(from.reversed[f]);
            to.origins.push(from.origins[f]);
            to.sheet_mate.push(NONE);
            for k in 0..3 {
                let twin = from.twin[3 * f + k];
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
    use glam::DVec3;

    use super::*;
    use crate::contract::Run;
    use crate::mesh::{Scene, condition};

    #[test]
    fn an_instance_is_placed_with_all_that_its_faces_have() {
        let corners = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
        let corners = corners.map(DVec3::from_array).to_vec();
        let scene = Scene::from_triangles(corners, vec![[0, 1, 2], [0, 2, 3]]);
        let surface = condition(&scene, &Run::quiet()).unwrap();
        let input = Measured {
            surface: &surface,
            uvs: &[[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]],
            chart_of: &[0, 0],
            part_of: &[0, 1],
            charts: 1,
            parts: 2,
            boundary_labels: None,
            page_size: 64,
            pages: 1,
            page_of: &[],
            chamfer: &[],
        };
        assert!(Shown::new(&input, std::iter::empty()).is_none());
        let there =
            DMat4::from_translation(DVec3::Z * 5.0) * DMat4::from_scale(DVec3::new(2.0, 1.0, -1.0));
        let shown = Shown::new(&input, [(&[0u32, 1][..], there)].into_iter()).unwrap();
        let seen = shown.measured(&input);
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
        let input = Measured {
            surface: &surface,
            uvs: &[[[0.0; 2]; 3]; 2],
            chart_of: &[NONE; 2],
            part_of: &[NONE; 2],
            charts: 0,
            parts: 0,
            boundary_labels: None,
            page_size: 64,
            pages: 1,
            page_of: &[],
            chamfer: &[],
        };
        assert!(Shown::new(&input, [(&many[..], DMat4::IDENTITY)].into_iter()).is_none());
    }
}
