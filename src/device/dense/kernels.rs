//! The arithmetic of the fused operations on the processor: a linear map and its activation in one
//! pass over blocks of rows, and the same backwards.
//!
//! Arrays are row-major `[charts, points, channels]`; chart `c` has `rows[c]` points of its own, the
//! rest is padding, left at zero and never read. Blocks have a fixed height and sums over blocks are
//! taken in order, so results depend neither on the number of threads nor on the other charts.

use faer::linalg::matmul::matmul;
use faer::traits::pulp::{Arch, NullaryFnOnce};
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;

use super::activation::{Activation, gelu, relu_with_slope, sigmoid_with_slope};

/// Rows of one task. Fits the second-level cache at the usual widths.
const BLOCK: usize = 256;

/// Sizes of a batched linear map.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sizes {
    /// Rows of a chart, padding included.
    pub points: usize,
    /// Channels in.
    pub inputs: usize,
    /// Channels out.
    pub outputs: usize,
}

/// `act(x w + b)` and, where asked for, the slope of the activation at every entry.
pub(super) fn forward(
    [x, w, b]: [&[f32]; 3],
    sizes: Sizes,
    rows: &[usize],
    activation: Activation,
    with_slope: bool,
) -> (Vec<f32>, Vec<f32>) {
    let Sizes { points, inputs, outputs } = sizes;
    let length = rows.len() * points * outputs;
    let mut y = vec![0.0; length];
    let keep = with_slope && activation != Activation::Linear;
    let mut slope = vec![0.0; if keep { length } else { 0 }];

    let mut tasks = Vec::new();
    let mut slopes = slope.chunks_mut((points * outputs).max(1));
    for (chart, y) in y.chunks_mut((points * outputs).max(1)).enumerate() {
        let mut y = &mut y[..rows[chart] * outputs];
        let mut slope = slopes.next().map_or(&mut [][..], |s| &mut s[..rows[chart] * outputs]);
        let mut first = 0;
        while !y.is_empty() {
            let count = BLOCK.min(rows[chart] - first);
            let (head, tail) = y.split_at_mut(count * outputs);
            let (slope_head, slope_tail) = slope.split_at_mut((count * outputs).min(slope.len()));
            tasks.push((chart, first, head, slope_head));
            (y, slope, first) = (tail, slope_tail, first + count);
        }
    }
    tasks.into_par_iter().for_each(|(chart, first, y, slope)| {
        let count = y.len() / outputs;
        let from = (chart * points + first) * inputs;
        let x = MatRef::from_row_major_slice(&x[from..from + count * inputs], count, inputs);
        let w = chart_matrix(w, chart, inputs, outputs);
        let out = MatMut::from_row_major_slice_mut(&mut *y, count, outputs);
        matmul(out, Accum::Replace, x, w, 1.0, Par::Seq);
        let bias = &b[chart * outputs..(chart + 1) * outputs];
        Arch::new().dispatch(Activate { y, slope, bias, activation });
    });
    (y, slope)
}

/// Add the bias, apply the activation, and note its slope where there is room for it. A structure and
/// no closure, since only what is inlined gets the vector instructions of the machine.
struct Activate<'a> {
    y: &'a mut [f32],
    slope: &'a mut [f32],
    bias: &'a [f32],
    activation: Activation,
}

impl NullaryFnOnce for Activate<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { y, slope, bias, activation } = self;
        match activation {
            Activation::Linear => y.chunks_exact_mut(bias.len()).for_each(|y| add(y, bias)),
            Activation::Gelu => apply(y, slope, bias, gelu),
            Activation::Sigmoid => apply(y, slope, bias, sigmoid_with_slope),
            Activation::Relu => apply(y, slope, bias, relu_with_slope),
        }
    }
}

#[inline(always)]
fn apply(y: &mut [f32], slope: &mut [f32], bias: &[f32], f: impl Fn(f32) -> (f32, f32)) {
    let outputs = bias.len();
    if slope.is_empty() {
        for y in y.chunks_exact_mut(outputs) {
            for (y, b) in y.iter_mut().zip(bias) {
                *y = f(*y + b).0;
            }
        }
    } else {
        for (y, slope) in y.chunks_exact_mut(outputs).zip(slope.chunks_exact_mut(outputs)) {
            for ((y, slope), b) in y.iter_mut().zip(slope).zip(bias) {
                (*y, *slope) = f(*y + b);
            }
        }
    }
}

/// Gradients of a linear map with activation, given that of its result. The one with respect to
/// the input is empty unless it is `wanted`.
pub(super) struct Backward {
    pub x: Vec<f32>,
    pub w: Vec<f32>,
    pub b: Vec<f32>,
}

/// Gradients with respect to input, weight and bias. `slope` is empty for a linear layer.
pub(super) fn backward(
    [x, w, slope, gradient]: [&[f32]; 4],
    sizes: Sizes,
    rows: &[usize],
    input_wanted: bool,
) -> Backward {
    let Sizes { points, inputs, outputs } = sizes;
    let charts = rows.len();
    let mut x_gradient = vec![0.0; if input_wanted { charts * points * inputs } else { 0 }];

    let mut tasks = Vec::new();
    let mut rest = x_gradient.chunks_mut((points * inputs).max(1));
    for (chart, &rows) in rows.iter().enumerate() {
        let mut dx = rest.next().map_or(&mut [][..], |dx| &mut dx[..rows * inputs]);
        for first in (0..rows).step_by(BLOCK) {
            let count = BLOCK.min(rows - first);
            let (head, tail) = dx.split_at_mut((count * inputs).min(dx.len()));
            tasks.push((chart, first, count, head));
            dx = tail;
        }
    }
    let partial: Vec<(usize, Vec<f32>)> = tasks
        .into_par_iter()
        .map(|(chart, first, count, dx)| {
            let at = (chart * points + first) * outputs;
            let range = at..at + count * outputs;
            let mut scaled = Vec::new();
            let dz = if slope.is_empty() {
                &gradient[range]
            } else {
                scaled
                    .extend(gradient[range.clone()].iter().zip(&slope[range]).map(|(g, s)| g * s));
                &scaled[..]
            };
            let dz_matrix = MatRef::from_row_major_slice(dz, count, outputs);
            if input_wanted {
                let w = chart_matrix(w, chart, inputs, outputs);
                let dx = MatMut::from_row_major_slice_mut(dx, count, inputs);
                matmul(dx, Accum::Replace, dz_matrix, w.transpose(), 1.0, Par::Seq);
            }
            // One buffer for both: the weight's rows, then the bias.
            let mut sum = vec![0.0; (inputs + 1) * outputs];
            let (dw, db) = sum.split_at_mut(inputs * outputs);
            let from = (chart * points + first) * inputs;
            let x = MatRef::from_row_major_slice(&x[from..from + count * inputs], count, inputs);
            let dw = MatMut::from_row_major_slice_mut(dw, inputs, outputs);
            matmul(dw, Accum::Replace, x.transpose(), dz_matrix, 1.0, Par::Seq);
            dz.chunks_exact(outputs).for_each(|row| add(db, row));
            (chart, sum)
        })
        .collect();

    let mut w_gradient = vec![0.0; charts * inputs * outputs];
    let mut b_gradient = vec![0.0; charts * outputs];
    for (chart, sum) in partial {
        let (dw, db) = sum.split_at(inputs * outputs);
        add(&mut w_gradient[chart * inputs * outputs..][..inputs * outputs], dw);
        add(&mut b_gradient[chart * outputs..][..outputs], db);
    }
    Backward { x: x_gradient, w: w_gradient, b: b_gradient }
}

#[inline(always)]
fn add(sum: &mut [f32], term: &[f32]) {
    for (sum, term) in sum.iter_mut().zip(term) {
        *sum += term;
    }
}

fn chart_matrix(w: &[f32], chart: usize, rows: usize, columns: usize) -> MatRef<'_, f32> {
    let size = rows * columns;
    MatRef::from_row_major_slice(&w[chart * size..(chart + 1) * size], rows, columns)
}

/// The position encoding γ of each channel x: x itself, then sin and cos of 2ᵏπx for k < `octaves`,
/// by the double-angle formulas. A row is `[x…, sin₀…, cos₀…, sin₁…, cos₁…, …]`.
pub(super) fn encode(x: &[f32], channels: usize, octaves: usize) -> Vec<f32> {
    let width = channels * (1 + 2 * octaves);
    let mut y = vec![0.0; x.len() / channels * width];
    let rows = y.par_chunks_mut(width * BLOCK).zip(x.par_chunks(channels * BLOCK));
    rows.for_each(|(y, x)| {
        for (y, x) in y.chunks_exact_mut(width).zip(x.chunks_exact(channels)) {
            y[..channels].copy_from_slice(x);
            for (i, x) in x.iter().enumerate() {
                let (mut sin, mut cos) = (x * std::f32::consts::PI).sin_cos();
                for k in 0..octaves {
                    y[(1 + 2 * k) * channels + i] = sin;
                    y[(2 + 2 * k) * channels + i] = cos;
                    (sin, cos) = (2.0 * sin * cos, 1.0 - 2.0 * sin * sin);
                }
            }
        }
    });
    y
}

/// Gradient of [`encode`] with respect to x, from its result and the gradient of that.
pub(super) fn encode_backward(
    encoded: &[f32],
    gradient: &[f32],
    channels: usize,
    octaves: usize,
) -> Vec<f32> {
    let width = channels * (1 + 2 * octaves);
    let mut dx = vec![0.0; encoded.len() / width * channels];
    for ((dx, y), g) in dx
        .chunks_exact_mut(channels)
        .zip(encoded.chunks_exact(width))
        .zip(gradient.chunks_exact(width))
    {
        for (i, dx) in dx.iter_mut().enumerate() {
            *dx = g[i];
            let mut frequency = std::f32::consts::PI;
            for k in 0..octaves {
                let (sin, cos) = ((1 + 2 * k) * channels + i, (2 + 2 * k) * channels + i);
                *dx += frequency * (y[cos] * g[sin] - y[sin] * g[cos]);
                frequency *= 2.0;
            }
        }
    }
    dx
}
