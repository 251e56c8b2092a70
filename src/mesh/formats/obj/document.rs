//! An OBJ file as it was read: its own lists of positions, texture coordinates and normals, and its faces
//! in file order; and the scene that becomes of it, which takes the lists over.

use crate::mesh::scene::{
    ABSENT, Attribute, Material, Mesh, Node, Primitive, Scene, TEXCOORD, Values,
};

/// An OBJ file.
#[derive(Debug, Clone, Default)]
pub(super) struct ObjDocument {
    /// Vertex positions, finite, in single precision as a result will have them: what is flat there is
    /// flat here.
    pub positions: Vec<[f32; 3]>,
    /// Linear RGB of each vertex, 0 to 1, if any vertex has a colour.
    pub colors: Option<Vec<[f32; 3]>>,
    /// Texture coordinates, v up.
    pub texcoords: Vec<[f32; 2]>,
    /// Unit normals; zero where one has no direction.
    pub normals: Vec<[f32; 3]>,
    /// Names of the materials in the order of their first use.
    pub materials: Vec<String>,
    /// Names of the objects or groups, in file order; one that is left and taken up again stands
    /// here twice.
    pub groups: Vec<String>,
    /// Faces in file order, cut where the group or the material changes.
    pub runs: Vec<ObjRun>,
}

/// Consecutive faces of one group and one material. Corners are indices into the document's lists.
#[derive(Debug, Clone, Default)]
pub(super) struct ObjRun {
    /// Index of the object or group.
    pub group: u32,
    /// Index of the material.
    pub material: Option<u32>,
    /// Positions of triangles; polygons are fans.
    pub triangles: Vec<[u32; 3]>,
    /// Their texture coordinates, or [`ABSENT`]; empty while no corner has one.
    pub texcoords: Vec<[u32; 3]>,
    /// Their normals, or [`ABSENT`]; empty while no corner has one.
    pub normals: Vec<[u32; 3]>,
    /// Corners of each polygon; empty while all are triangles.
    pub polygons: Vec<u32>,
}

/// One corner of a face: indices into the document's lists.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ObjCorner {
    /// Position.
    pub position: u32,
    /// Texture coordinate, or [`ABSENT`].
    pub texcoord: u32,
    /// Normal, or [`ABSENT`].
    pub normal: u32,
}

impl ObjRun {
    /// Add a polygon as a fan.
    pub fn add(&mut self, polygon: &[ObjCorner]) {
        let [hub, rim @ ..] = polygon else { return };
        let before = self.triangles.len();
        if polygon.len() > 3 && self.polygons.is_empty() {
            self.polygons.resize(before, 3);
        }
        if polygon.len() > 3 || !self.polygons.is_empty() {
            self.polygons.push(polygon.len() as u32);
        }
        for pair in rim.windows(2) {
            let corners = [*hub, pair[0], pair[1]];
            let before = self.triangles.len();
            self.triangles.push(corners.map(|corner| corner.position));
            push(&mut self.texcoords, before, corners.map(|corner| corner.texcoord));
            push(&mut self.normals, before, corners.map(|corner| corner.normal));
        }
    }
}

/// Add what a face's corners have to a list that stays empty while none has anything.
fn push(list: &mut Vec<[u32; 3]>, before: usize, corners: [u32; 3]) {
    if list.is_empty() && corners == [ABSENT; 3] {
        return;
    }
    list.resize(before, [ABSENT; 3]);
    list.push(corners);
}

impl ObjDocument {
    /// A node and a mesh for each group, a primitive for each run; they share the document's lists.
    pub fn into_scene(self) -> Scene {
        let nodes = (0..).zip(&self.groups);
        let nodes =
            nodes.map(|(i, name)| Node { name: name.clone(), mesh: Some(i), ..Node::default() });
        let mut scene = Scene {
            nodes: nodes.collect(),
            meshes: self.groups.into_iter().map(|name| Mesh { name }).collect(),
            materials: self.materials.into_iter().map(|name| Material { name }).collect(),
            ..Scene::default()
        };
        let no_direction: Vec<bool> = self.normals.iter().map(|n| *n == [0.0; 3]).collect();
        let positions = Values::floats(self.positions);
        let colors = self.colors.map(Values::floats);
        let (texcoords, normals) = (Values::floats(self.texcoords), Values::floats(self.normals));
        let mut number = 0;
        for mut run in self.runs {
            for normal in run.normals.as_flattened_mut() {
                if no_direction.get(*normal as usize).is_some_and(|none| *none) {
                    *normal = ABSENT;
                }
            }
            let of_corners = |name: &str, values: &Values, corners: Vec<[u32; 3]>| {
                let any = corners.as_flattened().iter().any(|&corner| corner != ABSENT);
                let (name, values) = (name.to_owned(), values.clone());
                any.then_some(Attribute { name, values, corners: Some(corners) })
            };
            let of_vertices = |values: &Values| {
                let (name, values) = ("COLOR_0".to_owned(), values.clone());
                Attribute { name, values, corners: None }
            };
            let attributes = [
                of_corners("NORMAL", &normals, run.normals),
                colors.as_ref().map(of_vertices),
                of_corners(TEXCOORD, &texcoords, run.texcoords),
            ];
            let goes_on = scene.primitives.last().is_some_and(|last| last.mesh == run.group);
            number = if goes_on { number + 1 } else { 0 };
            scene.primitives.push(Primitive {
                node: run.group,
                mesh: run.group,
                number,
                material: run.material,
                world: None,
                positions: positions.clone(),
                triangles: run.triangles,
                polygons: Some(run.polygons).filter(|polygons| !polygons.is_empty()),
                attributes: attributes.into_iter().flatten().collect(),
            });
        }
        scene
    }
}
