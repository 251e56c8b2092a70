//! Transformer blocks, normalised before (Dosovitskiy et al., arXiv 2010.11929); the position is added
//! before each (Point-MAE, arXiv 2203.06604, Sec. 3.2).

use burn::module::Module;
use burn::nn::{LayerNorm, Linear};
use burn::tensor::Tensor;
use burn::tensor::activation::softmax;

use super::layer::{Maker, dense};
use crate::device::Device;
use crate::device::dense::Activation;

/// Width of a block's hidden layer over its own.
const EXPANSION: usize = 4;

/// Attention, then two layers, each added to what comes in.
#[derive(Module, Debug)]
pub struct Block {
    norm_1: LayerNorm,
    qkv: Linear,
    projection: Linear,
    norm_2: LayerNorm,
    up: Linear,
    down: Linear,
    #[module(skip)]
    heads: usize,
}

impl Block {
    /// Draw its parameters.
    pub fn new(width: usize, heads: usize, maker: &mut Maker) -> Self {
        Self {
            norm_1: maker.norm(width),
            qkv: maker.linear(width, 3 * width, false),
            projection: maker.linear(width, width, true),
            norm_2: maker.norm(width),
            up: maker.linear(width, EXPANSION * width, true),
            down: maker.linear(EXPANSION * width, width, true),
            heads,
        }
    }

    /// `[batch, tokens, width]` → the same shape.
    pub fn forward(&self, x: Tensor<3>, device: &Device) -> Tensor<3> {
        let x = x.clone() + self.attention(self.norm_1.forward(x), device);
        let y = dense(self.norm_2.forward(x.clone()), &self.up, Activation::Gelu, device);
        x + dense(y, &self.down, Activation::Linear, device)
    }

    fn attention(&self, x: Tensor<3>, device: &Device) -> Tensor<3> {
        let [batch, tokens, width] = x.dims();
        let each = width / self.heads;
        let qkv = dense(x, &self.qkv, Activation::Linear, device);
        // [batch, tokens, 3, heads, each] → [3, batch, heads, tokens, each]
        let qkv = qkv.reshape([batch, tokens, 3, self.heads, each]).permute([2, 0, 3, 1, 4]);
        let of = |k: usize| -> Tensor<4> {
            qkv.clone().narrow(0, k, 1).reshape([batch, self.heads, tokens, each])
        };
        let scores = of(0).matmul(of(1).transpose()) * (1.0 / (each as f64).sqrt());
        let mixed = softmax(scores, 3).matmul(of(2));
        let mixed = mixed.permute([0, 2, 1, 3]).reshape([batch, tokens, width]);
        dense(mixed, &self.projection, Activation::Linear, device)
    }
}

/// Blocks in a row, and the norm after the last.
#[derive(Module, Debug)]
pub struct Transformer {
    blocks: Vec<Block>,
    norm: LayerNorm,
}

impl Transformer {
    /// Draw its parameters.
    pub fn new(depth: usize, width: usize, heads: usize, maker: &mut Maker) -> Self {
        let blocks = (0..depth).map(|_| Block::new(width, heads, maker)).collect();
        Self { blocks, norm: maker.norm(width) }
    }

    /// The normalised outputs of the blocks numbered `taps` (from 1, ascending). The blocks after the
    /// last of them are not computed.
    pub fn forward(
        &self,
        mut x: Tensor<3>,
        position: Tensor<3>,
        taps: &[usize],
        device: &Device,
    ) -> Vec<Tensor<3>> {
        let mut out = Vec::with_capacity(taps.len());
        let last = taps.iter().copied().max().unwrap_or(0);
        for (i, block) in self.blocks.iter().enumerate().take(last) {
            x = block.forward(x + position.clone(), device);
            if taps.contains(&(i + 1)) {
                out.push(self.norm.forward(x.clone()));
            }
        }
        out
    }

    /// How many blocks there are.
    pub fn depth(&self) -> usize {
        self.blocks.len()
    }
}

#[cfg(test)]
impl Transformer {
    /// Weight of the last layer of the second block, `[4 width, width]`.
    pub fn second_block_down(&self) -> Tensor<2> {
        self.blocks[1].down.weight.val()
    }
}
