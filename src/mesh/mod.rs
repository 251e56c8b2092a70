//! Meshes: the scene as it was uploaded, kept whole, and the conditioned triangle surface that the
//! solvers work on.

mod condition;
mod disjoint;
pub mod export;
mod formats;
pub mod import;
mod maxflow;
mod numbers;
mod proxy;
pub mod rays;
mod scene;
mod sides;
mod surface;
mod symmetric;
mod telling;

pub use condition::{Conditioned, condition};
pub use disjoint::DisjointSets;
pub use import::{ImportError, import};
pub use maxflow::Flow;
pub use numbers::Numbers;
pub use proxy::{Place, Proxy, ProxySize, proxy};
pub use scene::{
    ABSENT, Attribute, Component, Document, Instance, Material, Mesh, Node, Other, Primitive,
    Scene, TEXCOORD, TexcoordOrigin, Values,
};
pub use sides::Sides;
pub use surface::{CREASE, FaceOrigin, NONE, Surface};
pub use symmetric::{least_eigenvalue, least_eigenvector};
pub use telling::Telling;
