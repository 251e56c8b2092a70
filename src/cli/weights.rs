//! Which weights the segmentation network has.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::ValueEnum;

use crate::segmentation::point_mae::ModelSize;
use crate::segmentation::use_weights;

/// Weights in place of those that ship.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct Weights {
    /// Weights of the segmentation network, as safetensors; those that ship if absent.
    #[arg(long, value_name = "FILE", env = "UVSEGNET_WEIGHTS")]
    pub weights: Option<PathBuf>,
    /// Which network the weights are of.
    #[arg(long, value_enum, default_value = "small", env = "UVSEGNET_WEIGHTS_SIZE")]
    pub weights_size: ModelSize,
}

impl Weights {
    /// The same, for another process.
    pub fn flags(&self) -> Vec<OsString> {
        let Some(file) = &self.weights else { return Vec::new() };
        let size = self.weights_size.to_possible_value();
        let size = size.map_or("small".to_owned(), |v| v.get_name().to_owned());
        vec!["--weights".into(), file.into(), "--weights-size".into(), size.into()]
    }

    /// Use them in this process.
    pub fn apply(&self) {
        if let Some(file) = &self.weights {
            use_weights(file.clone(), self.weights_size);
        }
    }
}
