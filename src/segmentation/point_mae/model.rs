//! The network: groups → tokens → encoder → points.

use burn::module::Module;
use burn::tensor::Tensor;

use super::cloud::{Grouped, NetworkCloud, grouped, queries};
use super::config::PointMaeConfig;
use super::embedding::{Embedding, Position};
use super::head::{Head, PointFeatures, Tokens};
use super::layer::Maker;
use super::pairs::PairHead;
use super::transformer::Transformer;
use crate::device::Device;

/// What pre-training makes and segmentation uses.
#[derive(Module, Debug)]
pub struct Encoder {
    pub(super) embedding: Embedding,
    pub(super) position: Position,
    pub(super) transformer: Transformer,
}

impl Encoder {
    fn new(config: &PointMaeConfig, maker: &mut Maker) -> Self {
        Self {
            embedding: Embedding::new(config, maker),
            position: Position::new(config.width, maker),
            transformer: Transformer::new(config.depth, config.width, config.heads, maker),
        }
    }

    /// Tokens `[batch, groups, width]` and their positions.
    pub fn tokens(&self, groups: &Grouped, device: &Device) -> (Tensor<3>, Tensor<3>) {
        let [batch, count, _] = groups.centres.dims();
        let tokens = self.embedding.forward(groups.neighbourhoods.clone(), device);
        let [_, width] = tokens.dims();
        let position = self.position.forward(groups.centres.clone(), device);
        (tokens.reshape([batch, count, width]), position)
    }
}

/// Clouds that were looked at.
#[derive(Debug)]
pub struct Sight {
    groups: Grouped,
    tokens: Tokens,
}

/// Point-MAE for part segmentation.
#[derive(Module, Debug)]
pub struct PointMae {
    /// The encoder.
    pub encoder: Encoder,
    /// Propagation and heads.
    pub head: Head,
    /// The boundary classifier.
    pub pairs: PairHead,
}

impl PointMae {
    /// A network whose parameters are drawn from `seed`.
    pub fn new(config: &PointMaeConfig, seed: u64, device: &burn::tensor::Device) -> Self {
        Self::made(config, &mut Maker::new(seed, device))
    }

    /// A network whose parameters are 0, to be read from a file.
    pub fn blank(config: &PointMaeConfig, device: &burn::tensor::Device) -> Self {
        Self::made(config, &mut Maker::blank(device))
    }

    fn made(config: &PointMaeConfig, maker: &mut Maker) -> Self {
        let encoder = Encoder::new(config, maker);
        let head = Head::new(config, maker);
        Self { encoder, head, pairs: PairHead::new(maker) }
    }

    /// Features at `points` (equally many a cloud) of clouds that `seen` are.
    pub fn forward(
        &self,
        config: &PointMaeConfig,
        seen: &[NetworkCloud],
        points: &[NetworkCloud],
        device: &Device,
        tensors: &burn::tensor::Device,
    ) -> PointFeatures {
        self.ask(config, &self.look(config, seen, device, tensors), points, device, tensors)
    }

    /// Clouds as the encoder sees them.
    pub fn look(
        &self,
        config: &PointMaeConfig,
        clouds: &[NetworkCloud],
        device: &Device,
        tensors: &burn::tensor::Device,
    ) -> Sight {
        let groups = grouped(clouds, config, tensors);
        let (tokens, position) = self.encoder.tokens(&groups, device);
        let taps = self.encoder.transformer.forward(tokens, position, &config.taps, device);
        Sight { tokens: self.head.tokens(taps, device), groups }
    }

    /// Features at `points` (equally many a cloud) of clouds that were looked at.
    pub fn ask(
        &self,
        config: &PointMaeConfig,
        sight: &Sight,
        points: &[NetworkCloud],
        device: &Device,
        tensors: &burn::tensor::Device,
    ) -> PointFeatures {
        let (points, interpolation) = queries(points, &sight.groups, config, tensors);
        self.head.forward(&sight.tokens, points, interpolation, device)
    }
}
