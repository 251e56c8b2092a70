//! One training step of a batch, and the evaluation of one chart's networks.
//!
//! burn allows one backward pass a graph, so there are two graphs. The forward mapper gives the UVs;
//! the mesh losses' gradients there are formed on the host; the reconstruction runs on a graph of its
//! own in which the UVs are a leaf; and the sum g of both gradients drives the first graph by the
//! surrogate Σ U·g.

use burn::tensor::{Tensor, TensorData};
use rayon::prelude::*;

use super::MapError;
use super::adam::Adam;
use super::batch::Batch;
use super::chart::Trainee;
use super::frame::REST;
use super::mapper::{self, BOUNDARY, Layout, POINT_OCTAVES};
use super::reconstruction::reconstruct;
use crate::contract::{Cancel, LossForm};
use crate::device::Device;
use crate::device::dense::Layers;
use crate::flatten::UvMap;

/// Steps between two entries of a chart's history.
const HISTORY: u32 = 10;

/// Rows of one evaluation.
const CHUNK: usize = 16_384;

/// One step of every chart of the batch.
pub(super) fn step(
    batch: &Batch,
    charts: &mut [Trainee],
    layout: &Layout,
    adam: &mut Adam,
    form: LossForm,
) -> Result<(), MapError> {
    let leaves = mapper::tracked(layout.forward_leaves(&adam.parameters));
    let (inputs, boundary) = (batch.inputs.clone().autodiff(), batch.boundary.clone().autodiff());
    let delta = mapper::forward(&batch.layers, &leaves, inputs, boundary);

    let values = read(delta.clone().inner())?;
    charts
        .par_iter_mut()
        .zip(batch.split(&values, 2))
        .for_each(|(chart, delta)| chart.measure(delta));

    let uv = batch.start.clone() + delta.clone().inner();
    let back = reconstruct(batch, charts, layout, &adam.parameters, uv, form);
    let inverse = read(back.uv.clone())?;
    let total = batch.map_rows(charts, (&inverse, 2), 2, |chart, inverse, total| {
        chart.join(inverse, total);
    });
    let clips = charts.iter().map(|chart| chart.clip).collect();

    let g = batch.tensor(total, 2).autodiff();
    let mut gradients = (delta * g).sum().backward();
    let mut forward = mapper::gradients(&leaves, &mut gradients);
    if let Some(second) = back.forward.clone() {
        forward = forward + second * batch.per_chart(clips);
    }
    adam.descend(Tensor::cat(vec![forward, back.inverse.clone()], 1));

    if charts.iter().any(|chart| chart.steps.is_multiple_of(HISTORY)) {
        let lost = || MapError::Device("a loss cannot be read".to_owned());
        for (chart, value) in charts.iter_mut().zip(back.values(batch).ok_or_else(lost)?) {
            chart.history.push((chart.loss + value) as f32);
        }
    }
    charts.iter_mut().for_each(|chart| chart.steps += 1);
    Ok(())
}

/// Read a tensor to the host.
pub(super) fn read<const D: usize>(tensor: Tensor<D>) -> Result<Vec<f32>, MapError> {
    let data = tensor.try_into_data().map_err(|e| MapError::Device(format!("{e:?}")))?;
    data.try_into_vec().map_err(|e| MapError::Device(format!("{e:?}")))
}

/// The forward mapper's map on every vertex of a chart. `parameters` is its row, `[1, size]`.
pub(super) fn whole_map(
    chart: &Trainee,
    layout: &Layout,
    parameters: &Tensor<2>,
    device: &Device,
    cancel: &Cancel,
) -> Result<UvMap, MapError> {
    let leaves = layout.forward_leaves(parameters);
    let vertices: Vec<usize> = (0..chart.chart.disk.positions.len()).collect();
    let mut uv = Vec::with_capacity(vertices.len());
    for vertices in vertices.chunks(CHUNK) {
        cancel.check()?;
        let tensor = |values: Vec<f32>, channels: usize| {
            let data = TensorData::new(values, [1, vertices.len(), channels]);
            Tensor::<3>::from_data(data, &device.burn())
        };
        let layers = Layers::new(&[vertices.len()], device);
        let point = |&v: &usize| chart.frame.point(chart.chart.disk.positions[v]);
        let rest = |&v: &usize| chart.frame.rest(chart.chart, v);
        let points = tensor(vertices.iter().flat_map(point).collect(), 3);
        let rest = tensor(vertices.iter().flat_map(rest).collect(), REST);
        let encoded = layers.octaves(points, POINT_OCTAVES);
        let inputs = Tensor::cat(vec![encoded, rest.clone()], 2);
        let boundary = rest.narrow(2, 3, BOUNDARY);
        let delta = read(mapper::forward(&layers, &leaves, inputs, boundary))?;
        let moved =
            |(&v, d): (&usize, &[f32])| chart.frame.moved(chart.chart.start[v], [d[0], d[1]]);
        uv.extend(vertices.iter().zip(delta.chunks_exact(2)).map(moved));
    }
    Ok(uv)
}

/// The inverse mapper's points, in radii about the centre, for UVs in the chart's frame (two numbers
/// each).
pub(super) fn inverse_points(
    uv: &[f32],
    layout: &Layout,
    parameters: &Tensor<2>,
    device: &Device,
) -> Result<Vec<f32>, MapError> {
    let leaves = layout.inverse_leaves(parameters);
    let mut points = Vec::with_capacity(uv.len() / 2 * 3);
    for uv in uv.chunks(2 * CHUNK) {
        let count = uv.len() / 2;
        let layers = Layers::new(&[count], device);
        let uv = Tensor::from_data(TensorData::new(uv.to_vec(), [1, count, 2]), &device.burn());
        points.extend(read(mapper::inverse(&layers, &leaves, uv))?);
    }
    Ok(points)
}
