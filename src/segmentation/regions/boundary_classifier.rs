//! The boundary classifier in plain numbers: it is asked for one pair of regions at a time, thousands of
//! times an object. Evidence that is not to be heard is masked.

use burn::nn::Linear;

use super::super::point_mae::PairHead;
use super::features::{AUTHORED, FEATURES, LEARNED, SHAPE};

/// Which evidence counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Heard {
    /// The network's embedding and names.
    pub learned: bool,
    /// Authored components and primitives of the file.
    pub authored: bool,
    /// Concave edges, shape diameter, how regions fill space.
    pub shape: bool,
}

impl Heard {
    /// All evidence.
    pub const ALL: Self = Self { learned: true, authored: true, shape: true };

    /// The network alone.
    pub const LEARNED: Self = Self { learned: true, authored: false, shape: false };

    /// The shape alone.
    pub const SHAPE: Self = Self { learned: false, authored: false, shape: true };

    /// Silence the features of what is not heard.
    pub fn mask(self, features: &mut [f32; FEATURES]) {
        let groups = [(self.learned, LEARNED), (self.authored, AUTHORED), (self.shape, SHAPE)];
        for (_, range) in groups.into_iter().filter(|(heard, _)| !heard) {
            features[range].fill(0.0);
        }
    }
}

/// Says how likely a part ends between two regions.
pub trait Opinion {
    /// Probability that the two regions are of different parts, hearing only what is to be heard.
    fn boundary(&self, features: &[f32; FEATURES], heard: Heard) -> f64;
}

/// A layer: weights by input, then the bias.
#[derive(Debug, Clone, PartialEq, Default)]
struct Layer {
    weight: Vec<f32>,
    bias: Vec<f32>,
}

/// The boundary classifier: three layers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BoundaryClassifier([Layer; 3]);

impl BoundaryClassifier {
    /// The classifier of a trained head.
    pub fn new(head: &PairHead) -> Self {
        let of = |linear: &Linear| Layer {
            weight: linear.weight.val().into_data().try_into_vec().unwrap_or_default(),
            bias: linear
                .bias
                .as_ref()
                .and_then(|b| b.val().into_data().try_into_vec().ok())
                .unwrap_or_default(),
        };
        Self([of(&head.first), of(&head.second), of(&head.third)])
    }

    /// Whether it has learned anything: biases are drawn as 0.
    #[cfg(test)]
    pub fn is_trained(&self) -> bool {
        self.0.iter().all(|layer| layer.bias.iter().any(|b| *b != 0.0))
    }
}

impl Opinion for BoundaryClassifier {
    fn boundary(&self, features: &[f32; FEATURES], heard: Heard) -> f64 {
        let mut masked = *features;
        heard.mask(&mut masked);
        let mut x = masked.to_vec();
        for (i, layer) in self.0.iter().enumerate() {
            x = layer.apply(&x, i < 2);
        }
        let logit = f64::from(x.first().copied().unwrap_or(0.0));
        1.0 / (1.0 + (-logit).exp())
    }
}

impl Layer {
    fn apply(&self, x: &[f32], bends: bool) -> Vec<f32> {
        let mut y = self.bias.clone();
        for (x, row) in x.iter().zip(self.weight.chunks(self.bias.len().max(1))) {
            y.iter_mut().zip(row).for_each(|(y, w)| *y += x * w);
        }
        if bends {
            y.iter_mut().for_each(|y| *y = y.max(0.0));
        }
        y
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::point_mae::{ModelSize, PointMae};
    use super::*;
    use crate::device::Device;
    use burn::tensor::{Tensor, TensorData};

    #[test]
    fn it_says_what_the_head_says() {
        let device = Device::cpu();
        let model = PointMae::new(&ModelSize::Small.config(), 5, &device.burn());
        let classifier = BoundaryClassifier::new(&model.pairs);
        let x: [f32; FEATURES] = std::array::from_fn(|i| (i * 7 % 11) as f32 * 0.2 - 1.0);
        let data = TensorData::new(x.to_vec(), [1, 1, FEATURES]);
        let logit = model.pairs.forward(Tensor::from_data(data, &device.burn()), &device);
        let want = 1.0 / (1.0 + (-f64::from(logit.into_scalar::<f32>())).exp());
        let got = classifier.boundary(&x, Heard::ALL);
        assert!((got - want).abs() < 1e-5, "{got} {want}");
        let deaf = Heard { learned: false, ..Heard::ALL };
        assert_ne!(classifier.boundary(&x, deaf), got);
    }
}
