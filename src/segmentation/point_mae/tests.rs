//! What the network promises: its shapes, that it learns, that a place is read the same wherever it
//! stands in the list, that weights survive a file.

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
    let config = PointMaeConfig { depth: 2, taps: [1, 1, 2], ..ModelSize::Small.config() };
    let device = Device::cpu();
    let model = PointMae::new(&config, 1, &device.burn());
    save(&model, &file, false).unwrap();
    let mut other = PointMae::new(&config, 2, &device.burn());
    assert_eq!(load(&mut other, &config, &file), Ok(Loaded::Whole));
    let (seen, asked) = ([ball(200, 1)], [ball(5, 3)]);
    let read =
        |m: &PointMae| values(m.forward(&config, &seen, &asked, &device, &device.burn()).part);
    assert_eq!(read(&model), read(&other));
    let deeper = PointMaeConfig { depth: 3, ..config };
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
