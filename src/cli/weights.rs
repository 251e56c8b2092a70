//! Which weights the segmentation network has, and where it runs.

use std::ffi::OsString;
use std::path::PathBuf;

use anyhow::Result;
use clap::ValueEnum;

use crate::device::{DeviceChoice, choose};
use crate::pipeline::Engine;
use crate::segmentation::Weights;
use crate::segmentation::point_mae::ModelSize;

/// Weights in place of those that ship.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct WeightFlags {
    /// Weights of the segmentation network, as safetensors; those that ship if absent.
    #[arg(long, value_name = "FILE", env = "UVSEGNET_WEIGHTS")]
    pub weights: Option<PathBuf>,
    /// Which network the weights are of.
    #[arg(long, value_enum, default_value = "small", env = "UVSEGNET_WEIGHTS_SIZE")]
    pub weights_size: ModelSize,
}

impl WeightFlags {
    /// The same, for another process.
    pub fn flags(&self) -> Vec<OsString> {
        let Some(file) = &self.weights else { return Vec::new() };
        let size = self.weights_size.to_possible_value();
        let size = size.map_or("small".to_owned(), |v| v.get_name().to_owned());
        vec!["--weights".into(), file.into(), "--weights-size".into(), size.into()]
    }

    /// The weights themselves.
    pub fn weights(&self) -> Result<Weights> {
        Ok(match &self.weights {
            Some(file) => Weights::read(file, self.weights_size)?,
            None => Weights::shipped(),
        })
    }

    /// These weights on a device.
    pub fn engine(&self, device: &DeviceChoice) -> Result<Engine> {
        Ok(Engine { device: choose(device)?, weights: self.weights()? })
    }
}
