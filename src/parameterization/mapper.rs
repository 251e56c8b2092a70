//! The two mappers (paper 2.2): multilayer perceptrons with one set of weights a chart.
//!
//! Forward, F_uv: (γ(p), n, ρ, I, crease, u₀) → Δ, and u = u₀ + Δ. The start map u₀ is an input because
//! it separates the two sides of a cut, which share a position. The boundary-aware attention (2.2.1)
//! is a gate on the first hidden layer, h·σ(W b), b = (ρ, I, crease). Inverse, F_inv: γ(u) → p.
//!
//! The last layers start at zero: step 0 is the start map.

use std::ops::Range;

use burn::tensor::{Tensor, TensorData};

use crate::device::Seeded;
use crate::device::dense::{Activation, Layers};

/// Octaves of the position encoding of points.
pub(super) const POINT_OCTAVES: usize = 6;
/// Octaves of the position encoding of UVs.
pub(super) const UV_OCTAVES: usize = 3;
/// Hidden layers of either mapper.
const HIDDEN: usize = 4;
/// Channels of the boundary features b.
pub(super) const BOUNDARY: usize = 3;
/// Channels of the encoded position.
pub(super) const ENCODED: usize = 3 * (1 + 2 * POINT_OCTAVES);
/// Channels into the forward mapper: encoded position, normal, boundary features, start UV.
pub(super) const INPUTS: usize = ENCODED + 3 + BOUNDARY + 2;
/// Bias of the gate at the start: it begins nearly open.
const GATE_BIAS: f32 = 2.0;

/// Channels in and out of one layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct LayerShape {
    inputs: usize,
    outputs: usize,
}

impl LayerShape {
    fn size(self) -> usize {
        (self.inputs + 1) * self.outputs
    }
}

/// Where the weights of both mappers stand in one row of parameters.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    /// The gate, then the layers of the perceptron.
    forward: Vec<LayerShape>,
    inverse: Vec<LayerShape>,
}

/// Weight (`[charts, in, out]`) and bias (`[charts, 1, out]`) of one layer.
#[derive(Debug, Clone)]
pub(super) struct Leaf {
    weight: Tensor<3>,
    bias: Tensor<3>,
}

impl Layout {
    /// Mappers with hidden layers of that width.
    pub fn new(width: usize) -> Self {
        let perceptron = |inputs, outputs| {
            let mut layers = vec![LayerShape { inputs, outputs: width }];
            layers.resize(HIDDEN, LayerShape { inputs: width, outputs: width });
            layers.push(LayerShape { inputs: width, outputs });
            layers
        };
        let mut forward = vec![LayerShape { inputs: BOUNDARY, outputs: width }];
        forward.extend(perceptron(INPUTS, 2));
        Self { forward, inverse: perceptron(2 * (1 + 2 * UV_OCTAVES), 3) }
    }

    /// Parameters of the forward mapper.
    pub fn forward_size(&self) -> usize {
        self.forward.iter().map(|layer| layer.size()).sum()
    }

    /// Parameters of both mappers.
    pub fn size(&self) -> usize {
        self.forward_size() + self.inverse.iter().map(|layer| layer.size()).sum::<usize>()
    }

    /// Initial parameters of one chart: hidden layers by He et al. (arXiv 1502.01852, Eq. 10), each
    /// octave of an encoding half as strong as the one below (as strong as that, they make the map rough
    /// before they make it good), last layers zero, the gate nearly open and the same everywhere.
    pub fn initial(&self, rng: &mut Seeded) -> Vec<f32> {
        let mut values = Vec::with_capacity(self.size());
        let gate = self.forward[0];
        values.resize(gate.inputs * gate.outputs, 0.0);
        values.resize(gate.size(), GATE_BIAS);
        let encoded = [(3, POINT_OCTAVES), (2, UV_OCTAVES)];
        for (mapper, channels) in [&self.forward[1..], &self.inverse].into_iter().zip(encoded) {
            for (i, layer) in mapper.iter().enumerate() {
                let last = i + 1 == mapper.len();
                let bound = if last { 0.0 } else { (6.0 / layer.inputs as f32).sqrt() };
                for row in 0..layer.inputs {
                    let bound = bound * if i == 0 { attenuation(row, channels) } else { 1.0 };
                    values.extend((0..layer.outputs).map(|_| rng.symmetric(bound)));
                }
                values.resize(values.len() + layer.outputs, 0.0);
            }
        }
        values
    }

    /// The forward mapper's layers, cut out of `[charts, size]` parameters.
    pub fn forward_leaves(&self, parameters: &Tensor<2>) -> Vec<Leaf> {
        cut(parameters, &self.forward, 0)
    }

    /// The inverse mapper's layers.
    pub fn inverse_leaves(&self, parameters: &Tensor<2>) -> Vec<Leaf> {
        cut(parameters, &self.inverse, self.forward_size())
    }
}

/// What the initial weights of an input are multiplied by: 2⁻ᵏ for the k-th octave of the encoding
/// that comes first, `(channels, octaves)`.
fn attenuation(input: usize, (channels, octaves): (usize, usize)) -> f32 {
    let encoded = channels..channels * (1 + 2 * octaves);
    if !encoded.contains(&input) {
        return 1.0;
    }
    let octave = (input - channels) / (2 * channels);
    0.5_f32.powi(octave as i32)
}

fn cut(parameters: &Tensor<2>, shapes: &[LayerShape], mut at: usize) -> Vec<Leaf> {
    let charts = parameters.dims()[0];
    let mut part = |rows: usize, columns: usize| {
        let range: [Range<usize>; 2] = [0..charts, at..at + rows * columns];
        at += rows * columns;
        parameters.clone().slice(range).reshape([charts, rows, columns])
    };
    shapes
        .iter()
        .map(|s| Leaf { weight: part(s.inputs, s.outputs), bias: part(1, s.outputs) })
        .collect()
}

/// The same leaves with gradients.
pub(super) fn tracked(leaves: Vec<Leaf>) -> Vec<Leaf> {
    let track = |t: Tensor<3>| t.autodiff().require_grad();
    leaves
        .into_iter()
        .map(|leaf| Leaf { weight: track(leaf.weight), bias: track(leaf.bias) })
        .collect()
}

/// Gradients of the leaves, side by side as in the parameters: `[charts, n]`. Zero for a leaf that
/// the loss does not reach.
pub(super) fn gradients(leaves: &[Leaf], gradients: &mut burn::tensor::Gradients) -> Tensor<2> {
    let mut flat = |t: &Tensor<3>| {
        let [charts, rows, columns] = t.dims();
        let gradient = t.grad_remove(gradients).unwrap_or_else(|| t.clone().inner().zeros_like());
        gradient.reshape([charts, rows * columns])
    };
    let parts = leaves.iter().flat_map(|leaf| [flat(&leaf.weight), flat(&leaf.bias)]).collect();
    Tensor::cat(parts, 1)
}

/// Δ of the forward mapper, `[charts, points, 2]`, from its inputs (`[charts, points, INPUTS]`) and
/// the boundary features.
pub(super) fn forward(
    layers: &Layers,
    leaves: &[Leaf],
    inputs: Tensor<3>,
    boundary: Tensor<3>,
) -> Tensor<3> {
    let layer = |x, leaf: &Leaf, activation| {
        layers.dense(x, leaf.weight.clone(), leaf.bias.clone(), activation)
    };
    let gate = layer(boundary, &leaves[0], Activation::Sigmoid);
    let first = layer(inputs, &leaves[1], Activation::Gelu) * gate;
    perceptron(layers, &leaves[2..], first)
}

/// The point on the surface for a UV, both in units of the chart's radius: `[charts, points, 3]`.
pub(super) fn inverse(layers: &Layers, leaves: &[Leaf], uv: Tensor<3>) -> Tensor<3> {
    perceptron(layers, leaves, layers.octaves(uv, UV_OCTAVES))
}

/// Layers with GELU between them.
fn perceptron(layers: &Layers, leaves: &[Leaf], mut x: Tensor<3>) -> Tensor<3> {
    for (i, leaf) in leaves.iter().enumerate() {
        let last = i + 1 == leaves.len();
        let activation = if last { Activation::Linear } else { Activation::Gelu };
        x = layers.dense(x, leaf.weight.clone(), leaf.bias.clone(), activation);
    }
    x
}

/// Parameters of several charts as one tensor, `[charts, size]`.
pub(super) fn stack(rows: &[Vec<f32>], device: &burn::tensor::Device) -> Tensor<2> {
    let columns = rows.first().map_or(0, Vec::len);
    Tensor::from_data(TensorData::new(rows.concat(), [rows.len(), columns]), device)
}
