//! The instances of the scene's meshes: what is measured of them, and the object with all of them for the
//! pictures.

use std::collections::{BTreeMap, BTreeSet};

use glam::DMat3;

use super::parts::Found;
use crate::contract::{Canceled, InstanceMetrics, Run, WorstInstance};
use crate::mesh::{Other, Scene};
use crate::metrics::{self, Measured};
use crate::preview::{self, WholeScene};

/// The instances of a scene that shows meshes several times.
pub struct Instances {
    /// All instances.
    count: u32,
    /// Those that stand elsewhere than where their mesh was measured.
    others: Vec<Other>,
    /// The faces of each mesh.
    faces: BTreeMap<u32, Vec<u32>>,
}

impl Instances {
    /// `None` where each mesh stands once.
    pub fn of(scene: &Scene, found: &Found) -> Option<Self> {
        let others = scene.other_instances();
        if others.is_empty() {
            return None;
        }
        let mut faces: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (f, origin) in (0u32..).zip(&found.surface.origins) {
            faces.entry(scene.primitives[origin.primitive as usize].mesh).or_default().push(f);
        }
        Some(Self { count: scene.instances.len() as u32, others, faces })
    }

    /// How many there are, and the worst of those that are stretched. Fails only if canceled.
    pub fn metrics(&self, measured: &Measured, run: &Run) -> Result<InstanceMetrics, Canceled> {
        let uneven: Vec<&Other> = self.others.iter().filter(|other| other.is_uneven()).collect();
        let mut worst: Option<WorstInstance> = None;
        let mut seen = BTreeSet::new();
        for other in &uneven {
            run.cancel.check()?;
            let transform = DMat3::from_mat4(other.transform);
            // Lengths, and so the energy, depend on this alone: a thousand alike are measured once.
            let metric = (transform.transpose() * transform).to_cols_array().map(f64::to_bits);
            if !seen.insert((other.mesh, metric)) {
                continue;
            }
            let energy = metrics::transformed_dirichlet(measured, self.faces_of(other), transform);
            let is_worse = |e: &f64| worst.is_none_or(|worst| *e > worst.symmetric_dirichlet);
            if let Some(symmetric_dirichlet) = energy.filter(is_worse) {
                worst = Some(WorstInstance { node: other.node, symmetric_dirichlet });
            }
        }
        Ok(InstanceMetrics { count: self.count, uneven: uneven.len() as u32, worst })
    }

    /// The object with all of them, for the pictures.
    pub fn shown(&self, measured: &Measured) -> WholeScene {
        let placed = self.others.iter().map(|other| (self.faces_of(other), other.transform));
        WholeScene::new(measured, placed)
    }

    /// Faces that the pictures have, of an object of `own`.
    pub fn drawn_faces(&self, own: usize) -> usize {
        let more = self.others.iter().map(|other| self.faces_of(other).len());
        preview::drawn_faces(own, more.sum())
    }

    fn faces_of(&self, other: &Other) -> &[u32] {
        self.faces.get(&other.mesh).map_or(&[], Vec::as_slice)
    }
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
