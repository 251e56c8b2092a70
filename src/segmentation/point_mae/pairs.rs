//! The boundary classifier as a head of the network: does a part end between two regions? It reads what
//! `regions` says of a pair; it is learned from agglomerations of objects whose parts are known (as in Nunez-Iglesias et al.
//! 2013, doi:10.1371/journal.pone.0071715).

use burn::module::Module;
use burn::nn::Linear;
use burn::tensor::{Tensor, TensorData};

use super::layer::{Maker, dense};
use crate::device::Device;
use crate::device::dense::Activation;

/// Numbers that describe a pair.
pub const PAIR_FEATURES: usize = 39;

/// Hidden units of each of the two layers of the whole head.
pub const PAIR_HIDDEN: usize = 32;

/// Two layers and a logit.
#[derive(Module, Debug)]
pub struct PairHead {
    /// `[features, hidden]`.
    pub first: Linear,
    /// `[hidden, hidden]`.
    pub second: Linear,
    /// `[hidden, 1]`.
    pub third: Linear,
}

impl PairHead {
    /// One of `hidden` units a layer that is to be trained alone, on `device`.
    pub fn seeded(seed: u64, hidden: usize, device: &burn::tensor::Device) -> Self {
        Self::of(&mut Maker::new(seed, device), hidden)
    }

    /// Draw its parameters.
    pub fn new(maker: &mut Maker) -> Self {
        Self::of(maker, PAIR_HIDDEN)
    }

    fn of(maker: &mut Maker, hidden: usize) -> Self {
        Self {
            first: maker.linear(PAIR_FEATURES, hidden, true),
            second: maker.linear(hidden, hidden, true),
            third: maker.linear(hidden, 1, true),
        }
    }

    /// One head whose logit is the mean of those of `members`: their units stand side by side.
    pub fn committee(members: &[Self], device: &burn::tensor::Device) -> Self {
        let mut maker = Maker::new(0, device);
        let share = 1.0 / members.len() as f32;
        let firsts: Vec<Block> = members.iter().map(|m| Block::of(&m.first, 1.0)).collect();
        let seconds: Vec<Block> = members.iter().map(|m| Block::of(&m.second, 1.0)).collect();
        let thirds: Vec<Block> = members.iter().map(|m| Block::of(&m.third, share)).collect();
        Self {
            first: beside(&firsts, [false, true], &mut maker),
            second: beside(&seconds, [true, true], &mut maker),
            third: beside(&thirds, [true, false], &mut maker),
        }
    }

    /// Logits that a part ends: `[1, pairs, features]` → `[1, pairs, 1]`.
    pub fn forward(&self, pairs: Tensor<3>, device: &Device) -> Tensor<3> {
        let x = dense(pairs, &self.first, Activation::Relu, device);
        let x = dense(x, &self.second, Activation::Relu, device);
        dense(x, &self.third, Activation::Linear, device)
    }
}

/// The values of a linear map.
struct Block {
    size: [usize; 2],
    weight: Vec<f32>,
    bias: Vec<f32>,
}

impl Block {
    /// Of a map, multiplied.
    fn of(linear: &Linear, by: f32) -> Self {
        let values = |data: TensorData| -> Vec<f32> {
            let values: Vec<f32> = data.try_into_vec().unwrap_or_default();
            values.into_iter().map(|v| v * by).collect()
        };
        let bias = linear.bias.as_ref().map(|b| values(b.val().into_data())).unwrap_or_default();
        Self { size: linear.weight.dims(), weight: values(linear.weight.val().into_data()), bias }
    }
}

/// One map of several: inputs and outputs are each either shared or stand side by side. Biases of
/// shared outputs are added.
fn beside(blocks: &[Block], [inputs, outputs]: [bool; 2], maker: &mut Maker) -> Linear {
    let side = |axis: usize, beside: bool| -> (usize, Vec<usize>) {
        let sizes = blocks.iter().map(|b| b.size[axis]);
        let starts = sizes.clone().scan(0, |next, size| {
            let at = *next;
            *next += if beside { size } else { 0 };
            Some(at)
        });
        (if beside { sizes.sum() } else { sizes.max().unwrap_or(0) }, starts.collect())
    };
    let ((rows, row), (columns, column)) = (side(0, inputs), side(1, outputs));
    let (mut weight, mut bias) = (vec![0.0; rows * columns], vec![0.0; columns]);
    for ((block, row), column) in blocks.iter().zip(row).zip(column) {
        for (i, values) in block.weight.chunks(block.size[1].max(1)).enumerate() {
            let to = &mut weight[(row + i) * columns + column..];
            to.iter_mut().zip(values).for_each(|(to, v)| *to += v);
        }
        bias[column..].iter_mut().zip(&block.bias).for_each(|(to, v)| *to += v);
    }
    Linear {
        weight: maker.parameter(TensorData::new(weight, [rows, columns])),
        bias: Some(maker.parameter(TensorData::new(bias, [columns]))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_committee_says_the_mean_of_what_its_members_say() {
        let device = Device::cpu();
        let members: Vec<PairHead> =
            (1..5).map(|s| PairHead::seeded(s, PAIR_HIDDEN / 4, &device.burn())).collect();
        let values: Vec<f32> = (0..3 * PAIR_FEATURES).map(|i| (i * 7 % 13) as f32 - 6.0).collect();
        let say = |head: &PairHead| -> Vec<f32> {
            let x = TensorData::new(values.clone(), [1, 3, PAIR_FEATURES]);
            let x = Tensor::from_data(x, &device.burn());
            head.forward(x, &device).into_data().try_into_vec().unwrap()
        };
        let whole = PairHead::committee(&members, &device.burn());
        assert_eq!(whole.second.weight.dims(), [PAIR_HIDDEN, PAIR_HIDDEN]);
        for (i, said) in say(&whole).into_iter().enumerate() {
            let mean = members.iter().map(|m| say(m)[i]).sum::<f32>() / 4.0;
            assert!((said - mean).abs() < 1e-4 && mean != 0.0, "{said} {mean}");
        }
    }
}
