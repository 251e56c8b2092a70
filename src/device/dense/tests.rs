//! The fused operations against burn's own, and against finite differences.

use burn::tensor::{Tensor, TensorData};

use super::*;
use crate::device::{Seeded, uniform};

const ROWS: [usize; 3] = [300, 5, 17];
const POINTS: usize = 300;

fn leaf(rng: &mut Seeded, shape: [usize; 3]) -> Tensor<3> {
    let device = Device::cpu().autodiff();
    Tensor::from_data(uniform(rng, shape, 1.0), &device).require_grad()
}

/// Ones in the rows that a chart has, zeros in its padding.
fn mask(rows: &[usize], points: usize) -> Tensor<3> {
    let row = |&n: &usize| (0..points).map(move |i| if i < n { 1.0_f32 } else { 0.0 });
    let values: Vec<f32> = rows.iter().flat_map(row).collect();
    Tensor::from_data(TensorData::new(values, [rows.len(), points, 1]), &Device::cpu().autodiff())
}

fn values<const D: usize>(t: Tensor<D>) -> Vec<f32> {
    t.into_data().try_into_vec().unwrap()
}

fn assert_near(a: &[f32], b: &[f32], tolerance: f32) {
    assert_eq!(a.len(), b.len());
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        assert!((a - b).abs() <= tolerance * (1.0 + b.abs()), "{i}: {a} {b}");
    }
}

/// Value, and gradients with respect to x, w and b, of a weighted sum of a layer.
fn layer(layers: &Layers, activation: Activation) -> Vec<Vec<f32>> {
    let mut rng = Seeded::new(5, 0);
    let x = leaf(&mut rng, [3, POINTS, 6]);
    let w = leaf(&mut rng, [3, 6, 9]);
    let b = leaf(&mut rng, [3, 1, 9]);
    let weights = leaf(&mut rng, [3, POINTS, 9]).detach() * mask(&ROWS, POINTS);
    let y = layers.dense(x.clone(), w.clone(), b.clone(), activation) * weights;
    let mut grads = y.clone().sum().backward();
    let mut all = vec![values(y.inner())];
    all.extend([x, w, b].map(|t| values(t.grad_remove(&mut grads).unwrap())));
    all
}

#[test]
fn dense_is_the_composed_layer() {
    for activation in [Activation::Linear, Activation::Gelu, Activation::Sigmoid, Activation::Relu]
    {
        let fused = layer(&Layers::new(&ROWS, &Device::cpu()), activation);
        let composed = layer(&Layers::composed(&ROWS), activation);
        for (fused, composed) in fused.iter().zip(&composed) {
            assert_near(fused, composed, 2e-5);
        }
    }
}

#[test]
fn dense_without_gradients_is_the_same() {
    let mut rng = Seeded::new(9, 0);
    let [x, w, b] = [[3, POINTS, 6], [3, 6, 9], [3, 1, 9]].map(|shape| leaf(&mut rng, shape));
    let layers = Layers::new(&ROWS, &Device::cpu());
    let tracked = layers.dense(x.clone(), w.clone(), b.clone(), Activation::Gelu);
    let plain = layers.dense(x.inner(), w.inner(), b.inner(), Activation::Gelu);
    assert_eq!(values(tracked.inner()), values(plain));
}

#[test]
fn dense_skips_padding() {
    let layers = Layers::new(&ROWS, &Device::cpu());
    let mut rng = Seeded::new(5, 0);
    let [x, w, b] = [[3, POINTS, 6], [3, 6, 9], [3, 1, 9]].map(|shape| leaf(&mut rng, shape));
    let y = values(layers.dense(x.clone(), w, b, Activation::Sigmoid).inner());
    for (chart, rows) in ROWS.into_iter().enumerate() {
        for point in 0..POINTS {
            let row = &y[(chart * POINTS + point) * 9..][..9];
            assert_eq!(row.iter().all(|v| *v == 0.0), point >= rows);
        }
    }
}

#[test]
fn a_chart_does_not_depend_on_its_batch() {
    let together = layer(&Layers::new(&ROWS, &Device::cpu()), Activation::Gelu);
    let mut rng = Seeded::new(5, 0);
    let [x, w, b] = [[3, POINTS, 6], [3, 6, 9], [3, 1, 9]].map(|shape| leaf(&mut rng, shape));
    let weights = leaf(&mut rng, [3, POINTS, 9]).detach();
    // The third chart alone, without any padding.
    let rows = 17;
    let x = x.inner().slice([2..3, 0..rows, 0..6]).autodiff().require_grad();
    let [w, b] = [w, b].map(|t| t.inner().slice([2..3]).autodiff().require_grad());
    let weights = weights.inner().slice([2..3, 0..rows, 0..9]);
    let alone = Layers::new(&[rows], &Device::cpu());
    let y = alone.dense(x, w.clone(), b.clone(), Activation::Gelu) * weights.autodiff();
    let grads = y.clone().sum().backward();
    assert_eq!(values(y.inner()), together[0][2 * POINTS * 9..][..rows * 9]);
    assert_eq!(values(w.grad(&grads).unwrap()), together[2][2 * 54..]);
    assert_eq!(values(b.grad(&grads).unwrap()), together[3][2 * 9..]);
}

#[test]
fn threads_do_not_matter() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| layer(&Layers::new(&ROWS, &Device::cpu()), Activation::Gelu))
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn octaves_are_the_composed_ones() {
    let run = |layers: Layers| {
        let mut rng = Seeded::new(11, 0);
        let x = leaf(&mut rng, [3, POINTS, 3]);
        let y = layers.octaves(x.clone(), 6);
        let weights = leaf(&mut rng, [3, POINTS, 39]).detach();
        let grads = (y.clone() * weights).sum().backward();
        (values(y.inner()), values(x.grad(&grads).unwrap()))
    };
    let (fused, fused_gradient) = run(Layers::new(&ROWS, &Device::cpu()));
    let (composed, composed_gradient) = run(Layers::composed(&ROWS));
    assert_near(&fused, &composed, 5e-5);
    assert_near(&fused_gradient, &composed_gradient, 2e-3);
}

#[test]
fn gradients_are_finite_differences() {
    let device = Device::cpu();
    let layers = Layers::new(&[4], &device);
    let mut rng = Seeded::new(2, 0);
    let [w, b] = [leaf(&mut rng, [1, 7, 5]), leaf(&mut rng, [1, 1, 5])].map(|t| t.detach());
    let loss = |x: Tensor<3>| {
        let encoded = layers.octaves(x, 3);
        layers.dense(encoded, w.clone(), b.clone(), Activation::Gelu).sum()
    };
    let start = uniform(&mut rng, [1, 4, 1], 0.4).try_into_vec::<f32>().unwrap();
    let at = |values: Vec<f32>| {
        Tensor::<3>::from_data(TensorData::new(values, [1, 4, 1]), &device.autodiff())
    };
    let x = at(start.clone()).require_grad();
    let gradient = values(x.grad(&loss(x.clone()).backward()).unwrap());
    for i in 0..4 {
        let shifted = |h: f32| {
            let mut values = start.clone();
            values[i] += h;
            f64::from(values_of(loss(at(values))))
        };
        let h = 2e-3;
        let want = (shifted(h) - shifted(-h)) / (2.0 * f64::from(h));
        assert!((f64::from(gradient[i]) - want).abs() < 0.02 * (1.0 + want.abs()), "{want}");
    }
}

fn values_of(t: Tensor<1>) -> f32 {
    t.inner().into_scalar()
}
