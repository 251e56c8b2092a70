//! One token a group: a mini-PointNet over its points (Point-MAE, arXiv 2203.06604, Sec. 3.1; PointNet,
//! arXiv 1612.00593), and the position of its centre.

use burn::module::Module;
use burn::nn::Linear;
use burn::tensor::Tensor;

use super::config::PointMaeConfig;
use super::layer::{Maker, Pointwise, RunningNorm, apply, dense};
use crate::device::Device;
use crate::device::dense::Activation;

/// Hidden channels of the position's two layers.
const POSITION: usize = 128;

/// Points of a group → its token.
#[derive(Module, Debug)]
pub struct Embedding {
    first: Pointwise,
    norm_1: Option<RunningNorm>,
    second: Pointwise,
    third: Pointwise,
    norm_2: Option<RunningNorm>,
    fourth: Pointwise,
}

impl Embedding {
    /// Draw its parameters.
    pub fn new(config: &PointMaeConfig, maker: &mut Maker) -> Self {
        let [a, b, c] = config.embedding;
        Self {
            first: maker.pointwise(config.channels, a),
            norm_1: config.batch_norm.then(|| maker.running_norm(a)),
            second: maker.pointwise(a, b),
            third: maker.pointwise(2 * b, c),
            norm_2: config.batch_norm.then(|| maker.running_norm(c)),
            fourth: maker.pointwise(c, config.width),
        }
    }

    /// `[groups, points, channels]`, positions relative to the centre → `[groups, width]`.
    pub fn forward(&self, points: Tensor<3>, device: &Device) -> Tensor<2> {
        let [groups, size, _] = points.dims();
        let (weight, bias) = fold(&self.first, &self.norm_1);
        let x = apply(points, weight, Some(bias), Activation::Relu, device);
        let x =
            apply(x, self.second.matrix(), Some(self.second.bias()), Activation::Linear, device);
        let whole = x.clone().max_dim(1);
        // What the whole group says is the same for all its points: that half of the product is
        // taken once a group.
        let (weight, bias) = fold(&self.third, &self.norm_2);
        let [inputs, _] = weight.dims();
        let mut halves = weight.split(inputs / 2, 0).into_iter();
        let (of_whole, of_point) = (halves.next(), halves.next());
        let (Some(of_whole), Some(of_point)) = (of_whole, of_point) else {
            unreachable!("a matrix split in the middle has two halves")
        };
        let whole = apply(whole, of_whole, Some(bias), Activation::Linear, device);
        let x = apply(x, of_point, None, Activation::Linear, device);
        let x = burn::tensor::activation::relu(x + whole);
        let x =
            apply(x, self.fourth.matrix(), Some(self.fourth.bias()), Activation::Linear, device);
        let width = x.dims()[2];
        debug_assert_eq!(x.dims(), [groups, size, width]);
        x.max_dim(1).reshape([groups, width])
    }
}

#[cfg(test)]
impl Embedding {
    /// Weight and bias of the first layer, its norm folded in.
    pub fn first_layer(&self) -> (Tensor<2>, Tensor<1>) {
        fold(&self.first, &self.norm_1)
    }
}

fn fold(layer: &Pointwise, norm: &Option<RunningNorm>) -> (Tensor<2>, Tensor<1>) {
    match norm {
        Some(norm) => norm.fold(layer.matrix(), layer.bias()),
        None => (layer.matrix(), layer.bias()),
    }
}

/// Where a group is → what is added to its token before every block.
#[derive(Module, Debug)]
pub struct Position {
    first: Linear,
    second: Linear,
}

impl Position {
    /// Draw its parameters.
    pub fn new(width: usize, maker: &mut Maker) -> Self {
        Self { first: maker.linear(3, POSITION, true), second: maker.linear(POSITION, width, true) }
    }

    /// `[batch, groups, 3]` → `[batch, groups, width]`.
    pub fn forward(&self, centres: Tensor<3>, device: &Device) -> Tensor<3> {
        let x = dense(centres, &self.first, Activation::Gelu, device);
        dense(x, &self.second, Activation::Linear, device)
    }
}
