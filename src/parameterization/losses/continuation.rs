//! Inverse powers of a determinant, continued below ε by their second-order Taylor polynomial: a
//! flipped triangle has a finite value and a gradient that leads back. The continuation is twice
//! differentiable, convex and falling.

/// A function's value and derivative.
#[derive(Clone, Copy)]
pub(super) struct Slope {
    pub value: f64,
    pub derivative: f64,
}

/// 1/d.
#[inline]
pub(super) fn inverse(d: f64, epsilon: f64) -> Slope {
    let x = 1.0 / d.max(epsilon);
    let t = (d - epsilon).min(0.0) * x;
    Slope { value: x * (1.0 - t + t * t), derivative: -x * x * (1.0 - 2.0 * t) }
}

/// 1/d².
#[inline]
pub(super) fn inverse_square(d: f64, epsilon: f64) -> Slope {
    let x = 1.0 / d.max(epsilon);
    let t = (d - epsilon).min(0.0) * x;
    let (x2, x3) = (x * x, x * x * x);
    Slope { value: x2 * (1.0 - 2.0 * t + 3.0 * t * t), derivative: -2.0 * x3 * (1.0 - 3.0 * t) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_above_epsilon_and_smooth_below() {
        for (function, power) in [(inverse as fn(f64, f64) -> Slope, -1), (inverse_square, -2)] {
            for d in [0.05, 0.3, 1.0, 7.0] {
                assert!((function(d, 0.05).value / f64::powi(d, power) - 1.0).abs() < 1e-14);
            }
            let mut last = f64::INFINITY;
            for k in -200..200 {
                let d = k as f64 * 0.01 + 0.003;
                let h = 1e-6;
                let central = (function(d + h, 0.1).value - function(d - h, 0.1).value) / (2.0 * h);
                let slope = function(d, 0.1);
                assert!((central - slope.derivative).abs() < 1e-6 * slope.derivative.abs(), "{d}");
                assert!(slope.derivative < 0.0 && slope.value < last);
                last = slope.value;
            }
        }
    }
}
