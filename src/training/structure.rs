//! How an object may stand in a file: what is known to belong together there says much in one file
//! and nothing in another, and the boundary classifier is to see every kind.

use std::collections::HashMap;

use glam::DVec3;

use crate::mesh::{DisjointSets, Primitive, Scene};
use crate::synth::SynthObject;

/// What the vertices of a file say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Structure {
    /// A node for each part.
    Nodes,
    /// One primitive; parts share no vertices: each is a shell.
    Components,
    /// One primitive; vertices are split at hard edges.
    Smooth,
    /// One primitive; no two triangles share a vertex.
    Soup,
}

impl Structure {
    /// Every kind.
    pub const ALL: [Self; 4] = [Self::Nodes, Self::Components, Self::Smooth, Self::Soup];
}

/// Edges that bend more than this have their vertices split (cosine of 40°).
const HARD: f64 = 0.766;

/// Name, positions and triangles of a mesh.
type Named = (String, Vec<DVec3>, Vec<[u32; 3]>);

/// The object as the pipeline would read it from such a file. Faces stand in the order of its labels.
pub fn scene(object: &SynthObject, structure: Structure) -> Scene {
    let meshes: Vec<Named> = match &object.fused {
        Some(body) => vec![("body".into(), body.positions.clone(), body.triangles.clone())],
        None if structure == Structure::Nodes => {
            let of = |p: &crate::synth::SynthPart| {
                (p.name.clone(), p.positions.clone(), p.triangles.clone())
            };
            object.parts.iter().map(of).collect()
        }
        None => {
            let (mut positions, mut triangles) = (Vec::new(), Vec::new());
            for part in &object.parts {
                let base = positions.len() as u32;
                positions.extend_from_slice(&part.positions);
                triangles.extend(part.triangles.iter().map(|t| t.map(|v| v + base)));
            }
            vec![("object".into(), positions, triangles)]
        }
    };
    let mut scene = Scene::default();
    for (name, positions, triangles) in meshes {
        let (positions, triangles) = match structure {
            Structure::Nodes | Structure::Components => (positions, triangles),
            Structure::Smooth => split(&positions, &triangles, HARD),
            Structure::Soup => split(&positions, &triangles, 2.0),
        };
        scene.add(&name, Primitive::from_triangles(positions, triangles));
    }
    scene
}

/// Faces keep a common vertex only where they hang together over edges whose cosine is at least
/// `least`.
fn split(positions: &[DVec3], triangles: &[[u32; 3]], least: f64) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let normal = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        (b - a).cross(c - a).normalize_or_zero()
    };
    let mut sets = DisjointSets::new(triangles.len());
    let mut edges: HashMap<(u32, u32), u32> = HashMap::new();
    for (f, t) in (0u32..).zip(triangles) {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            if let Some(&g) = edges.get(&(b, a))
                && normal(t).dot(normal(&triangles[g as usize])) >= least
            {
                sets.join(f, g);
            }
            edges.insert((a, b), f);
        }
    }
    let mut number: HashMap<(u32, u32), u32> = HashMap::new();
    let mut out = Vec::new();
    let mut renumbered = Vec::with_capacity(triangles.len());
    for (f, t) in (0u32..).zip(triangles) {
        let set = sets.root(f);
        renumbered.push(t.map(|v| {
            *number.entry((set, v)).or_insert_with(|| {
                out.push(positions[v as usize]);
                out.len() as u32 - 1
            })
        }));
    }
    (out, renumbered)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::contract::{Run, Winding};
    use crate::mesh::{self, Surface};
    use crate::segmentation::regions::components::{AuthoredComponents, welded};
    use crate::synth::{SynthKind, SynthStyle, SynthVariant, make};

    fn conditioned(object: &SynthObject, structure: Structure) -> Surface {
        let scene = scene(object, structure);
        mesh::condition(&scene, Winding::Surface, &Run::quiet()).unwrap().surface
    }

    #[test]
    fn each_structure_has_its_shells_and_the_same_faces() {
        let style = SynthStyle { variant: SynthVariant::MultiNode, triangles: 1000 };
        let object = make(SynthKind::Table, 1, style);
        let count = |structure| {
            let surface = conditioned(&object, structure);
            assert_eq!(surface.face_count(), object.triangle_count());
            let mut shells: Vec<u32> = surface.origins.iter().map(|o| o.shell).collect();
            shells.sort_unstable();
            shells.dedup();
            shells.len()
        };
        let parts = object.parts.len();
        assert_eq!(count(Structure::Nodes), parts);
        assert_eq!(count(Structure::Components), parts);
        assert!(count(Structure::Smooth) > parts);
        // A soup says nothing but what touches.
        let welded: BTreeSet<u32> =
            welded(&conditioned(&object, Structure::Soup)).into_iter().collect();
        assert_eq!(count(Structure::Soup), welded.len());
    }

    #[test]
    fn shells_are_the_authored_components_unless_vertices_are_split_at_hard_edges() {
        let style = SynthStyle { variant: SynthVariant::MultiNode, triangles: 1000 };
        let object = make(SynthKind::Table, 1, style);
        for structure in Structure::ALL {
            let surface = conditioned(&object, structure);
            let components = AuthoredComponents::new(&surface, &welded(&surface));
            let told = structure != Structure::Smooth;
            assert_eq!(components.told, told, "{structure:?}");
            assert!((components.areas.values().sum::<f64>() - surface.area()).abs() < 1e-9);
            if told {
                assert_eq!(components.areas.len(), object.parts.len());
            }
        }
    }
}
