//! The instances of meshes: a scene may show a mesh at several nodes, and its triangles are read, cut and
//! measured once, where the largest of them stands.

use glam::{DMat3, DMat4};

use super::Scene;

/// A mesh at a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instance {
    /// Index of the mesh.
    pub mesh: u32,
    /// Index of the node.
    pub node: u32,
    /// Transform into the world.
    pub world: DMat4,
}

/// An instance besides the measured one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Other {
    /// Index of the mesh.
    pub mesh: u32,
    /// Index of the node.
    pub node: u32,
    /// From where the mesh was measured to where this instance stands.
    pub transform: DMat4,
}

/// Deviation from a similarity, relative to the scale squared, that is no more than rounding.
const UNEVEN: f64 = 1e-5;

impl Other {
    /// Whether the instance has another shape than the measured one: it is scaled unevenly against it.
    pub fn is_uneven(&self) -> bool {
        let m = DMat3::from_mat4(self.transform);
        let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
        let most = x.length_squared().max(y.length_squared()).max(z.length_squared());
        let squares = [x.length_squared(), y.length_squared(), z.length_squared()];
        let angles = [x.dot(y), y.dot(z), z.dot(x)];
        squares.iter().any(|s| most - s > UNEVEN * most)
            || angles.iter().any(|a| a.abs() > UNEVEN * most)
    }
}

impl Scene {
    /// All instances but, of each mesh, the one in whose place it is measured.
    pub fn other_instances(&self) -> Vec<Other> {
        let mut measured = vec![None; self.meshes.len()];
        for primitive in self.primitives.iter().rev() {
            measured[primitive.mesh as usize] = primitive.world;
        }
        let mut passed = vec![false; self.meshes.len()];
        let mut others = Vec::new();
        for &Instance { mesh, node, world } in &self.instances {
            let Some(place) = measured[mesh as usize] else { continue };
            if place == world && !std::mem::replace(&mut passed[mesh as usize], true) {
                continue;
            }
            // What was flattened to nothing cannot be placed elsewhere.
            let transform = world * place.inverse();
            if transform.is_finite() {
                others.push(Other { mesh, node, transform });
            }
        }
        others
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::mesh::Primitive;

    #[test]
    fn one_instance_of_each_mesh_is_the_measured_one() {
        let large = DMat4::from_scale(DVec3::splat(2.0));
        let moved = DMat4::from_translation(DVec3::X);
        let stretched = DMat4::from_scale(DVec3::new(1.0, 3.0, 1.0));
        let mut scene = Scene::from_triangles(vec![DVec3::ZERO; 3], vec![[0, 1, 2]]);
        scene.primitives[0] = Primitive { world: Some(large), ..scene.primitives[0].clone() };
        let places = [moved, large, stretched, large];
        let instance = |(node, world)| Instance { mesh: 0, node, world };
        scene.instances = (0..).zip(places).map(instance).collect();
        let others = scene.other_instances();
        assert_eq!(others.iter().map(|o| o.node).collect::<Vec<_>>(), [0, 2, 3]);
        let there = |o: &Other| o.transform.transform_point3(DVec3::new(2.0, 2.0, 0.0));
        assert_eq!(there(&others[0]), DVec3::new(2.0, 1.0, 0.0));
        assert_eq!(others.iter().map(Other::is_uneven).collect::<Vec<_>>(), [false, true, false]);
        assert!(Scene::default().other_instances().is_empty());
    }

    #[test]
    fn turned_and_mirrored_is_even_and_sheared_is_not() {
        let other = |transform| Other { mesh: 0, node: 0, transform };
        let turned = DMat4::from_rotation_x(0.7) * DMat4::from_scale(DVec3::new(-3.0, 3.0, 3.0));
        assert!(!other(turned).is_uneven());
        let mut sheared = DMat4::IDENTITY;
        sheared.x_axis.y = 0.1;
        assert!(other(sheared).is_uneven());
    }
}
