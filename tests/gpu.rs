//! The GPU against the CPU: one small seeded chart is trained on both, and the maps agree. Built with
//! the feature `gpu` only (`tests/run gpu`); software Vulkan will do.
#![cfg(feature = "gpu")]

#[path = "shared/barrel.rs"]
mod barrel;

use barrel::Barrel;
use uvsegnet::contract::{LossForm, Run, Stage};
use uvsegnet::device::{self, Device, DeviceChoice};
use uvsegnet::parameterization::{TrainOptions, train};

#[test]
fn both_devices_train_the_same_map() {
    let gpu = device::choose(&"gpu".parse::<DeviceChoice>().unwrap()).unwrap();
    device::probe(&gpu).unwrap();
    // 12 × 8 vertices.
    let barrel = Barrel::new(11, 7);
    let chart = barrel.chart(1);
    let (form, stage) = (LossForm::Sound, Stage::Train);
    let options = TrainOptions { width: 16, steps: 6, points: 96, seed: 3, form, stage };
    let on = |device: &Device| {
        let mut told = |_: u32, _: u32, _: &[usize]| {};
        train(std::slice::from_ref(&chart), &options, device, &Run::quiet(), &mut told).unwrap()
    };
    let (here, there) = (on(&Device::cpu()), on(&gpu));
    let apart =
        here[0].uv.iter().zip(&there[0].uv).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    assert!(apart < 1e-4, "the maps are {apart} apart on a chart 1.5 across");
    assert!(
        here[0].uv.iter().zip(&barrel.start).any(|(a, b)| a.distance(*b) > 1e-3),
        "nothing was learned"
    );
}
