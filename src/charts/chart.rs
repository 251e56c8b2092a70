//! One chart: faces flattened together.

use glam::DVec3;

use crate::contract::ShapeKind;
pub use crate::contract::StartKind;
use crate::flatten::{Disk, StartMap, UvMap};

/// What shape a chart was taken for (paper 2.3.1: cylinders are treated apart).
#[derive(Debug, Clone, PartialEq, Default)]
pub enum ChartShape {
    /// Anything.
    #[default]
    General,
    /// The side of a cylinder or cone, cut along one axial line.
    Tubular {
        /// A point on the axis.
        origin: DVec3,
        /// Unit axis.
        axis: DVec3,
        /// Radius at the origin.
        radius: f64,
        /// Change of radius along the axis (0 for a cylinder).
        taper: f64,
    },
}

/// Faces that are flattened together.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Chart {
    /// The part it belongs to.
    pub part: u32,
    /// Faces of the surface, in ascending order.
    pub faces: Vec<u32>,
    /// The same faces in the same order as a mesh of its own, cut open.
    pub disk: Disk,
    /// Vertex of the surface that each vertex of the disk stands for.
    pub vertices: Vec<u32>,
    /// What it was taken for.
    pub shape: ChartShape,
    /// Start map at scale 1 (UV area about 3D area), not flipped anywhere.
    pub start: UvMap,
    /// The map by which cutting proved that the chart can be flattened within the bound: injective,
    /// scale 1.
    pub cut_map: UvMap,
    /// How the start map was made.
    pub start_kind: StartKind,
}

impl From<StartMap> for StartKind {
    fn from(kind: StartMap) -> Self {
        match kind {
            StartMap::Planar => Self::Planar,
            StartMap::Unfold => Self::Unfold,
            StartMap::Lscm => Self::Lscm,
            StartMap::Tutte => Self::Tutte,
        }
    }
}

impl ChartShape {
    /// The shape as the metrics tell it.
    pub fn kind(&self) -> ShapeKind {
        match self {
            Self::General => ShapeKind::General,
            Self::Tubular { taper, .. } if taper.abs() > 0.01 => ShapeKind::Cone,
            Self::Tubular { .. } => ShapeKind::Cylinder,
        }
    }
}
