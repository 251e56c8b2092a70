//! Meshes: the scene as it was uploaded, kept whole, and the conditioned triangle surface that the
//! solvers work on.

mod condition;
mod disjoint;
mod existing_seams;
pub mod export;
mod formats;
pub mod import;
mod maxflow;
mod orient;
mod pairing;
mod proxy;
pub mod rays;
mod scene;
mod surface;
mod symmetric;
mod weld;

pub use condition::condition;
pub use disjoint::DisjointSets;
pub use import::{ImportError, import};
pub use maxflow::Flow;
pub use proxy::{Place, Proxy, ProxySize, proxy};
pub use scene::{
    ABSENT, Attribute, Component, Document, Instance, Material, Mesh, Node, Other, Primitive,
    Scene, TEXCOORD, TexcoordOrigin, Values,
};
pub use surface::{CREASE, FaceOrigin, NONE, Surface};
pub use symmetric::{least_eigenvalue, least_eigenvector};
