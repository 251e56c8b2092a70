//! Point-MAE (Pang et al. 2022, "Masked Autoencoders for Point Cloud Self-supervised Learning", arXiv
//! 2203.06604): the network behind the learned source (paper 2.2.1).
//!
//! A cloud of 2,048 points becomes 128 groups of 32 (`grouping`), each group a token (`embedding`),
//! the tokens pass a transformer (`transformer`), and the features of three of its blocks are
//! interpolated at any place on the surface, where two heads read them (`head`): a class-agnostic
//! part embedding, and coarse names. `autoencoder` pre-trains the encoder without labels.

mod autoencoder;
mod cloud;
mod clustering;
mod config;
mod embedding;
mod grouping;
mod head;
mod layer;
mod model;
mod pairs;
#[cfg(test)]
mod tests;
mod transformer;
mod weights;

pub use autoencoder::{Autoencoder, Decoder, MASKED};
pub use cloud::{Grouped, NetworkCloud, grouped, queries};
pub use clustering::{Clusters, cluster};
pub use config::{ModelSize, NAMES, PointMaeConfig};
pub use grouping::{Groups, group, interpolation};
pub use head::PointFeatures;
pub use model::{Encoder, PointMae};
pub use pairs::{PAIR_FEATURES, PAIR_HIDDEN, PairHead};
pub use weights::{Loaded, WeightsError, from_bytes, load, save};
