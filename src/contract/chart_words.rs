//! The words in which `metrics.json` says how a chart was made.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// What shape a chart was taken for (paper 2.3.1: cylinders are treated apart).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ShapeKind {
    /// Anything.
    #[default]
    General,
    /// The side of a cylinder.
    Cylinder,
    /// The side of a cone.
    Cone,
}

/// How a start map was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum StartKind {
    /// Projected: the chart is flat.
    Planar,
    /// Unrolled from a cylinder or cone, in closed form.
    Unroll,
    /// Unfolded triangle by triangle along a dual tree (exact on developable charts).
    Unfold,
    /// Least squares conformal map.
    #[default]
    Lscm,
    /// Tutte's embedding in a disk: always injective.
    Tutte,
    /// The maps of the patches that were joined, each next to the other: where LSCM flips.
    Weld,
    /// Carried over from the proxy of a dense mesh.
    Prolonged,
    /// Taken from uvunwrap.
    Uvunwrap,
}

/// How a chart's map was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ChartForm {
    /// A network was trained, and its map, polished, is better than the baseline (the start map, polished).
    Trained,
    /// The start map, polished: isometric already, not worth training, or better than the network.
    #[default]
    Start,
    /// The classical fallback.
    Uvunwrap,
}
