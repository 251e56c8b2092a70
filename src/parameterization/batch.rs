//! The charts that are trained at the same time, as tensors: `[charts, points, channels]`, each chart
//! padded to the longest. Padding carries zeros in and no gradient out.

use burn::tensor::{Tensor, TensorData};
use rayon::prelude::*;

use super::chart::Trainee;
use super::frame::REST;
use super::losses::RECONSTRUCTION;
use super::mapper::{BOUNDARY, POINT_OCTAVES};
use crate::device::Device;
use crate::device::dense::Layers;

/// Inputs of the networks for a set of charts.
#[derive(Debug)]
pub(super) struct Batch {
    pub layers: Layers,
    rows: Vec<usize>,
    /// Rows of every chart, padding included.
    points: usize,
    device: burn::tensor::Device,
    /// Into the forward mapper: `[charts, points, INPUTS]`.
    pub inputs: Tensor<3>,
    /// Boundary features.
    pub boundary: Tensor<3>,
    /// Positions in their charts' frames, `[charts, points, 3]`.
    pub positions: Tensor<3>,
    /// Start UVs in their charts' frames, `[charts, points, 2]`.
    pub start: Tensor<3>,
    /// Channels after the position, on the host.
    rest: Vec<f32>,
}

impl Batch {
    /// Lay out the samples of these charts.
    pub fn new(charts: &[Trainee], device: &Device) -> Self {
        let rows: Vec<usize> = charts.iter().map(Trainee::rows).collect();
        let points = rows.iter().copied().max().unwrap_or(0);
        let layers = Layers::new(&rows, device);
        let device = device.burn();
        let mut positions = vec![0.0; charts.len() * points * 3];
        let mut rest = vec![0.0; charts.len() * points * REST];
        let of_charts = positions.chunks_mut((points * 3).max(1));
        for ((trainee, positions), rest) in
            charts.iter().zip(of_charts).zip(rest.chunks_mut((points * REST).max(1)))
        {
            for (row, &v) in trainee.sample.vertices.iter().enumerate() {
                let v = v as usize;
                let p = trainee.frame.point(trainee.chart.disk.positions[v]);
                positions[row * 3..][..3].copy_from_slice(&p);
                rest[row * REST..][..REST].copy_from_slice(&trainee.frame.rest(trainee.chart, v));
            }
        }
        let shape = |channels| [charts.len(), points, channels];
        let positions = Tensor::<3>::from_data(TensorData::new(positions, shape(3)), &device);
        let rest_tensor =
            Tensor::<3>::from_data(TensorData::new(rest.clone(), shape(REST)), &device);
        let encoded = layers.octaves(positions.clone(), POINT_OCTAVES);
        let inputs = Tensor::cat(vec![encoded, rest_tensor.clone()], 2);
        let boundary = rest_tensor.clone().narrow(2, 3, BOUNDARY);
        let start = rest_tensor.narrow(2, REST - 2, 2);
        Self { layers, rows, points, device, inputs, boundary, positions, start, rest }
    }

    /// A tensor of the batch from its values.
    pub fn tensor(&self, values: Vec<f32>, channels: usize) -> Tensor<3> {
        let shape = [self.rows.len(), self.points, channels];
        Tensor::from_data(TensorData::new(values, shape), &self.device)
    }

    /// The values of each chart's rows in an array of the batch.
    pub fn split<'a>(&'a self, values: &'a [f32], channels: usize) -> Vec<&'a [f32]> {
        let chunks = values.chunks((self.points * channels).max(1));
        self.rows.iter().zip(chunks).map(|(rows, chunk)| &chunk[..rows * channels]).collect()
    }

    /// Call `each` with every chart, its rows of `read`, and its rows of the array that comes back,
    /// in parallel.
    pub fn map_rows(
        &self,
        charts: &mut [Trainee],
        (read, read_channels): (&[f32], usize),
        channels: usize,
        each: impl Fn(&mut Trainee, &[f32], &mut [f32]) + Sync,
    ) -> Vec<f32> {
        let mut out = vec![0.0; self.rows.len() * self.points * channels];
        let read = self.split(read, read_channels);
        out.par_chunks_mut((self.points * channels).max(1))
            .zip(charts.par_iter_mut())
            .zip(read)
            .for_each(|((out, chart), read)| {
                let rows = chart.rows();
                each(chart, read, &mut out[..rows * channels]);
            });
        out
    }

    /// The channels after the position, start UVs jittered afresh.
    pub fn jittered_rest(&self, charts: &mut [Trainee]) -> Tensor<3> {
        let jitter = |chart: &mut Trainee, rest: &[f32], out: &mut [f32]| chart.jittered(rest, out);
        let values = self.map_rows(charts, (&self.rest, REST), REST, jitter);
        self.tensor(values, REST)
    }

    /// Weight of every row's squared error in the two halves of the reconstruction loss, λ and the
    /// mean over the chart's points included: in 3D (unit r²) and in UV (unit (s r)²).
    /// `[charts, points, 1]` each, zero for padding.
    pub fn reconstruction_weights(&self, charts: &[Trainee]) -> [Tensor<3>; 2] {
        let per_chart = |weight: &dyn Fn(&Trainee) -> f64| {
            let mut values = vec![0.0; self.rows.len() * self.points];
            for (row, chart) in values.chunks_mut(self.points.max(1)).zip(charts) {
                row[..chart.rows()].fill(weight(chart) as f32);
            }
            self.tensor(values, 1)
        };
        let mean = |chart: &Trainee| RECONSTRUCTION / chart.rows().max(1) as f64;
        [per_chart(&mean), per_chart(&|chart| mean(chart) / (chart.scale * chart.scale))]
    }

    /// One number a chart, `[charts, 1]`.
    pub fn per_chart(&self, values: Vec<f32>) -> Tensor<2> {
        let shape = [values.len(), 1];
        Tensor::from_data(TensorData::new(values, shape), &self.device)
    }
}
