//! What is minimised: for the part embedding the discriminative loss of De Brabandere, Neven and Van
//! Gool (2017, arXiv 1708.02551, Eqs. 1 to 4), for the names the cross entropy of the points whose
//! name is known.

use burn::tensor::activation::{log_softmax, relu};
use burn::tensor::{Tensor, TensorData};

use super::augment::View;
use crate::segmentation::point_mae::{NAMES, PointFeatures};

/// Points of a part are drawn within this distance of its mean.
pub const PULL: f64 = 0.5;

/// Means of parts are pushed this far apart, twice.
pub const PUSH: f64 = 1.5;

/// Weight of the means' distance from the origin.
const SHRINK: f64 = 1e-3;

/// Weight of the names.
const NAME_WEIGHT: f64 = 0.3;

/// Parts of an object that are told apart; the smallest beyond are not learned.
const MOST: usize = 40;

/// A part with fewer points of a view is not learned: it has no mean to speak of.
const LEAST: usize = 4;

/// Labels of a batch as tensors.
pub struct Targets {
    /// Membership over the part's size, `[batch, parts, points]`: rows sum to 1, or to 0 for no part.
    shares: Tensor<3>,
    /// 1 where there is a part, `[batch, parts, 1]`.
    present: Tensor<3>,
    /// 1 for pairs of different parts, `[batch, parts, parts]`.
    pairs: Tensor<3>,
    /// One-hot names over their count, `[batch, points, names]`.
    names: Tensor<3>,
}

impl Targets {
    /// The targets of these views.
    pub fn new(views: &[View], device: &burn::tensor::Device) -> Self {
        let (batch, points) = (views.len(), views.first().map_or(0, |v| v.part.len()));
        let lists: Vec<Vec<Vec<usize>>> = views.iter().map(|v| parts_of(&v.part)).collect();
        let most = lists.iter().map(Vec::len).max().unwrap_or(0).max(1);
        let mut shares = vec![0.0_f32; batch * most * points];
        let mut present = vec![0.0_f32; batch * most];
        let mut pairs = vec![0.0_f32; batch * most * most];
        for (b, parts) in lists.iter().enumerate() {
            for (k, members) in parts.iter().enumerate() {
                let row = &mut shares[(b * most + k) * points..][..points];
                members.iter().for_each(|&i| row[i] = 1.0 / members.len() as f32);
                present[b * most + k] = 1.0;
                for l in (0..parts.len()).filter(|&l| l != k) {
                    pairs[(b * most + k) * most + l] = 1.0;
                }
            }
        }
        let known = views.iter().flat_map(|v| &v.name).filter(|n| **n >= 0).count().max(1);
        let mut names = vec![0.0_f32; batch * points * NAMES.len()];
        for (i, &name) in views.iter().flat_map(|v| &v.name).enumerate().filter(|n| *n.1 >= 0) {
            names[i * NAMES.len() + name as usize] = 1.0 / known as f32;
        }
        let tensor =
            |values, shape: [usize; 3]| Tensor::from_data(TensorData::new(values, shape), device);
        Self {
            shares: tensor(shares, [batch, most, points]),
            present: tensor(present, [batch, most, 1]),
            pairs: tensor(pairs, [batch, most, most]),
            names: tensor(names, [batch, points, NAMES.len()]),
        }
    }
}

/// Points of each part, largest part first.
fn parts_of(part: &[i32]) -> Vec<Vec<usize>> {
    let mut lists = std::collections::BTreeMap::<i32, Vec<usize>>::new();
    for (i, &p) in part.iter().enumerate().filter(|p| *p.1 >= 0) {
        lists.entry(p).or_default().push(i);
    }
    let mut lists: Vec<Vec<usize>> = lists.into_values().filter(|l| l.len() >= LEAST).collect();
    lists.sort_by_key(|l| std::cmp::Reverse(l.len()));
    lists.truncate(MOST);
    lists
}

/// The loss of what the network says.
pub fn loss(features: &PointFeatures, targets: &Targets) -> Tensor<1> {
    let parts = discriminative(features.part.clone(), targets);
    let names = -(log_softmax(features.names.clone(), 2) * targets.names.clone()).sum();
    parts + names * NAME_WEIGHT
}

/// The discriminative loss of an embedding `[batch, points, channels]`; mean over parts, pairs.
fn discriminative(embedding: Tensor<3>, targets: &Targets) -> Tensor<1> {
    let square = |x: Tensor<3>| (x.clone() * x).sum_dim(2);
    let means = targets.shares.clone().matmul(embedding.clone());
    // Squared distance of every point to every mean; a part takes the mean over its own.
    let between = embedding.clone().matmul(means.clone().transpose()) * -2.0;
    let away = between + square(embedding) + square(means.clone()).transpose();
    let away = (away.clamp_min(0.0) + 1e-6).sqrt();
    let pull = relu(away - PULL);
    let pull = (pull.clone() * pull * targets.shares.clone().transpose()).sum()
        / targets.present.clone().sum();

    let size = square(means.clone());
    let apart = means.clone().matmul(means.transpose()) * -2.0 + size.clone();
    let apart = apart + size.clone().transpose();
    let apart = (apart.clamp_min(0.0) + 1e-6).sqrt();
    let push = relu(-apart + 2.0 * PUSH);
    let push = (push.clone() * push * targets.pairs.clone()).sum()
        / targets.pairs.clone().sum().clamp_min(1.0);
    let shrink = (size * targets.present.clone()).sum() / targets.present.clone().sum();
    pull + push + shrink * SHRINK
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::segmentation::point_mae::NetworkCloud;

    fn view(part: &[i32]) -> View {
        let name = part.iter().map(|p| p % 2).collect();
        View { cloud: NetworkCloud::default(), part: part.to_vec(), name }
    }

    fn embed(values: &[f32], device: &burn::tensor::Device) -> Tensor<3> {
        let data = TensorData::new(values.to_vec(), [1, values.len() / 2, 2]);
        Tensor::from_data(data, device)
    }

    #[test]
    fn separated_parts_cost_nothing_and_mixed_ones_what_the_formula_says() {
        let device = burn::tensor::Device::flex();
        let targets = Targets::new(&[view(&[0, 0, 0, 0, 1, 1, 1, 1, -1])], &device);
        let mut apart = [[0.0, 2.0]; 4].concat();
        apart.extend([[0.0, -2.0]; 4].concat());
        apart.extend([9.0, 9.0]);
        let got: f32 = discriminative(embed(&apart, &device), &targets).into_scalar();
        assert!((got - 4.0 * SHRINK as f32).abs() < 1e-5, "{got}");
        // All in one place: nothing to pull, the means are 2 · PUSH too near.
        let got: f32 = discriminative(embed(&[0.0; 18], &device), &targets).into_scalar();
        assert!((got - 9.0).abs() < 0.02, "{got}");
    }

    #[test]
    fn gradients_are_differences() {
        let device = burn::tensor::Device::flex().autodiff();
        let targets = Targets::new(&[view(&[0, 0, 0, 0, 1, 1, 1, 1, -1])], &device);
        let at: Vec<f32> = (0..18).map(|i| (i * 37 % 19) as f32 * 0.11 - 0.9).collect();
        let x = embed(&at, &device).require_grad();
        let mut grads = discriminative(x.clone(), &targets).backward();
        let got: Vec<f32> = x.grad_remove(&mut grads).unwrap().into_data().try_into_vec().unwrap();
        for i in 0..18 {
            let value = |h: f32| {
                let mut moved = at.clone();
                moved[i] += h;
                let x = embed(&moved, &device);
                f64::from(discriminative(x, &targets).into_scalar::<f32>())
            };
            let want = (value(5e-3) - value(-5e-3)) / 1e-2;
            assert!((f64::from(got[i]) - want).abs() < 2e-2 * (1.0 + want.abs()), "{i}: {want}");
        }
    }

    #[test]
    fn unknown_names_count_for_nothing() {
        let device = burn::tensor::Device::flex();
        let targets = Targets::new(&[view(&[-1, -1, -1, -1, -1])], &device);
        assert!((targets.names.sum().into_scalar::<f32>()).abs() < 1e-6);
    }
}
