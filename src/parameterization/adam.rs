//! Adam (Kingma and Ba, arXiv 1412.6980, Algorithm 1) over one tensor of parameters, a row for each
//! chart, with a cosine schedule (Loshchilov and Hutter, arXiv 1608.03983, Eq. 5). Everything is
//! elementwise, so rows do not know of each other.

use burn::tensor::{Int, Tensor};

/// Learning rate at the first step.
const RATE: f64 = 4e-3;
const BETA_1: f64 = 0.9;
const BETA_2: f64 = 0.999;

const EPSILON: f64 = 1e-8;

/// Parameters of all charts of a batch, and their moments. All are `[charts, parameters]`.
#[derive(Debug)]
pub(super) struct Adam {
    pub parameters: Tensor<2>,
    first: Tensor<2>,
    second: Tensor<2>,
    /// Steps taken.
    step: u32,
    /// Steps in all.
    steps: u32,
}

impl Adam {
    /// Before the first of `steps` steps.
    pub fn new(parameters: Tensor<2>, steps: u32) -> Self {
        let zeros = parameters.zeros_like();
        Self { parameters, first: zeros.clone(), second: zeros, step: 0, steps }
    }

    /// One step down the gradient.
    pub fn descend(&mut self, gradient: Tensor<2>) {
        let rate = self.rate();
        self.step += 1;
        let t = self.step as i32;
        let square = gradient.clone() * gradient.clone() * (1.0 - BETA_2);
        self.first = self.first.clone() * BETA_1 + gradient * (1.0 - BETA_1);
        self.second = self.second.clone() * BETA_2 + square;
        // Both bias corrections go into two numbers.
        let correction = (1.0 - BETA_2.powi(t)).sqrt();
        let rate = rate * correction / (1.0 - BETA_1.powi(t));
        let deviation = self.second.clone().sqrt() + EPSILON * correction;
        self.parameters = self.parameters.clone() - self.first.clone() / deviation * rate;
    }

    /// The rate of the coming step: from [`RATE`] to 0 along half a cosine.
    fn rate(&self) -> f64 {
        let progress = f64::from(self.step) / f64::from(self.steps.max(1));
        RATE * 0.5 * (1.0 + (std::f64::consts::PI * progress.min(1.0)).cos())
    }

    /// Keep only these charts, in this order.
    pub fn keep(&mut self, charts: &[usize]) {
        let device = self.parameters.device();
        let indices: Vec<i64> = charts.iter().map(|&c| c as i64).collect();
        let indices = Tensor::<1, Int>::from_data(indices.as_slice(), &device);
        for tensor in [&mut self.parameters, &mut self.first, &mut self.second] {
            *tensor = tensor.clone().select(0, indices.clone());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use burn::tensor::Device;

    #[test]
    fn it_finds_the_bottom_of_a_bowl() {
        let device = Device::flex();
        let target = Tensor::<2>::from_data([[0.3, -0.2], [0.1, 0.25]], &device);
        let mut adam = Adam::new(target.zeros_like(), 400);
        for _ in 0..400 {
            let gradient = (adam.parameters.clone() - target.clone()) * 2.0;
            adam.descend(gradient);
        }
        let error: f32 = (adam.parameters - target).abs().max().into_scalar();
        assert!(error < 1e-3, "{error}");
    }

    #[test]
    fn the_first_step_is_the_rate_in_each_direction() {
        let device = Device::flex();
        let mut adam = Adam::new(Tensor::<2>::zeros([1, 2], &device), 10);
        adam.descend(Tensor::from_data([[5.0, -0.01]], &device));
        let got = adam.parameters.into_data().try_into_vec::<f32>().unwrap();
        assert!((got[0] + 4e-3).abs() < 1e-6 && (got[1] - 4e-3).abs() < 1e-6, "{got:?}");
    }

    #[test]
    fn kept_rows_go_on_as_before() {
        let device = Device::flex();
        let gradient = Tensor::<2>::from_data([[1.0, 2.0], [-3.0, 0.5], [0.1, 0.2]], &device);
        let mut all = Adam::new(Tensor::zeros([3, 2], &device), 10);
        all.descend(gradient.clone());
        let mut some = Adam::new(Tensor::zeros([3, 2], &device), 10);
        some.descend(gradient.clone());
        some.keep(&[2]);
        all.descend(gradient.clone());
        some.descend(gradient.slice([2..3, 0..2]));
        let whole = all.parameters.into_data().try_into_vec::<f32>().unwrap();
        assert_eq!(some.parameters.into_data().try_into_vec::<f32>().unwrap(), whole[4..]);
    }
}
