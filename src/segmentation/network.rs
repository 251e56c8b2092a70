//! A network ready to be asked: model, sizes, boundary classifier, and where it runs.

use super::error::SegmentationError;
use super::point_mae::{Loaded, ModelSize, PointMae, PointMaeConfig, load};
use super::regions::BoundaryClassifier;
use crate::device::Device;

/// A network ready to be asked.
#[derive(Debug, Clone)]
pub struct Network {
    /// The network.
    pub model: PointMae,
    /// Its sizes.
    pub config: PointMaeConfig,
    /// Its boundary classifier.
    pub classifier: BoundaryClassifier,
    /// Where it runs.
    pub device: Device,
}

impl Network {
    /// A network of these weights.
    pub fn new(model: PointMae, config: PointMaeConfig, device: &Device) -> Self {
        Self {
            classifier: BoundaryClassifier::new(&model.pairs),
            model,
            config,
            device: device.clone(),
        }
    }

    /// The weights of a file.
    pub fn read(
        file: &std::path::Path,
        size: ModelSize,
        device: &Device,
    ) -> Result<Self, SegmentationError> {
        let config = size.config();
        let mut model = PointMae::blank(&config, &device.burn());
        match load(&mut model, &config, file)? {
            Loaded::Whole => Ok(Self::new(model, config, device)),
            _ => Err(SegmentationError::Untrained(file.display().to_string())),
        }
    }
}
