//! The masked autoencoder (Point-MAE, arXiv 2203.06604, Sec. 3): most groups are hidden, the encoder
//! sees the others, a light decoder says what the hidden ones look like, and the Chamfer distance
//! (Eq. 5) to their points is the loss.

use burn::module::{Module, Param};
use burn::nn::Linear;
use burn::tensor::{Int, Tensor, TensorData};

use super::cloud::{NetworkCloud, grouped};
use super::config::PointMaeConfig;
use super::embedding::Position;
use super::layer::{Maker, dense};
use super::model::Encoder;
use super::transformer::Transformer;
use crate::device::dense::Activation;
use crate::device::{Device, Seeded};

/// Share of the groups that are hidden (Point-MAE, Sec. 4.1).
pub const MASKED: f64 = 0.6;

/// What is trained beside the encoder, and dropped after.
#[derive(Module, Debug)]
pub struct Decoder {
    mask_token: Param<Tensor<3>>,
    position: Position,
    transformer: Transformer,
    points: Linear,
}

impl Decoder {
    /// Draw its parameters. `seed` should differ from the encoder's.
    pub fn new(config: &PointMaeConfig, seed: u64, device: &burn::tensor::Device) -> Self {
        let mut maker = Maker::new(seed, device).after(1 << 20);
        Self {
            mask_token: maker.uniform([1, 1, config.width], 0.03),
            position: Position::new(config.width, &mut maker),
            transformer: Transformer::new(
                config.decoder_depth,
                config.width,
                config.heads,
                &mut maker,
            ),
            points: maker.linear(config.width, 3 * config.group_size, true),
        }
    }
}

/// Encoder and decoder.
#[derive(Module, Debug)]
pub struct Autoencoder {
    /// The encoder.
    pub encoder: Encoder,
    /// The decoder.
    pub decoder: Decoder,
}

impl Autoencoder {
    /// The loss of a batch: mean Chamfer distance (squared, both directions) of the hidden groups,
    /// positions relative to their centres. The mask is drawn from `rng`.
    pub fn loss(
        &self,
        config: &PointMaeConfig,
        clouds: &[NetworkCloud],
        rng: &mut Seeded,
        device: &Device,
        tensors: &burn::tensor::Device,
    ) -> Tensor<1> {
        let groups = grouped(clouds, config, tensors);
        let (batch, count) = (clouds.len(), config.groups);
        let masked = (count as f64 * MASKED) as usize;
        let (mut shown, mut hidden) = (Vec::new(), Vec::new());
        for b in 0..batch {
            let mut order: Vec<usize> = (0..count).collect();
            for i in (1..count).rev() {
                order.swap(i, (rng.unit_f64() * (i + 1) as f64) as usize);
            }
            hidden.extend(order[..masked].iter().map(|i| (b * count + i) as i64));
            shown.extend(order[masked..].iter().map(|i| (b * count + i) as i64));
        }
        let (tokens, position) = self.encoder.tokens(&groups, device);
        let width = config.width;
        let pick = |x: Tensor<3>, which: &[i64], width: usize| -> Tensor<3> {
            let index = TensorData::new(which.to_vec(), [which.len()]);
            let index = Tensor::<1, Int>::from_data(index, tensors);
            let rows = x.reshape([batch * count, width]).select(0, index);
            rows.reshape([batch, which.len() / batch, width])
        };
        let seen = pick(tokens, &shown, width);
        let at = pick(position, &shown, width);
        let depth = self.encoder.transformer.depth();
        let mut encoded = self.encoder.transformer.forward(seen, at, &[depth], device);
        let Some(encoded) = encoded.pop() else { return Tensor::zeros([1], tensors) };

        let order: Vec<i64> = (0..batch)
            .flat_map(|b| {
                let shown = &shown[b * (count - masked)..(b + 1) * (count - masked)];
                shown.iter().chain(&hidden[b * masked..(b + 1) * masked]).copied()
            })
            .collect();
        let places = pick(groups.centres.clone(), &order, 3);
        let places = self.decoder.position.forward(places, device);
        let blanks = self.decoder.mask_token.val().expand([batch, masked, width]);
        let all = Tensor::cat(vec![encoded, blanks], 1);
        let depth = self.decoder.transformer.depth();
        let mut decoded = self.decoder.transformer.forward(all, places, &[depth], device);
        let Some(decoded) = decoded.pop() else { return Tensor::zeros([1], tensors) };
        let decoded = decoded.narrow(1, count - masked, masked);
        let size = config.group_size;
        let made = dense(decoded, &self.decoder.points, Activation::Linear, device);
        let made = made.reshape([batch * masked, size, 3]);
        let index = Tensor::<1, Int>::from_data(TensorData::new(hidden, [batch * masked]), tensors);
        let real = groups.neighbourhoods.narrow(2, 0, 3).select(0, index);
        chamfer(made, real)
    }
}

/// Mean over clouds of mean squared distance to the nearest, both ways. `[clouds, points, 3]`.
fn chamfer(a: Tensor<3>, b: Tensor<3>) -> Tensor<1> {
    let square = |x: &Tensor<3>| (x.clone() * x.clone()).sum_dim(2);
    let between = a.clone().matmul(b.clone().transpose()) * -2.0;
    let between = (between + square(&a) + square(&b).transpose()).clamp_min(0.0);
    between.clone().min_dim(1).mean() + between.min_dim(2).mean()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chamfer_is_zero_on_itself_and_known_on_a_shift() {
        let device = burn::tensor::Device::flex();
        let a = Tensor::<3>::from_data([[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]], &device);
        let b = Tensor::<3>::from_data([[[1.0, 0.0, 0.0], [0.0, 0.0, 0.1]]], &device);
        let zero: f32 = chamfer(a.clone(), a.clone()).into_scalar();
        assert!(zero.abs() < 1e-6);
        let got: f32 = chamfer(a, b).into_scalar();
        // One pair coincides, the other is 0.1 apart, both ways.
        assert!((got - 0.01).abs() < 1e-6, "{got}");
    }
}
