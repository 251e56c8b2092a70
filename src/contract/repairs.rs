//! What conditioning mended, and where it is first.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// What conditioning repaired, for the solvers only: the file keeps its geometry.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
pub struct Repairs {
    /// Vertices merged with another at the same place.
    pub welded: u64,
    /// Faces without area.
    pub zero_area_faces: u64,
    /// Edges with more than two faces.
    pub nonmanifold_edges: u64,
    /// Vertices where several fans met, taken apart.
    pub split_vertices: u64,
    /// Faces that the file winds the other way than the surface is wound: a renderer sees their back.
    #[serde(default)]
    pub against_file_winding: u64,
    /// Faces that the file winds against their own vertex normals.
    #[serde(default)]
    pub against_normals: u64,
    /// Connected components that have no consistent winding; they are cut where they would meet themselves the
    /// wrong way round.
    #[serde(default)]
    pub components_without_winding: u64,
    /// Places where vertices are close to each other one by one and far apart together; they were not merged.
    #[serde(default)]
    pub wide_welds: u64,
    /// Vertices on an edge of a face that does not have them (T-junctions), closed: the edge is no seam.
    #[serde(default)]
    pub t_junctions: u64,
    /// Faces that stand twice, with both windings, as the two sides of a sheet.
    pub double_sided_faces: u64,
    /// Faces at the same place as another with the same winding, less one each: they share its coordinates.
    #[serde(default)]
    pub copies: u64,
    /// Faces at the same place as another with the other winding that are no side of a sheet: they share its
    /// coordinates, mirrored.
    #[serde(default)]
    pub shared_faces: u64,
    /// Faces with more texels than their part's density asks for, since single precision would flatten
    /// them.
    #[serde(default)]
    pub enlarged_faces: u64,
    /// The first face of each kind.
    #[serde(default)]
    pub first_faces: FirstFaces,
}

/// The first face of each kind of what was mended: its number in the file, over all meshes in face order; null
/// where there is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
pub struct FirstFaces {
    /// Without area.
    #[schema(required)]
    pub zero_area_faces: Option<u64>,
    /// Wound the other way than the surface.
    #[schema(required)]
    pub against_file_winding: Option<u64>,
    /// Wound against its vertex normals.
    #[schema(required)]
    pub against_normals: Option<u64>,
    /// Of a component without a consistent winding.
    #[schema(required)]
    pub components_without_winding: Option<u64>,
    /// With a vertex of others on one of its edges.
    #[serde(default)]
    #[schema(required)]
    pub t_junctions: Option<u64>,
    /// At the place of another, with its winding.
    #[schema(required)]
    pub copies: Option<u64>,
    /// At the place of another, with the other winding.
    #[schema(required)]
    pub shared_faces: Option<u64>,
}
