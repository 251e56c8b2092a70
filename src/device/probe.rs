//! A small computation whose result is known: handles to graphics cards are made without touching
//! the card, and a driver can be there and compute nonsense.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

use burn::tensor::{Tensor, TensorData};

use super::{Device, DeviceError};

/// What a probe found.
#[derive(Debug, Clone, PartialEq)]
pub struct Probe {
    /// Name of the device.
    pub device: String,
    /// Wall-clock seconds of the small computation, with the device's own start-up.
    pub seconds: f64,
}

/// y = x·w by hand.
const PRODUCT: [f32; 4] = [58.0, 64.0, 139.0, 154.0];
/// ∂Σy²/∂w = 2 xᵀ y by hand.
const GRADIENT: [f32; 6] = [1228.0, 1360.0, 1622.0, 1796.0, 2016.0, 2232.0];

/// Multiply two matrices and take one gradient on `device`, and compare with values computed by
/// hand. A panic of a driver is caught and told.
pub fn probe(device: &Device) -> Result<Probe, DeviceError> {
    let broken = |reason: String| DeviceError::Broken { device: device.name(), reason };
    let start = Instant::now();
    let (product, gradient) = catch_unwind(AssertUnwindSafe(|| compute(&device.autodiff())))
        .map_err(|panic| {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            broken(text.or(panic.downcast_ref::<&str>().copied()).unwrap_or("it panicked").into())
        })?;
    let near = |got: &[f32], want: &[f32]| {
        got.len() == want.len()
            && got.iter().zip(want).all(|(g, w)| (g - w).abs() <= 1e-4 * w.abs())
    };
    let (product, gradient) = (product.unwrap_or_default(), gradient.unwrap_or_default());
    if !near(&product, &PRODUCT) {
        return Err(broken(format!("a matrix product is {product:?}, not {PRODUCT:?}")));
    }
    if !near(&gradient, &GRADIENT) {
        return Err(broken(format!("a gradient is {gradient:?}, not {GRADIENT:?}")));
    }
    Ok(Probe { device: device.name(), seconds: start.elapsed().as_secs_f64() })
}

/// The product x·w and the gradient of Σ(x·w)² with respect to w; `None` where it cannot be read.
fn compute(device: &burn::tensor::Device) -> (Option<Vec<f32>>, Option<Vec<f32>>) {
    let matrix = |values: [f32; 6], shape: [usize; 2]| {
        Tensor::<2>::from_data(TensorData::new(values.to_vec(), shape), device)
    };
    let x = matrix([1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [2, 3]);
    let w = matrix([7.0, 8.0, 9.0, 10.0, 11.0, 12.0], [3, 2]).require_grad();
    let y = x.matmul(w.clone());
    let gradients = (y.clone() * y.clone()).sum().backward();
    let read = |t: Tensor<2>| t.try_into_data().ok()?.try_into_vec::<f32>().ok();
    (read(y.inner()), w.grad(&gradients).and_then(read))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_processor_computes() {
        let probe = probe(&Device::cpu()).unwrap();
        assert_eq!(probe.device, "cpu (burn-flex)");
        assert!(probe.seconds >= 0.0);
    }
}
