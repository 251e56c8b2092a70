//! Graphics cards through wgpu: which adapters there are, and which of them are only the processor
//! in disguise.

use std::panic::{AssertUnwindSafe, catch_unwind};

use burn::backend::{CubeDevice, DispatchDevice, WgpuDeviceKind};
use burn::tensor::DeviceType;

use super::{Device, DeviceKind};

/// Words in the names of software adapters, in lower case. Some drivers do not say that they are
/// software in any other way.
const SOFTWARE: [&str; 5] = ["llvmpipe", "lavapipe", "swiftshader", "softpipe", "basic render"];

/// Every wgpu adapter: graphics cards, then software adapters, each in the order of the system.
pub(super) fn adapters() -> Vec<Device> {
    let listed = catch_unwind(|| burn::tensor::Device::enumerate(DeviceType::Wgpu).into_vec());
    let mut devices: Vec<Device> =
        listed.unwrap_or_default().into_iter().filter_map(open).collect();
    devices.sort_by_key(|device| device.kind == DeviceKind::SoftwareGpu);
    devices
}

/// Ask an adapter for its name. One that cannot be opened is left out: drivers panic.
fn open(burn: burn::tensor::Device) -> Option<Device> {
    let identity = catch_unwind(AssertUnwindSafe(|| burn.identity())).ok()?;
    let name = identity.map_or_else(|| format!("{burn:?}"), |identity| identity.name);
    let software_kind = matches!(
        burn.as_dispatch(),
        DispatchDevice::Cube(CubeDevice::Wgpu(wgpu)) if wgpu.kind == WgpuDeviceKind::Cpu
    );
    let lower = name.to_lowercase();
    let software = software_kind || SOFTWARE.iter().any(|word| lower.contains(word));
    let kind = if software { DeviceKind::SoftwareGpu } else { DeviceKind::Gpu };
    Some(Device { burn, name: format!("gpu (wgpu, {name})"), kind })
}
