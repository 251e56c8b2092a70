//! Boundary-sensitive sampling of a surface (paper 2.1): salient edges and the field around them
//! (`sensitivity`), base points by area (`base`), extra blue-noise points on the faces at salient
//! edges (`blue_noise`), and the farthest-point subsample that a network sees (`farthest`).

mod base;
mod blue_noise;
mod cloud;
mod farthest;
mod sensitivity;

pub use cloud::{DENSE_CAP, PointCloud, SampleCounts, sample};
pub use farthest::{NETWORK_POINTS, farthest_points};
pub use sensitivity::EdgeField;
