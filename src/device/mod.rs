//! Where the networks run: the name of a device, the choice among what is there, the probe that a
//! device must pass before anything is promised on it, the fused layers (`dense`), and seeded random
//! numbers, which do not come from a device so that a result depends on the seed alone.

mod choice;
pub mod dense;
#[cfg(feature = "gpu")]
mod gpu;
mod probe;
mod seeded;
mod select;

pub use choice::{DeviceChoice, DeviceChoiceError};
pub use probe::{Probe, probe};
pub use seeded::{Seeded, uniform};
pub use select::{available, choose};

/// What went wrong with a device.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DeviceError {
    /// A GPU was asked of a program that has no code for one.
    #[error(
        "this program was built without GPU support: build it with `cargo build --release \
         --features gpu`, or choose the device `cpu`"
    )]
    NotBuilt,
    /// There is no GPU of that number.
    #[error("there is no device `{choice}`: {found} found; choose `cpu`, or a number below that")]
    NotFound {
        /// What was asked for.
        choice: DeviceChoice,
        /// How many adapters there are.
        found: usize,
    },
    /// The device is there but does not compute.
    #[error("{device} does not compute: {reason}")]
    Broken {
        /// Its name.
        device: String,
        /// What happened.
        reason: String,
    },
}

/// A device on which networks run.
#[derive(Clone, Debug)]
pub struct Device {
    burn: burn::tensor::Device,
    name: String,
    kind: DeviceKind,
}

/// What a device is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DeviceKind {
    /// The processor, through burn-flex.
    Cpu,
    /// A graphics card, through wgpu.
    Gpu,
    /// The processor again, posing as a graphics card (lavapipe, llvmpipe, SwiftShader, WARP).
    SoftwareGpu,
}

impl Device {
    /// The processor.
    pub fn cpu() -> Self {
        let burn = burn::tensor::Device::flex();
        Self { burn, name: "cpu (burn-flex)".to_owned(), kind: DeviceKind::Cpu }
    }

    /// The processor, treated as a graphics card: for tests of what runs there.
    #[cfg(test)]
    pub fn posing_as_gpu() -> Self {
        Self { kind: DeviceKind::SoftwareGpu, name: "posing".to_owned(), ..Self::cpu() }
    }

    /// The name that stands in `metrics.json`. It does not tell how many threads there are, since a
    /// result does not depend on them.
    pub fn name(&self) -> String {
        self.name.clone()
    }

    /// The name for people: with the number of threads, where it is the processor.
    pub fn description(&self) -> String {
        match self.kind {
            DeviceKind::Cpu => format!("cpu (burn-flex, {} threads)", rayon::current_num_threads()),
            DeviceKind::Gpu => self.name.clone(),
            DeviceKind::SoftwareGpu => format!("{} (software)", self.name),
        }
    }

    /// What it is made of.
    pub fn kind(&self) -> DeviceKind {
        self.kind
    }

    /// burn's handle, without gradients.
    pub fn burn(&self) -> burn::tensor::Device {
        self.burn.clone()
    }

    /// burn's handle, with gradients.
    pub fn autodiff(&self) -> burn::tensor::Device {
        self.burn.clone().autodiff()
    }
}
