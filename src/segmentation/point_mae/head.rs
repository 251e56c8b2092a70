//! From tokens to points: features of three blocks are interpolated at each point (paper 2.2.1;
//! Point-MAE's part segmentation, arXiv 2203.06604, Sec. 4.3), joined with what the point itself says
//! and with what the whole cloud says, and read by two heads.
//!
//! A point need not be of the cloud that the encoder saw: any place on the surface can be asked.

use burn::module::Module;
use burn::nn::Linear;
use burn::tensor::Tensor;
use burn::tensor::activation::relu;

use super::config::{NAMES, PointMaeConfig};
use super::layer::{Maker, dense};
use crate::device::Device;
use crate::device::dense::Activation;

/// Hidden channels of what a point itself says.
const LOCAL: usize = 64;

/// What the heads say of points.
#[derive(Debug, Clone)]
pub struct PointFeatures {
    /// Part embedding: points of one part lie near each other. `[batch, points, part]`.
    pub part: Tensor<3>,
    /// Logits over [`NAMES`]. `[batch, points, names]`.
    pub names: Tensor<3>,
}

/// What the encoder says of clouds, ready to be interpolated.
#[derive(Debug, Clone)]
pub struct Tokens {
    /// Of each group: `[batch, groups, head]`.
    each: Tensor<3>,
    /// Of the whole cloud: `[batch, 1, head]`.
    whole: Tensor<3>,
}

/// Propagation and the two heads.
#[derive(Module, Debug)]
pub struct Head {
    mix: Linear,
    global: Linear,
    local_1: Linear,
    local_2: Linear,
    hidden: Linear,
    part_hidden: Linear,
    part: Linear,
    names: Linear,
}

impl Head {
    /// Draw its parameters.
    pub fn new(config: &PointMaeConfig, maker: &mut Maker) -> Self {
        let width = config.head;
        Self {
            mix: maker.linear(config.taps.len() * config.width, width, true),
            global: maker.linear(width, width, false),
            local_1: maker.linear(config.channels, LOCAL, true),
            local_2: maker.linear(LOCAL, width, false),
            hidden: maker.linear(width, width, true),
            part_hidden: maker.linear(width, width, true),
            part: maker.linear(width, config.part, true),
            names: maker.linear(width, NAMES.len(), true),
        }
    }

    /// `taps`: outputs of the encoder, each `[batch, groups, width]`.
    pub fn tokens(&self, taps: Vec<Tensor<3>>, device: &Device) -> Tokens {
        let each = dense(Tensor::cat(taps, 2), &self.mix, Activation::Linear, device);
        let whole = dense(each.clone().max_dim(1), &self.global, Activation::Linear, device);
        Tokens { each, whole }
    }

    /// `points`: `[batch, points, channels]`. `interpolation`: `[batch, points, groups]`, rows summing
    /// to 1.
    pub fn forward(
        &self,
        tokens: &Tokens,
        points: Tensor<3>,
        interpolation: Tensor<3>,
        device: &Device,
    ) -> PointFeatures {
        let Tokens { each, whole } = tokens.clone();
        let local = dense(points, &self.local_1, Activation::Gelu, device);
        let local = dense(local, &self.local_2, Activation::Linear, device);
        let x = relu(interpolation.matmul(each) + local + whole);
        let x = dense(x, &self.hidden, Activation::Gelu, device);
        let part = dense(x.clone(), &self.part_hidden, Activation::Gelu, device);
        PointFeatures {
            part: dense(part, &self.part, Activation::Linear, device),
            names: dense(x, &self.names, Activation::Linear, device),
        }
    }
}
