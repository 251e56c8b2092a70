//! The layers of the networks, each chart with weights of its own: a linear map with its activation
//! as one operation with a hand-written backward pass (burn-flex would run about six serial passes
//! for the activation alone), and the position encoding. On the processor the operations are fused;
//! on other devices they are composed of burn's own.
//!
//! A fused operation called on a backend that is not listed here panics, so [`Layers`] decides by
//! the device.

mod activation;
mod backward;
mod kernels;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use burn::backend::tensor::FloatTensor;
use burn::backend::{Backend, Dispatch, backend_extension};
use burn::tensor::Tensor;

pub use activation::Activation;

use super::{Device, DeviceKind};

/// Rows that each chart of a batch really has; the others are padding.
pub type Rows = Arc<[usize]>;

/// Fused operations, for backends that have them.
#[backend_extension(Flex, Autodiff)]
pub trait FusedLayers: Backend {
    /// `activation(input · weight + bias)`: `[charts, points, in]`, `[charts, in, out]`,
    /// `[charts, 1, out]` → `[charts, points, out]`.
    fn dense(
        input: FloatTensor<Self>,
        weight: FloatTensor<Self>,
        bias: FloatTensor<Self>,
        rows: Rows,
        activation: Activation,
    ) -> FloatTensor<Self>;

    /// Position encoding of every channel: `[charts, points, c]` → `[charts, points, c(1 + 2k)]`.
    fn octaves(input: FloatTensor<Self>, count: usize) -> FloatTensor<Self>;
}

/// How the layers of a batch are computed.
#[derive(Debug, Clone)]
pub struct Layers {
    rows: Rows,
    fused: bool,
}

impl Layers {
    /// Layers for a batch whose charts have that many rows, in the way that suits the device.
    pub fn new(rows: &[usize], device: &Device) -> Self {
        Self { rows: rows.into(), fused: device.kind() == DeviceKind::Cpu }
    }

    /// The same batch out of burn's own operations, whatever the device.
    #[cfg(test)]
    pub fn composed(rows: &[usize]) -> Self {
        Self { rows: rows.into(), fused: false }
    }

    /// `activation(x w + b)`, each chart by its own `w` (`[charts, in, out]`) and `b`
    /// (`[charts, 1, out]`). Padding rows are meaningless in the result.
    pub fn dense(
        &self,
        x: Tensor<3>,
        w: Tensor<3>,
        b: Tensor<3>,
        activation: Activation,
    ) -> Tensor<3> {
        if !self.fused {
            return activation.composed(x.matmul(w) + b);
        }
        Tensor::from_dispatch(<Dispatch as FusedLayers>::dense(
            x.into_dispatch(),
            w.into_dispatch(),
            b.into_dispatch(),
            self.rows.clone(),
            activation,
        ))
    }

    /// x, and sin and cos of 2ᵏπx for k < `count` (NeRF's encoding, arXiv 2003.08934, Eq. 4).
    pub fn octaves(&self, x: Tensor<3>, count: usize) -> Tensor<3> {
        if self.fused {
            let x = x.into_dispatch();
            return Tensor::from_dispatch(<Dispatch as FusedLayers>::octaves(x, count));
        }
        let mut parts = vec![x.clone()];
        for k in 0..count {
            let angle = x.clone() * (std::f64::consts::PI * f64::from(1_u32 << k));
            parts.extend([angle.clone().sin(), angle.cos()]);
        }
        Tensor::cat(parts, 2)
    }
}
