//! What the network promises: its shapes, that it learns, that a place is read the same wherever it
//! stands in the list, that weights survive a file.

mod checkpoint;

use burn::tensor::Tensor;

use super::*;
use crate::device::{Device, Seeded};

fn ball(count: usize, seed: u64) -> NetworkCloud {
    let mut rng = Seeded::new(seed, 0);
    let mut cloud = NetworkCloud::default();
    while cloud.len() < count {
        let p: [f32; 3] = std::array::from_fn(|_| rng.symmetric(1.0));
        let r = p.iter().map(|x| x * x).sum::<f32>().sqrt();
        if r > 0.1 && r < 1.0 {
            cloud.positions.push(p.map(|x| x / r));
            cloud.normals.push(p.map(|x| x / r));
            cloud.thickness.push(2.0);
        }
    }
    cloud
}

fn values<const D: usize>(t: Tensor<D>) -> Vec<f32> {
    t.into_data().try_into_vec().unwrap()
}

#[test]
fn the_small_network_is_small() {
    let config = ModelSize::Small.config();
    let device = Device::cpu();
    let count = burn::module::Module::num_params(&PointMae::new(&config, 1, &device.burn()));
    assert!((2_600_000..3_100_000).contains(&count), "{count} parameters");
}

#[test]
fn features_have_their_shapes_and_do_not_depend_on_the_order() {
    let config = ModelSize::Small.config();
    let device = Device::cpu();
    let model = PointMae::new(&config, 1, &device.burn());
    let seen = [ball(600, 1), ball(300, 2)];
    let asked = [ball(10, 3), ball(10, 4)];
    let got = model.forward(&config, &seen, &asked, &device, &device.burn());
    assert_eq!(got.part.dims(), [2, 10, config.part]);
    assert_eq!(got.names.dims(), [2, 10, NAMES.len()]);
    let mut turned = asked.clone();
    for cloud in &mut turned {
        cloud.positions.reverse();
        cloud.normals.reverse();
        cloud.thickness.reverse();
    }
    let other = model.forward(&config, &seen, &turned, &device, &device.burn());
    let (a, b) = (values(got.part), values(other.part.flip([1])));
    assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-4));
}

#[test]
fn weights_survive_a_file_and_the_wrong_size_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("w.safetensors");
    let config = PointMaeConfig { depth: 3, taps: [1, 2, 3], ..ModelSize::Small.config() };
    let device = Device::cpu();
    let model = PointMae::new(&config, 1, &device.burn());
    save(&model, &file, false).unwrap();
    let mut other = PointMae::new(&config, 2, &device.burn());
    assert_eq!(load(&mut other, &config, &file), Ok(Loaded::Whole));
    let (seen, asked) = ([ball(200, 1)], [ball(5, 3)]);
    let read =
        |m: &PointMae| values(m.forward(&config, &seen, &asked, &device, &device.burn()).part);
    assert_eq!(read(&model), read(&other));
    let deeper = PointMaeConfig { depth: 4, ..config };
    let mut deeper_model = PointMae::new(&deeper, 1, &device.burn());
    let error = load(&mut deeper_model, &deeper, &file).unwrap_err();
    assert!(matches!(error, WeightsError::Unfit { .. }), "{error}");
    let nothing = load(&mut other, &config, &dir.path().join("none.pth")).unwrap_err();
    assert!(matches!(nothing, WeightsError::Unreadable { .. }), "{nothing}");
}

#[test]
fn the_autoencoder_learns_a_ball() {
    use burn::optim::{AdamWConfig, GradientsParams};
    let config = PointMaeConfig {
        width: 48,
        depth: 1,
        heads: 2,
        groups: 16,
        group_size: 8,
        ..ModelSize::Small.config()
    };
    let device = Device::cpu();
    let tensors = device.autodiff();
    let encoder = PointMae::new(&config, 1, &tensors).encoder;
    let mut model = Autoencoder { encoder, decoder: Decoder::new(&config, 2, &tensors) };
    let mut optimizer = AdamWConfig::new().init();
    let mut losses = Vec::new();
    let mut rng = Seeded::new(3, 0);
    for step in 0..40 {
        let loss = model.loss(&config, &[ball(200, step % 4)], &mut rng, &device, &tensors);
        losses.push(loss.clone().into_scalar::<f32>());
        let gradients = GradientsParams::from_grads(loss.backward(), &model);
        model = optimizer.step(2e-3, model, gradients);
    }
    let (first, last) = (losses[..5].iter().sum::<f32>(), losses[35..].iter().sum::<f32>());
    assert!(last < 0.5 * first, "{first} → {last}");
}

/// The tensors of a published checkpoint of that size, in its names and layouts.
fn published(config: &PointMaeConfig) -> checkpoint::Tensors {
    let (width, [a, b, c]) = (config.width, config.embedding);
    let mut shapes: Vec<(String, Vec<usize>)> = Vec::new();
    let mut add = |name: &str, shape: &[usize]| shapes.push((name.to_owned(), shape.to_vec()));
    let convolutions =
        [("first_conv", [(3, a), (a, b)]), ("second_conv", [(2 * b, c), (c, width)])];
    for (name, [(i, j), (k, l)]) in convolutions {
        let at = |part: &str| format!("MAE_encoder.encoder.{name}.{part}");
        add(&at("0.weight"), &[j, i, 1]);
        add(&at("0.bias"), &[j]);
        for norm in ["weight", "bias", "running_mean", "running_var"] {
            add(&at(&format!("1.{norm}")), &[j]);
        }
        add(&at("3.weight"), &[l, k, 1]);
        add(&at("3.bias"), &[l]);
    }
    for (whose, depth) in [("MAE_encoder.blocks.blocks", config.depth), ("MAE_decoder.blocks", 1)] {
        for i in 0..depth {
            let at = |part: &str| format!("{whose}.{i}.{part}");
            for norm in ["norm1", "norm2"] {
                add(&at(&format!("{norm}.weight")), &[width]);
                add(&at(&format!("{norm}.bias")), &[width]);
            }
            add(&at("attn.qkv.weight"), &[3 * width, width]);
            add(&at("attn.proj.weight"), &[width, width]);
            add(&at("attn.proj.bias"), &[width]);
            add(&at("mlp.fc1.weight"), &[4 * width, width]);
            add(&at("mlp.fc1.bias"), &[4 * width]);
            add(&at("mlp.fc2.weight"), &[width, 4 * width]);
            add(&at("mlp.fc2.bias"), &[width]);
        }
    }
    for (name, shape) in [
        ("MAE_encoder.pos_embed.0.weight", vec![128, 3]),
        ("MAE_encoder.pos_embed.0.bias", vec![128]),
        ("MAE_encoder.pos_embed.2.weight", vec![width, 128]),
        ("MAE_encoder.pos_embed.2.bias", vec![width]),
        ("MAE_encoder.norm.weight", vec![width]),
        ("MAE_encoder.norm.bias", vec![width]),
        ("mask_token", vec![1, 1, width]),
        ("increase_dim.0.weight", vec![96, width, 1]),
    ] {
        add(name, &shape);
    }
    let mut rng = Seeded::new(11, 0);
    let mut filled = |(name, shape): (String, Vec<usize>)| {
        let least = if name.ends_with("running_var") { 1.0 } else { 0.0 };
        let count = shape.iter().product();
        let values = (0..count).map(|_| least + rng.symmetric(0.4)).collect();
        (name, shape, values)
    };
    shapes.into_iter().map(&mut filled).collect()
}

#[test]
fn a_published_checkpoint_is_read_by_its_names() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("pretrain.pth");
    let config = PointMaeConfig {
        width: 24,
        depth: 3,
        heads: 2,
        taps: [1, 2, 3],
        embedding: [8, 12, 16],
        ..ModelSize::Paper.config()
    };
    let tensors = published(&config);
    checkpoint::write(&file, &tensors);
    let device = Device::cpu();
    let mut model = PointMae::new(&config, 1, &device.burn());
    assert_eq!(load(&mut model, &config, &file), Ok(Loaded::EncoderOnly));

    // The first layer by hand, normalised with the running statistics.
    let of = |name: &str| &tensors.iter().find(|t| t.0 == name).unwrap().2;
    let conv = |part: &str| of(&format!("MAE_encoder.encoder.first_conv.{part}"));
    let [x, y, z] = [0.3_f32, -0.2, 0.5];
    let first: Vec<f32> = (0..8)
        .map(|o| {
            let w = &conv("0.weight")[3 * o..3 * o + 3];
            let sum = w[0] * x + w[1] * y + w[2] * z + conv("0.bias")[o];
            let spread = (conv("1.running_var")[o] + 1e-5).sqrt();
            (sum - conv("1.running_mean")[o]) / spread * conv("1.weight")[o] + conv("1.bias")[o]
        })
        .collect();
    let point = Tensor::<2>::from_data([[x, y, z]], &device.burn());
    let (weight, bias) = model.encoder.embedding.first_layer();
    let got = values(point.matmul(weight) + bias.unsqueeze());
    assert!(got.iter().zip(&first).all(|(a, b)| (a - b).abs() < 1e-5), "{got:?} {first:?}");
    // A linear layer of the second block, which PyTorch keeps transposed.
    let down = values(model.encoder.transformer.second_block_down());
    let theirs = of("MAE_encoder.blocks.blocks.1.mlp.fc2.weight");
    for i in 0..96 {
        for o in 0..24 {
            assert_eq!(down[24 * i + o], theirs[96 * o + i]);
        }
    }
    let features = model.forward(&config, &[ball(300, 1)], &[ball(4, 2)], &device, &device.burn());
    assert!(values(features.part).iter().all(|v| v.is_finite()));
}
