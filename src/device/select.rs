//! From what the user asks for to a device that is there.

use super::{Device, DeviceChoice, DeviceError, DeviceKind, probe};

/// Every device that this program can use: the processor, then graphics cards, then software
/// adapters. `gpu:N` counts from the first entry after the processor.
pub fn available() -> Vec<Device> {
    let mut devices = vec![Device::cpu()];
    devices.extend(adapters());
    devices
}

/// The device for a choice. `auto` takes a graphics card only if it computes; `gpu` does not fall
/// back. Handles are lazy: [`probe`] before a promise is made.
pub fn choose(choice: &DeviceChoice) -> Result<Device, DeviceError> {
    match choice {
        DeviceChoice::Cpu => Ok(Device::cpu()),
        DeviceChoice::Auto => Ok(adapters()
            .into_iter()
            .filter(|device| device.kind() == DeviceKind::Gpu)
            .find(|device| probe(device).is_ok())
            .unwrap_or_else(Device::cpu)),
        DeviceChoice::Gpu(_) if cfg!(not(feature = "gpu")) => Err(DeviceError::NotBuilt),
        DeviceChoice::Gpu(number) => {
            let mut found = adapters();
            let number = number.unwrap_or(0) as usize;
            if number < found.len() {
                Ok(found.swap_remove(number))
            } else {
                Err(DeviceError::NotFound { choice: *choice, found: found.len() })
            }
        }
    }
}

#[cfg(feature = "gpu")]
use super::gpu::adapters;

/// Without the feature `gpu` there is no code for any adapter.
#[cfg(not(feature = "gpu"))]
fn adapters() -> Vec<Device> {
    Vec::new()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_processor_is_always_there() {
        assert_eq!(choose(&DeviceChoice::Cpu).unwrap().kind(), DeviceKind::Cpu);
        assert_eq!(available()[0].kind(), DeviceKind::Cpu);
        assert_eq!(choose(&DeviceChoice::Cpu).unwrap().name(), "cpu (burn-flex)");
    }

    #[test]
    fn auto_never_takes_a_software_adapter() {
        assert_ne!(choose(&DeviceChoice::Auto).unwrap().kind(), DeviceKind::SoftwareGpu);
    }

    #[test]
    fn a_gpu_that_is_not_there_is_said_to_be_so() {
        let error = choose(&DeviceChoice::Gpu(Some(4_000_000))).unwrap_err();
        let text = error.to_string();
        if cfg!(feature = "gpu") {
            assert!(text.contains("gpu:4000000"), "{text}");
        } else {
            assert!(text.contains("--features gpu"), "{text}");
        }
    }
}
