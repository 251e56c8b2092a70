//! The instances of the scene's meshes: what is measured of them, and the object with all of them for the
//! pictures.

use std::collections::BTreeMap;

use glam::DMat3;

use super::parts::Found;
use crate::contract::{InstanceMetrics, WorstInstance};
use crate::mesh::Scene;
use crate::metrics::{self, Measured};
use crate::preview::Shown;

/// The faces of a mesh of the scene.
fn faces_of(scene: &Scene, found: &Found, mesh: u32) -> Vec<u32> {
    let of = |f: &u32| {
        let primitive = found.surface.origins[*f as usize].primitive;
        scene.primitives[primitive as usize].mesh == mesh
    };
    (0..found.surface.face_count() as u32).filter(of).collect()
}

/// What the instances of the scene's meshes are, and the worst of them.
pub fn metrics_of(scene: &Scene, found: &Found, measured: &Measured) -> Option<InstanceMetrics> {
    let others = scene.other_instances();
    if others.is_empty() {
        return None;
    }
    let uneven: Vec<_> = others.iter().filter(|other| other.is_uneven()).collect();
    let mut faces: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    let worst = uneven.iter().filter_map(|other| {
        let faces = faces.entry(other.mesh).or_insert_with(|| faces_of(scene, found, other.mesh));
        let transform = DMat3::from_mat4(other.transform);
        let energy = metrics::transformed_dirichlet(measured, faces, transform)?;
        Some(WorstInstance { node: other.node, symmetric_dirichlet: energy })
    });
    // The first of the worst.
    let worst =
        worst.reduce(|a, b| if b.symmetric_dirichlet > a.symmetric_dirichlet { b } else { a });
    Some(InstanceMetrics {
        count: scene.instances.len() as u32,
        uneven: uneven.len() as u32,
        worst,
    })
}

/// The object with all its instances, for the pictures; `None` where each mesh stands once.
pub fn shown(scene: &Scene, found: &Found, measured: &Measured) -> Option<Shown> {
    let others = scene.other_instances();
    let mut faces: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for other in &others {
        faces.entry(other.mesh).or_insert_with(|| faces_of(scene, found, other.mesh));
    }
    let placed = others.iter().map(|other| (&faces[&other.mesh][..], other.transform));
    Shown::new(measured, placed)
}

#[cfg(test)]
mod tests {
    use glam::{DMat4, DVec3};

    use crate::contract::{ArtifactKind, AtlasMetrics, Metrics, Run};
    use crate::mesh::Instance;
    use crate::pipeline::report::whole;
    use crate::pipeline::{Unwrapped, scenes};

    #[test]
    fn an_instance_that_is_stretched_is_measured_and_drawn() {
        let (options, run) = (scenes::options(), Run::quiet());
        let (found, _, atlas) = scenes::atlas(scenes::CUBE, &options, &run);
        let mut scene = scenes::scene(scenes::CUBE);
        let engine = scenes::engine();
        let alone = whole(&scene, &found, &atlas, None, &options, &engine, &run).unwrap();
        assert_eq!(alone.metrics.atlas.instances, None);
        let stretched =
            DMat4::from_translation(DVec3::X * 3.0) * DMat4::from_scale(DVec3::new(1.0, 1.0, 2.0));
        scene.primitives[0].world = Some(DMat4::IDENTITY);
        let instance = |(node, world)| Instance { mesh: 0, node, world };
        scene.instances = [(4, DMat4::IDENTITY), (7, stretched)].map(instance).to_vec();
        let both = whole(&scene, &found, &atlas, None, &options, &engine, &run).unwrap();
        let told = both.metrics.atlas.instances.unwrap();
        assert_eq!((told.count, told.uneven), (2, 1));
        // Two sides keep their shape; of the four others one length is doubled. In a chart of both kinds, with
        // areas 2 and 8 of 10, no scale suits all.
        let worst = told.worst.unwrap();
        assert_eq!(worst.node, 7);
        assert!(worst.symmetric_dirichlet > 1.05, "{worst:?}");
        let other = |r: &Unwrapped| Metrics {
            atlas: AtlasMetrics { instances: None, ..r.metrics.atlas.clone() },
            ..r.metrics.without_cost()
        };
        assert_eq!(other(&alone), other(&both), "every other figure is of the mesh");
        let picture = |r: &Unwrapped| r.artifact(ArtifactKind::Preview).unwrap().to_vec();
        assert_ne!(picture(&alone), picture(&both), "both are drawn");
    }
}
