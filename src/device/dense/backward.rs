//! The fused operations as burn knows them: on burn-flex, and with gradients.

use burn::backend::autodiff::checkpoint::base::Checkpointer;
use burn::backend::autodiff::checkpoint::strategy::CheckpointStrategy;
use burn::backend::autodiff::grads::Gradients;
use burn::backend::autodiff::ops::{Backward, Ops, OpsKind};
use burn::backend::tensor::FloatTensor;
use burn::backend::{Autodiff, Flex, TensorMetadata};
use burn::tensor::TensorData;

use super::kernels::{self, Sizes};
use super::{Activation, FusedLayers, Rows};

type Primitive = FloatTensor<Flex>;

fn sizes(x: &Primitive, w: &Primitive) -> Sizes {
    let (x, w) = (x.shape(), w.shape());
    Sizes { points: x[1], inputs: w[1], outputs: w[2] }
}

fn tensor<const D: usize>(values: Vec<f32>, shape: [usize; D]) -> Primitive {
    Primitive::from_data(TensorData::new(values, shape))
}

/// Value and slope of a dense layer; arguments are contiguous.
fn dense_forward(
    [x, w, b]: [&Primitive; 3],
    rows: &Rows,
    activation: Activation,
    with_slope: bool,
) -> (Primitive, Primitive) {
    let sizes = sizes(x, w);
    let arrays = [x.storage(), w.storage(), b.storage()];
    let (y, slope) = kernels::forward(arrays, sizes, rows, activation, with_slope);
    let count = slope.len();
    (tensor(y, [rows.len(), sizes.points, sizes.outputs]), tensor(slope, [count]))
}

impl FusedLayers for Flex {
    fn dense(x: Primitive, w: Primitive, b: Primitive, rows: Rows, act: Activation) -> Primitive {
        let [x, w, b] = [x, w, b].map(|t| t.to_contiguous());
        dense_forward([&x, &w, &b], &rows, act, false).0
    }

    fn octaves(x: Primitive, count: usize) -> Primitive {
        let x = x.to_contiguous();
        let [charts, points, channels] = x.shape().dims();
        let y = kernels::encode(x.storage(), channels, count);
        tensor(y, [charts, points, channels * (1 + 2 * count)])
    }
}

#[derive(Debug)]
struct DenseBackward;

#[derive(Debug, Clone)]
struct DenseState {
    x: Primitive,
    w: Primitive,
    slope: Primitive,
    rows: Rows,
}

impl Backward<Flex, 3> for DenseBackward {
    type State = DenseState;

    fn backward(self, ops: Ops<DenseState, 3>, grads: &mut Gradients, _: &mut Checkpointer) {
        let gradient = grads.consume::<Flex>(&ops.node).to_contiguous();
        let DenseState { x, w, slope, rows } = ops.state;
        let sizes = sizes(&x, &w);
        let [x_node, w_node, b_node] = ops.parents;
        let arrays = [x.storage(), w.storage(), slope.storage(), gradient.storage()];
        let result = kernels::backward(arrays, sizes, &rows, x_node.is_some());
        let charts = rows.len();
        if let Some(node) = x_node {
            let shape = [charts, sizes.points, sizes.inputs];
            grads.register::<Flex>(node.id, tensor(result.x, shape));
        }
        if let Some(node) = w_node {
            let shape = [charts, sizes.inputs, sizes.outputs];
            grads.register::<Flex>(node.id, tensor(result.w, shape));
        }
        if let Some(node) = b_node {
            grads.register::<Flex>(node.id, tensor(result.b, [charts, 1, sizes.outputs]));
        }
    }
}

#[derive(Debug)]
struct OctavesBackward;

impl Backward<Flex, 1> for OctavesBackward {
    /// What came out, and the number of octaves.
    type State = (Primitive, usize);

    fn backward(self, ops: Ops<Self::State, 1>, grads: &mut Gradients, _: &mut Checkpointer) {
        let gradient = grads.consume::<Flex>(&ops.node).to_contiguous();
        let (encoded, count) = ops.state;
        let [charts, points, width] = encoded.shape().dims();
        let channels = width / (1 + 2 * count);
        if let [Some(node)] = ops.parents {
            let (y, g) = (encoded.storage(), gradient.storage());
            let dx = kernels::encode_backward(y, g, channels, count);
            grads.register::<Flex>(node.id, tensor(dx, [charts, points, channels]));
        }
    }
}

impl<C: CheckpointStrategy> FusedLayers for Autodiff<Flex, C> {
    fn dense(
        x: FloatTensor<Self>,
        w: FloatTensor<Self>,
        b: FloatTensor<Self>,
        rows: Rows,
        activation: Activation,
    ) -> FloatTensor<Self> {
        let nodes = [x.node(), w.node(), b.node()];
        let [x, w, b] = [&x, &w, &b].map(|t| t.primitive().to_contiguous());
        match DenseBackward.prepare::<C>(nodes).compute_bound().stateful() {
            OpsKind::Tracked(prepared) => {
                let (y, slope) = dense_forward([&x, &w, &b], &rows, activation, true);
                prepared.finish(DenseState { x, w, slope, rows }, y)
            }
            OpsKind::UnTracked(prepared) => {
                prepared.finish(dense_forward([&x, &w, &b], &rows, activation, false).0)
            }
        }
    }

    fn octaves(x: FloatTensor<Self>, count: usize) -> FloatTensor<Self> {
        let nodes = [x.node()];
        let encoded = <Flex as FusedLayers>::octaves(x.into_primitive(), count);
        match OctavesBackward.prepare::<C>(nodes).compute_bound().stateful() {
            OpsKind::Tracked(prepared) => prepared.finish((encoded.clone(), count), encoded),
            OpsKind::UnTracked(prepared) => prepared.finish(encoded),
        }
    }
}
