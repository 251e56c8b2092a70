//! The head that judges pairs of regions: does a part end between them? It reads what `regions` says of
//! a pair; learned from agglomerations of objects whose parts are known (as in Nunez-Iglesias et al.
//! 2013, doi:10.1371/journal.pone.0071715).

use burn::module::Module;
use burn::nn::Linear;
use burn::tensor::Tensor;

use super::layer::{Maker, dense};
use crate::device::Device;
use crate::device::dense::Activation;

/// Numbers that describe a pair.
pub const PAIR_FEATURES: usize = 39;

/// Hidden units of each of its two layers.
pub const PAIR_HIDDEN: usize = 32;

/// Two layers and a logit.
#[derive(Module, Debug)]
pub struct PairHead {
    /// `[features, hidden]`.
    pub first: Linear,
    /// `[hidden, hidden]`.
    pub second: Linear,
    /// `[hidden, 1]`.
    pub third: Linear,
}

impl PairHead {
    /// One that is to be trained alone, on `device`.
    pub fn seeded(seed: u64, device: &burn::tensor::Device) -> Self {
        Self::new(&mut Maker::new(seed, device))
    }

    /// Draw its parameters.
    pub fn new(maker: &mut Maker) -> Self {
        Self {
            first: maker.linear(PAIR_FEATURES, PAIR_HIDDEN, true),
            second: maker.linear(PAIR_HIDDEN, PAIR_HIDDEN, true),
            third: maker.linear(PAIR_HIDDEN, 1, true),
        }
    }

    /// Logits that a part ends: `[1, pairs, features]` → `[1, pairs, 1]`.
    pub fn forward(&self, pairs: Tensor<3>, device: &Device) -> Tensor<3> {
        let x = dense(pairs, &self.first, Activation::Relu, device);
        let x = dense(x, &self.second, Activation::Relu, device);
        dense(x, &self.third, Activation::Linear, device)
    }
}
