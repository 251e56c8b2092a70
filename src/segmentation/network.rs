//! The network that ships, or another that was asked for, loaded once a process and device.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::error::SegmentationError;
use super::point_mae::{Loaded, ModelSize, PointMae, PointMaeConfig, from_bytes, load};
use super::regions::Judge;
use crate::device::Device;

/// The weights that ship; weights/README.md is their model card.
static SHIPPED: &[u8] = include_bytes!("../../weights/uvsegnet-small.safetensors");

/// Weights that were asked for instead, with their size.
static ASKED: OnceLock<(PathBuf, ModelSize)> = OnceLock::new();

/// A network ready to be asked.
#[derive(Debug, Clone)]
pub struct Network {
    /// The network.
    pub model: PointMae,
    /// Its sizes.
    pub config: PointMaeConfig,
    /// Its judge of pairs of regions.
    pub judge: Judge,
    /// Where it runs.
    pub device: Device,
}

impl Network {
    /// A network of these weights.
    pub fn new(model: PointMae, config: PointMaeConfig, device: &Device) -> Self {
        let judge = Judge::new(&model.pairs);
        Self { model, config, judge, device: device.clone() }
    }

    /// The weights of a file.
    pub fn read(
        file: &std::path::Path,
        size: ModelSize,
        device: &Device,
    ) -> Result<Self, SegmentationError> {
        let config = size.config();
        let mut model = PointMae::new(&config, 0, &device.burn());
        match load(&mut model, &config, file)? {
            Loaded::Whole => Ok(Self::new(model, config, device)),
            _ => Err(SegmentationError::Untrained(file.display().to_string())),
        }
    }
}

/// Use the weights of a file in this process instead of those that ship. Only the first call counts,
/// and it must come before any segmentation.
pub fn use_weights(file: PathBuf, size: ModelSize) {
    let _ = ASKED.set((file, size));
}

/// The network of this process on a device.
pub fn network(device: &Device) -> Result<Arc<Network>, SegmentationError> {
    static LOADED: OnceLock<Mutex<HashMap<String, Arc<Network>>>> = OnceLock::new();
    let loaded = LOADED.get_or_init(Mutex::default);
    let mut loaded = loaded.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(network) = loaded.get(&device.name()) {
        return Ok(network.clone());
    }
    let network = Arc::new(match ASKED.get() {
        Some((file, size)) => Network::read(file, *size, device)?,
        None => {
            let size = ModelSize::Small;
            let model = from_bytes(SHIPPED.to_vec(), size, &device.burn())?;
            Network::new(model, size.config(), device)
        }
    });
    loaded.insert(device.name(), network.clone());
    Ok(network)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sha2::{Digest, Sha256};

    #[test]
    fn the_card_tells_the_weights_checksum_and_they_are_small() {
        let card = include_str!("../../weights/README.md");
        let digest: String = Sha256::digest(SHIPPED).iter().map(|b| format!("{b:02x}")).collect();
        assert!(card.contains(&digest), "the checksum is {digest}");
        assert!(SHIPPED.len() < 12_000_000, "{} bytes", SHIPPED.len());
    }

    #[test]
    fn what_ships_is_whole() {
        let network = network(&Device::cpu()).unwrap();
        let again = self::network(&Device::cpu()).unwrap();
        assert!(Arc::ptr_eq(&network, &again), "loaded once");
        assert!(network.judge.is_trained());
    }
}
