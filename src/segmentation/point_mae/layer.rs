//! Layers of the network: parameters drawn by our own seeded generator (burn-flex keeps one for the
//! process), numbered in the order they are made, so that an optimizer's saved moments find them
//! again; and their application, fused on the processor.

use burn::module::{Module, Param, ParamId};
use burn::nn::{LayerNorm, LayerNormConfig, Linear};
use burn::tensor::{Tensor, TensorData};

use crate::device::dense::{Activation, Layers};
use crate::device::{Device, Seeded, uniform};

/// Draws and numbers parameters.
pub struct Maker<'a> {
    /// Draws the values; without it they are 0.
    rng: Option<Seeded>,
    next: u64,
    device: &'a burn::tensor::Device,
}

impl<'a> Maker<'a> {
    /// Parameters of `seed`, on `device`.
    pub fn new(seed: u64, device: &'a burn::tensor::Device) -> Self {
        Self { rng: Some(Seeded::new(seed, 4)), next: 1, device }
    }

    /// Parameters that are 0, on `device`: a place for those of a file.
    pub fn blank(device: &'a burn::tensor::Device) -> Self {
        Self { rng: None, next: 1, device }
    }

    /// Number from here on.
    pub fn after(self, number: u64) -> Self {
        Self { next: number, ..self }
    }

    /// A parameter of these values.
    pub fn parameter<const D: usize>(&mut self, data: TensorData) -> Param<Tensor<D>> {
        let id = ParamId::from(self.next);
        self.next += 1;
        let tensor = Tensor::from_data(data, self.device);
        let learns = self.device.is_autodiff();
        Param::initialized(id, if learns { tensor.require_grad() } else { tensor })
    }

    /// Uniform values.
    pub fn uniform<const D: usize>(&mut self, shape: [usize; D], bound: f32) -> Param<Tensor<D>> {
        let data = match &mut self.rng {
            Some(rng) => uniform(rng, shape, bound),
            None => TensorData::zeros::<f32, _>(shape),
        };
        self.parameter(data)
    }

    fn constant(&mut self, length: usize, value: f32) -> Param<Tensor<1>> {
        self.parameter(TensorData::new(vec![value; length], [length]))
    }

    fn fixed(&mut self, length: usize, value: f32) -> Param<Tensor<1>> {
        let learns = self.device.is_autodiff();
        let constant = self.constant(length, value);
        if learns { constant.set_require_grad(false) } else { constant }
    }

    /// A linear map, weights `[inputs, outputs]` by Glorot and Bengio (2010), bias 0.
    pub fn linear(&mut self, inputs: usize, outputs: usize, bias: bool) -> Linear {
        let bound = (6.0 / (inputs + outputs) as f32).sqrt();
        let weight = self.uniform([inputs, outputs], bound);
        Linear { weight, bias: bias.then(|| self.constant(outputs, 0.0)) }
    }

    /// A pointwise map, by He et al. (arXiv 1502.01852).
    pub fn pointwise(&mut self, inputs: usize, outputs: usize) -> Pointwise {
        let weight = self.uniform([outputs, inputs, 1], (6.0 / inputs as f32).sqrt());
        Pointwise { weight, bias: self.constant(outputs, 0.0) }
    }

    /// Layer normalisation.
    pub fn norm(&mut self, width: usize) -> LayerNorm {
        let mut norm = LayerNormConfig::new(width).init(self.device);
        norm.gamma = self.constant(width, 1.0);
        norm.beta = Some(self.constant(width, 0.0));
        norm
    }

    /// Batch normalisation as it is at inference.
    pub fn running_norm(&mut self, width: usize) -> RunningNorm {
        RunningNorm {
            weight: self.constant(width, 1.0),
            bias: self.constant(width, 0.0),
            running_mean: self.fixed(width, 0.0),
            running_var: self.fixed(width, 1.0),
        }
    }
}

/// A convolution of kernel 1: the same linear map at every point. `[out, in, 1]` as PyTorch keeps it.
#[derive(Module, Debug)]
pub struct Pointwise {
    weight: Param<Tensor<3>>,
    bias: Param<Tensor<1>>,
}

impl Pointwise {
    /// The weight as a matrix `[in, out]`.
    pub fn matrix(&self) -> Tensor<2> {
        let [outputs, inputs, _] = self.weight.dims();
        self.weight.val().reshape([outputs, inputs]).transpose()
    }

    /// The bias.
    pub fn bias(&self) -> Tensor<1> {
        self.bias.val()
    }
}

/// Batch normalisation with the statistics it has: weights that were trained elsewhere bring theirs.
/// Training here keeps them as they are (a batch of few clouds has no statistics worth having).
#[derive(Module, Debug)]
pub struct RunningNorm {
    weight: Param<Tensor<1>>,
    bias: Param<Tensor<1>>,
    running_mean: Param<Tensor<1>>,
    running_var: Param<Tensor<1>>,
}

impl RunningNorm {
    /// Fold it into the linear map before it: x ↦ (x W + b − μ) g + β is linear too.
    pub fn fold(&self, weight: Tensor<2>, bias: Tensor<1>) -> (Tensor<2>, Tensor<1>) {
        let gain = self.weight.val() / (self.running_var.val() + 1e-5).sqrt();
        let bias = (bias - self.running_mean.val()) * gain.clone() + self.bias.val();
        (weight * gain.unsqueeze(), bias)
    }
}

/// `activation(x w + b)` at every row: `[batch, rows, in]` → `[batch, rows, out]`.
pub fn apply(
    x: Tensor<3>,
    weight: Tensor<2>,
    bias: Option<Tensor<1>>,
    activation: Activation,
    device: &Device,
) -> Tensor<3> {
    let [batch, rows, inputs] = x.dims();
    let [_, outputs] = weight.dims();
    let bias = bias.unwrap_or_else(|| Tensor::zeros([outputs], &weight.device()));
    let layers = Layers::new(&[batch * rows], device);
    let x = x.reshape([1, batch * rows, inputs]);
    let y = layers.dense(x, weight.unsqueeze(), bias.reshape([1, 1, outputs]), activation);
    y.reshape([batch, rows, outputs])
}

/// A linear layer with its activation.
pub fn dense(x: Tensor<3>, layer: &Linear, activation: Activation, device: &Device) -> Tensor<3> {
    apply(x, layer.weight.val(), layer.bias.as_ref().map(|b| b.val()), activation, device)
}
