//! How good the network is on objects that it does not learn from: its own clusters against the
//! parts, over points; its names where they are known.

use burn::tensor::Tensor;
use serde::{Deserialize, Serialize};

use super::augment::{View, plain};
use super::example::Example;
use crate::device::Device;
use crate::segmentation::agreement::agreement;
use crate::segmentation::point_mae::{NAMES, PointMae, PointMaeConfig, cluster};

/// Means over the held-out objects.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// Best-match mIoU of clustered points.
    pub miou: f64,
    /// Rand index of clustered points.
    pub rand: f64,
    /// Share of the points with a known name that get it.
    pub names: f64,
    /// Objects.
    pub objects: usize,
}

/// Score a network.
pub fn score(
    model: &PointMae,
    config: &PointMaeConfig,
    examples: &[Example],
    device: &Device,
) -> Score {
    let mut sum = Score::default();
    let (mut named, mut right) = (0usize, 0usize);
    for example in examples {
        let view = plain(example);
        let seen = [view.cloud.clone()];
        let features = model.forward(config, &seen, &seen, device, &device.burn());
        let clusters = cluster(&values(features.part), config.part);
        let found: Vec<i32> = clusters.label.iter().map(|&l| l as i32).collect();
        let got = agreement(&view.part, &found, &vec![1.0; found.len()]);
        (sum.miou, sum.rand) = (sum.miou + got.miou, sum.rand + got.rand);
        let (of, hits) = names(&view, &values(features.names));
        (named, right) = (named + of, right + hits);
    }
    let n = examples.len().max(1) as f64;
    Score {
        miou: sum.miou / n,
        rand: sum.rand / n,
        names: right as f64 / named.max(1) as f64,
        objects: examples.len(),
    }
}

fn names(view: &View, logits: &[f32]) -> (usize, usize) {
    let pairs = view.name.iter().zip(logits.chunks(NAMES.len()));
    let known = pairs.filter(|(name, _)| **name >= 0);
    let best = |row: &[f32]| (0..row.len()).fold(0, |b, i| if row[i] > row[b] { i } else { b });
    known.fold((0, 0), |(of, right), (&name, row)| {
        (of + 1, right + usize::from(best(row) == name as usize))
    })
}

fn values(t: Tensor<3>) -> Vec<f32> {
    t.into_data().try_into_vec().unwrap_or_default()
}
