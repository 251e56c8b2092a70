//! Clouds as the network sees them, and their tensors.

use std::ops::Range;

use burn::tensor::{Tensor, TensorData};

use super::config::PointMaeConfig;
use super::grouping::{Groups, group, interpolation};

/// A cloud, centred and scaled to the unit sphere. The lists have one entry a point.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct NetworkCloud {
    /// Positions.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals.
    pub normals: Vec<[f32; 3]>,
    /// Shape diameter: distance through the object to the other side, in the units of the positions; 0 where unknown.
    pub thickness: Vec<f32>,
}

impl NetworkCloud {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Move the middle of the points to the origin and scale the farthest to distance 1. Returns
    /// the middle and the scale, so that other places can be brought along.
    pub fn normalise(&mut self) -> ([f32; 3], f32) {
        let n = self.len().max(1) as f32;
        let middle =
            self.positions.iter().fold([0.0; 3], |m, p| std::array::from_fn(|k| m[k] + p[k] / n));
        let square = |p: &[f32; 3]| (0..3).map(|k| (p[k] - middle[k]).powi(2)).sum::<f32>();
        let radius = self.positions.iter().map(square).fold(0.0, f32::max).sqrt();
        let scale = if radius > 0.0 { 1.0 / radius } else { 1.0 };
        self.place(middle, scale);
        (middle, scale)
    }

    /// Bring the cloud where another one was brought.
    pub fn place(&mut self, middle: [f32; 3], scale: f32) {
        for p in &mut self.positions {
            *p = std::array::from_fn(|k| (p[k] - middle[k]) * scale);
        }
        self.thickness.iter_mut().for_each(|t| *t *= scale);
    }

    /// Some of the points.
    pub fn slice(&self, range: Range<usize>) -> Self {
        Self {
            positions: self.positions[range.clone()].to_vec(),
            normals: self.normals[range.clone()].to_vec(),
            thickness: self.thickness[range].to_vec(),
        }
    }

    /// The channels of a point; its position relative to `origin`.
    fn channels(&self, i: usize, origin: [f32; 3], count: usize, into: &mut Vec<f32>) {
        into.extend((0..3).map(|k| self.positions[i][k] - origin[k]));
        if count > 3 {
            into.extend(self.normals[i]);
            into.push(self.thickness[i]);
        }
    }
}

/// A batch of clouds, grouped.
#[derive(Debug, Clone)]
pub struct Grouped {
    /// Points of the groups relative to their centres: `[batch · groups, size, channels]`.
    pub neighbourhoods: Tensor<3>,
    /// The centres: `[batch, groups, 3]`.
    pub centres: Tensor<3>,
    /// The same on the host.
    pub places: Vec<Vec<[f32; 3]>>,
}

/// Group a batch of clouds of any number of points.
pub fn grouped(
    clouds: &[NetworkCloud],
    config: &PointMaeConfig,
    device: &burn::tensor::Device,
) -> Grouped {
    let (groups, size, channels) = (config.groups, config.group_size, config.channels);
    let (mut values, mut centres) = (Vec::new(), Vec::<f32>::new());
    let mut places = Vec::new();
    for cloud in clouds {
        let Groups { centres: of, members } = group(&cloud.positions, groups, size);
        for (&centre, members) in of.iter().zip(members.chunks(size)) {
            let origin = cloud.positions[centre as usize];
            members.iter().for_each(|&m| cloud.channels(m as usize, origin, channels, &mut values));
        }
        let at: Vec<[f32; 3]> = of.iter().map(|&c| cloud.positions[c as usize]).collect();
        centres.extend(at.iter().flatten());
        places.push(at);
    }
    let batch = clouds.len();
    let data = TensorData::new(values, [batch * groups, size, channels]);
    Grouped {
        neighbourhoods: Tensor::from_data(data, device),
        centres: Tensor::from_data(TensorData::new(centres, [batch, groups, 3]), device),
        places,
    }
}

/// The points at which features are asked, of a batch of clouds with equally many points: their
/// channels `[batch, points, channels]`, and the interpolation `[batch, points, groups]`.
pub fn queries(
    clouds: &[NetworkCloud],
    grouped: &Grouped,
    config: &PointMaeConfig,
    device: &burn::tensor::Device,
) -> (Tensor<3>, Tensor<3>) {
    let (mut values, mut weights) = (Vec::new(), Vec::new());
    for (cloud, centres) in clouds.iter().zip(&grouped.places) {
        (0..cloud.len()).for_each(|i| cloud.channels(i, [0.0; 3], config.channels, &mut values));
        weights.extend(interpolation(&cloud.positions, centres));
    }
    let (batch, points) = (clouds.len(), clouds.first().map_or(0, NetworkCloud::len));
    (
        Tensor::from_data(TensorData::new(values, [batch, points, config.channels]), device),
        Tensor::from_data(TensorData::new(weights, [batch, points, config.groups]), device),
    )
}
