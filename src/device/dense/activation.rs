//! The activations of a layer with their slopes, written so that the compiler turns a loop over them
//! into vector instructions: no branches, no calls. GELU is its tanh form (Hendrycks and Gimpel,
//! arXiv 1606.08415), as z·σ(2c(z + a z³)) with c = √(2/π), a = 0.044715.

use burn::tensor::Tensor;
use burn::tensor::activation::{relu, sigmoid};

/// What stands after a linear map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Activation {
    /// Nothing.
    Linear,
    /// Gaussian error linear unit, tanh form.
    Gelu,
    /// Logistic sigmoid.
    Sigmoid,
    /// The positive part.
    Relu,
}

/// 2√(2/π).
const TWO_C: f32 = 1.595_769;
/// Cubic coefficient of GELU's tanh form.
const CUBIC: f32 = 0.044_715;

impl Activation {
    /// The activation as burn operations, for devices without the fused form.
    pub fn composed(self, z: Tensor<3>) -> Tensor<3> {
        match self {
            Self::Linear => z,
            Self::Gelu => {
                let inner = (z.clone() * z.clone() * CUBIC + 1.0) * z.clone() * TWO_C;
                z * sigmoid(inner)
            }
            Self::Sigmoid => sigmoid(z),
            Self::Relu => relu(z),
        }
    }
}

/// e^x for |x| ≤ 87 (clamped beyond), within 2 units in the last place: 2^n · 2^f, the second by its
/// Taylor polynomial on |f| ≤ ½.
#[inline(always)]
fn exp(x: f32) -> f32 {
    /// Adding and taking away 1.5 · 2²³ rounds to the nearest integer.
    const ROUND: f32 = 12_582_912.0;
    let y = x.clamp(-87.0, 87.0) * std::f32::consts::LOG2_E;
    let shifted = y + ROUND;
    let f = (y - (shifted - ROUND)) * std::f32::consts::LN_2;
    let tail = 1.0 / 6.0 + f * (1.0 / 24.0 + f * (1.0 / 120.0 + f * (1.0 / 720.0)));
    let power = 1.0 + f * (1.0 + f * (0.5 + f * tail));
    // The integer sits in the low bits of `shifted`; moved into the exponent it is 2^n.
    let scale = f32::from_bits(shifted.to_bits().wrapping_add(127) << 23);
    power * scale
}

#[inline(always)]
fn logistic(x: f32) -> f32 {
    1.0 / (1.0 + exp(-x))
}

/// Value and slope of GELU at `z`.
#[inline(always)]
pub(super) fn gelu(z: f32) -> (f32, f32) {
    let square = z * z;
    let s = logistic(TWO_C * z * (1.0 + CUBIC * square));
    let slope = s + z * s * (1.0 - s) * TWO_C * (1.0 + 3.0 * CUBIC * square);
    (z * s, slope)
}

/// Value and slope of the logistic sigmoid at `z`.
#[inline(always)]
pub(super) fn sigmoid_with_slope(z: f32) -> (f32, f32) {
    let s = logistic(z);
    (s, s * (1.0 - s))
}

/// Value and slope of the positive part at `z`.
#[inline(always)]
pub(super) fn relu_with_slope(z: f32) -> (f32, f32) {
    if z > 0.0 { (z, 1.0) } else { (0.0, 0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exact_gelu(z: f64) -> f64 {
        let c = (2.0 / std::f64::consts::PI).sqrt();
        0.5 * z * (1.0 + (c * (z + 0.044715 * z.powi(3))).tanh())
    }

    #[test]
    fn exp_is_close_everywhere() {
        for i in -8700..=8700 {
            let x = i as f32 * 0.01;
            let want = f64::from(x).exp();
            assert!((f64::from(exp(x)) / want - 1.0).abs() < 1e-5, "{x}");
        }
        for i in -1000..=1000 {
            let x = i as f32 * 0.001;
            let want = f64::from(x).exp();
            assert!((f64::from(exp(x)) / want - 1.0).abs() < 3e-7, "{x}");
        }
    }

    #[test]
    fn values_are_exact_and_slopes_are_differences() {
        for i in -400..=400 {
            let z = i as f32 * 0.02;
            let (value, slope) = gelu(z);
            let x = f64::from(z);
            assert!((f64::from(value) - exact_gelu(x)).abs() < 1e-5, "{z}");
            let h = 1e-5;
            let want = (exact_gelu(x + h) - exact_gelu(x - h)) / (2.0 * h);
            assert!((f64::from(slope) - want).abs() < 1e-5, "{z}");
            let (value, slope) = sigmoid_with_slope(z);
            let s = 1.0 / (1.0 + (-x).exp());
            assert!((f64::from(value) - s).abs() < 1e-6);
            assert!((f64::from(slope) - s * (1.0 - s)).abs() < 1e-6);
        }
    }

    #[test]
    fn far_out_it_is_finite() {
        for z in [-1e6, -1e3, -90.0, 90.0, 1e3, 1e6] {
            let (value, slope) = gelu(z);
            assert!(value.is_finite() && slope.is_finite(), "{z}: {value} {slope}");
            assert!((value - z.max(0.0)).abs() < 1e-3);
        }
    }
}
