//! The reconstruction loss (paper 2.3.2), the one loss that goes through the networks:
//! mean ‖F_inv(u) − p‖²/r² + mean ‖F_uv(x with p ← F_inv(u)) − u‖²/(s r)², u = F_uv(x).
//!
//! In the second half the other inputs (normal, boundary features) are taken at the surface point that
//! owns u, and the start UV is jittered, or F_uv could copy it. F_inv has one value for each u, so two
//! layers over one u cost half their squared distance: a soft sign of overlap, which no loss on
//! triangles gives. The paper's second half, ‖F_uv(P) − U‖², is 0 where U is the prediction, so its
//! form is the first half alone.
//!
//! u is a leaf here: its gradient is clipped before it joins the others (paper 2.2.2).

use burn::tensor::Tensor;

use super::batch::Batch;
use super::chart::Trainee;
use super::mapper::{self, Layout, POINT_OCTAVES};
use crate::contract::LossForm;

/// What the loss asks for.
#[derive(Debug)]
pub(super) struct Reconstruction {
    /// Gradient with respect to u, by radii: `[charts, points, 2]`.
    pub uv: Tensor<3>,
    /// Gradient with respect to the forward mapper's parameters; `None` in the paper's form.
    pub forward: Option<Tensor<2>>,
    /// Gradient with respect to the inverse mapper's parameters.
    pub inverse: Tensor<2>,
    /// Weighted squared errors: their sum over a chart is its loss.
    errors: Vec<Tensor<3>>,
}

/// Value and gradients at `uv` (in the charts' frames), λ included.
pub(super) fn reconstruct(
    batch: &Batch,
    charts: &mut [Trainee],
    layout: &Layout,
    parameters: &Tensor<2>,
    uv: Tensor<3>,
    form: LossForm,
) -> Reconstruction {
    let [in_space, in_plane] = batch.reconstruction_weights(charts);
    let uv = uv.autodiff().require_grad();
    let inverse = mapper::tracked(layout.inverse_leaves(parameters));
    let point = mapper::inverse(&batch.layers, &inverse, uv.clone());
    let mut errors = vec![weighted(point.clone(), batch.positions.clone().autodiff(), in_space)];
    let mut forward = None;
    if form == LossForm::Sound {
        let leaves = mapper::tracked(layout.forward_leaves(parameters));
        let rest = batch.jittered_rest(charts).autodiff();
        let encoded = batch.layers.octaves(point, POINT_OCTAVES);
        let inputs = Tensor::cat(vec![encoded, rest], 2);
        let boundary = batch.boundary.clone().autodiff();
        let delta = mapper::forward(&batch.layers, &leaves, inputs, boundary);
        let again = batch.start.clone().autodiff() + delta;
        errors.push(weighted(again, uv.clone(), in_plane));
        forward = Some(leaves);
    }
    let mut total = errors[0].clone().sum();
    if let Some(second) = errors.get(1) {
        total = total + second.clone().sum();
    }
    let mut gradients = total.backward();
    Reconstruction {
        uv: uv.grad_remove(&mut gradients).unwrap_or_else(|| batch.start.zeros_like()),
        forward: forward.map(|leaves| mapper::gradients(&leaves, &mut gradients)),
        inverse: mapper::gradients(&inverse, &mut gradients),
        errors: errors.into_iter().map(Tensor::inner).collect(),
    }
}

impl Reconstruction {
    /// The loss of each chart; `None` where the device fails.
    pub fn values(self, batch: &Batch) -> Option<Vec<f64>> {
        let mut sums = Vec::new();
        for errors in self.errors {
            let channels = errors.dims()[2];
            let errors = errors.try_into_data().ok()?.try_into_vec::<f32>().ok()?;
            let of_charts = batch.split(&errors, channels);
            sums.resize(of_charts.len(), 0.0);
            for (sum, rows) in sums.iter_mut().zip(of_charts) {
                *sum += rows.iter().map(|&e| f64::from(e)).sum::<f64>();
            }
        }
        Some(sums)
    }
}

fn weighted(a: Tensor<3>, b: Tensor<3>, weight: Tensor<3>) -> Tensor<3> {
    let difference = a - b;
    difference.clone() * difference * weight.autodiff()
}
