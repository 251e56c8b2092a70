//! An OBJ file as it was read: its own lists of positions, texture coordinates and normals, and
//! its faces in file order.

use glam::DVec3;

use crate::mesh::formats::gltf::triangles::Renumbering;
use crate::mesh::scene::Primitive;

/// "No texture coordinate", "no normal".
pub const ABSENT: u32 = u32::MAX;

/// An OBJ file.
#[derive(Debug, Clone, Default)]
pub struct ObjDocument {
    /// Vertex positions, finite.
    pub positions: Vec<[f64; 3]>,
    /// Linear RGB of each vertex, 0 to 1, if any vertex has a colour.
    pub colors: Option<Vec<[f32; 3]>>,
    /// Texture coordinates, v up.
    pub texcoords: Vec<[f32; 2]>,
    /// Unit normals.
    pub normals: Vec<[f32; 3]>,
    /// Names of the materials in the order of their first use.
    pub materials: Vec<String>,
    /// Names of the objects or groups, in file order; one that is left and taken up again stands
    /// here twice.
    pub groups: Vec<String>,
    /// Faces in file order, polygons as fans, cut where the group or the material changes.
    pub runs: Vec<ObjRun>,
}

/// Consecutive faces of one group and one material.
#[derive(Debug, Clone)]
pub struct ObjRun {
    /// Index of the object or group.
    pub group: u32,
    /// Index of the material.
    pub material: Option<u32>,
    /// Triangles.
    pub faces: Vec<[ObjCorner; 3]>,
}

/// One corner of a face: indices into the document's lists.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct ObjCorner {
    /// Position.
    pub position: u32,
    /// Texture coordinate, or [`ABSENT`].
    pub texcoord: u32,
    /// Normal, or [`ABSENT`].
    pub normal: u32,
}

impl ObjDocument {
    /// One primitive a run, with the vertices that it uses.
    pub(super) fn primitives(&self) -> Vec<Primitive> {
        let mut numbers = Renumbering::default();
        let primitive = |run: &ObjRun| {
            let mut triangles: Vec<[u32; 3]> =
                run.faces.iter().map(|face| face.map(|corner| corner.position)).collect();
            let used = numbers.apply(&mut triangles, self.positions.len());
            let position = |&v: &u32| DVec3::from_array(self.positions[v as usize]);
            let material_name = run.material.map(|m| self.materials[m as usize].clone());
            Primitive {
                node: run.group,
                mesh: run.group,
                primitive: 0,
                material: run.material,
                name: self.groups[run.group as usize].clone(),
                material_name: material_name.unwrap_or_default(),
                positions: used.iter().map(position).collect(),
                triangles,
                texcoords: self.texcoords_of(run),
            }
        };
        self.runs.iter().map(primitive).collect()
    }

    /// Texture coordinates of a run's corners; none where no corner has any.
    fn texcoords_of(&self, run: &ObjRun) -> Vec<[[f32; 2]; 3]> {
        let at = |corner: ObjCorner| {
            self.texcoords.get(corner.texcoord as usize).copied().unwrap_or([f32::NAN; 2])
        };
        if run.faces.iter().flatten().all(|corner| corner.texcoord == ABSENT) {
            return Vec::new();
        }
        run.faces.iter().map(|face| face.map(at)).collect()
    }
}
