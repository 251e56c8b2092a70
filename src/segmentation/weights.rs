//! The weights of the segmentation network: those that ship, or those of a file. They are a value that is
//! handed on with the device; the network they make is laid out once for each device, when first asked for.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use sha2::{Digest, Sha256};

use super::error::SegmentationError;
use super::network::Network;
use super::point_mae::{ModelSize, WeightsError, from_bytes};
use crate::device::Device;

/// The weights that ship; weights/README.md is their model card.
static SHIPPED: &[u8] = include_bytes!("../../weights/uvsegnet-small.safetensors");

/// Their digest, which is not worth the time to be taken in every process.
const SHIPPED_DIGEST: &str =
    "sha256:e1525efc23f0de784630fcfff16d07915a41b40d24667db5d53d2acf7ba97dde";

/// Weights. Cheap to clone; clones share the network.
#[derive(Debug, Clone)]
pub struct Weights(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    /// Where they are; `None` for those that ship.
    file: Option<(PathBuf, ModelSize)>,
    digest: String,
    /// The network on each device, by the device's name.
    laid_out: Mutex<HashMap<String, Arc<Network>>>,
}

impl Weights {
    /// The weights that ship.
    pub fn shipped() -> Self {
        static WEIGHTS: LazyLock<Weights> =
            LazyLock::new(|| Weights::new(None, SHIPPED_DIGEST.to_owned()));
        WEIGHTS.clone()
    }

    /// The weights of a file, which is read whole here and again when they are laid out.
    pub fn read(file: &Path, size: ModelSize) -> Result<Self, SegmentationError> {
        let bytes = std::fs::read(file).map_err(|error| WeightsError::Unreadable {
            file: file.display().to_string(),
            reason: error.to_string(),
        })?;
        Ok(Self::new(Some((file.to_owned(), size)), digest(&bytes)))
    }

    fn new(file: Option<(PathBuf, ModelSize)>, digest: String) -> Self {
        Self(Arc::new(Inner { file, digest, laid_out: Mutex::default() }))
    }

    /// SHA-256 of the file, as `sha256:` and 64 hexadecimal digits: with input, options, version and
    /// device, what a result is a function of.
    pub fn digest(&self) -> &str {
        &self.0.digest
    }

    /// The network of these weights on a device.
    pub fn network(&self, device: &Device) -> Result<Arc<Network>, SegmentationError> {
        let mut laid_out = self.0.laid_out.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(network) = laid_out.get(&device.name()) {
            return Ok(network.clone());
        }
        let network = Arc::new(match &self.0.file {
            Some((file, size)) => Network::read(file, *size, device)?,
            None => {
                let size = ModelSize::Small;
                let model = from_bytes(SHIPPED.to_vec(), size, &device.burn())?;
                Network::new(model, size.config(), device)
            }
        });
        laid_out.insert(device.name(), network.clone());
        Ok(network)
    }
}

fn digest(bytes: &[u8]) -> String {
    let hex: String = Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect();
    format!("sha256:{hex}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_card_tells_the_weights_checksum_and_they_are_small() {
        let card = include_str!("../../weights/README.md");
        let weights = Weights::shipped();
        assert_eq!(weights.digest(), digest(SHIPPED));
        let digest = weights.digest().strip_prefix("sha256:").unwrap();
        assert!(card.contains(digest), "the checksum is {digest}");
        assert!(SHIPPED.len() < 12_000_000, "{} bytes", SHIPPED.len());
    }

    #[test]
    fn what_ships_is_whole() {
        let network = Weights::shipped().network(&Device::cpu()).unwrap();
        let again = Weights::shipped().network(&Device::cpu()).unwrap();
        assert!(Arc::ptr_eq(&network, &again), "laid out once");
        assert!(network.classifier.is_trained());
    }

    #[test]
    fn two_files_are_two_networks_in_one_process() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("same.safetensors");
        std::fs::write(&file, SHIPPED).unwrap();
        let same = Weights::read(&file, ModelSize::Small).unwrap();
        assert_eq!(same.digest(), Weights::shipped().digest());
        std::fs::write(&file, b"no weights").unwrap();
        let other = Weights::read(&file, ModelSize::Small).unwrap();
        assert_ne!(other.digest(), same.digest());
        assert!(other.network(&Device::cpu()).is_err());
        assert!(Weights::shipped().network(&Device::cpu()).is_ok());
        assert!(Weights::read(&folder.path().join("none"), ModelSize::Small).is_err());
    }
}
