//! What computes: the device, and the weights of the networks that run on it.

use crate::device::Device;
use crate::segmentation::Weights;

/// A device and weights: with input, options and version, what a result is a function of. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Engine {
    /// Where networks run and train.
    pub device: Device,
    /// The segmentation network's weights.
    pub weights: Weights,
}

impl Engine {
    /// A device with the weights that ship.
    pub fn new(device: Device) -> Self {
        Self { device, weights: Weights::shipped() }
    }
}
