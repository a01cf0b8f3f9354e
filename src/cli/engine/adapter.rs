//! Adapters: listing and ranking them, choosing one, and opening a device on it.

use super::environment;
pub use super::environment::{ensure_known as ensure_known_environment, why_none};
use crate::args::{Backend, DeviceArgs};
use crate::terminal::plain;
use anyhow::{Result, bail, ensure};
use gpu_stereo::wgpu::{self, AdapterInfo, DeviceType};
use gpu_stereo::{Error, StereoMatcher};
use std::sync::{Arc, Mutex, PoisonError};

/// Starts the program anew with Mesa's device-select layer off if that layer would write "error: XDG_RUNTIME_DIR is
/// invalid" on stderr: without a desktop session it does so on every enumeration (seen with Mesa 22.3), among this
/// command's own messages. The layer only reorders devices, which [`ranked`] does itself; whoever configures the layer keeps it.
pub fn quiet_drivers() {
    #[cfg(target_os = "linux")]
    {
        use std::env;
        use std::os::unix::process::CommandExt as _;
        let is_set = |name| env::var_os(name).is_some();
        if is_set("XDG_RUNTIME_DIR") || is_set("NODEVICE_SELECT") || is_set("MESA_VK_DEVICE_SELECT") {
            return;
        }
        if let Ok(program) = env::current_exe() {
            let mut again = std::process::Command::new(program);
            // Returns only if it fails; then the noise is accepted.
            let _ = again.args(env::args_os().skip(1)).env("NODEVICE_SELECT", "1").exec();
        }
    }
}

/// All adapters, the best first.
pub fn ranked() -> Result<Vec<wgpu::Adapter>> {
    let descriptor = environment::descriptor()?;
    let backends = descriptor.backends;
    let instance = wgpu::Instance::new(descriptor);
    let mut adapters = pollster::block_on(instance.enumerate_adapters(backends));
    adapters.sort_by_key(|adapter| rank(adapter.get_info().device_type)); // stable: the driver's order within a kind
    Ok(adapters)
}

fn rank(kind: DeviceType) -> u8 {
    match kind {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    }
}

/// The name of a kind of adapter.
pub fn kind(kind: DeviceType) -> &'static str {
    match kind {
        DeviceType::DiscreteGpu => "discrete GPU",
        DeviceType::IntegratedGpu => "integrated GPU",
        DeviceType::VirtualGpu => "virtual GPU",
        DeviceType::Other => "other",
        DeviceType::Cpu => "CPU",
    }
}

/// The driver's name and version.
pub fn driver(info: &AdapterInfo) -> String {
    format!("{} {}", info.driver, info.driver_info).trim().to_owned()
}

/// The index of the adapter that `wanted` names: by index, else by a part of its name, ignoring case. A number that is not an
/// index must be a whole word of the name, such as 3090: "2" does not match "256 bits".
pub fn choose(names: &[String], wanted: &str) -> Result<usize> {
    let wanted_lower = wanted.to_lowercase();
    let by_index = wanted.parse().ok().filter(|&index: &usize| index < names.len());
    let is_number = wanted.bytes().all(|b| b.is_ascii_digit() || b == b'-'); // the empty text, too
    let is_meant = |name: &String| {
        let name = name.to_lowercase();
        match is_number {
            true => name.split(|c: char| !c.is_alphanumeric()).any(|word| !word.is_empty() && word == wanted_lower),
            false => name.contains(&wanted_lower),
        }
    };
    let by_name = || names.iter().position(is_meant);
    if let Some(index) = by_index.or_else(by_name) {
        return Ok(index);
    }
    if names.is_empty() {
        let why = environment::why_none();
        bail!("--adapter is {wanted:?}, but there is no adapter{why}; install a Vulkan driver, or use --backend cpu");
    }
    let known: Vec<_> = names.iter().enumerate().map(|(index, name)| format!("{index} ({})", plain(name))).collect();
    bail!("--adapter is {wanted:?}, but the adapters are {}; give one of these, by index or name", known.join(", "))
}

/// Checks that --adapter and --backend do not contradict each other and that the environment variables about adapters are valid.
pub fn ensure_consistent(device: &DeviceArgs) -> Result<()> {
    if device.backend.takes_adapters() {
        environment::ensure_known()?;
    }
    match &device.adapter {
        Some(adapter) if !device.backend.takes_adapters() => {
            let backend = device.backend.name();
            bail!("--adapter is {adapter:?}, but --backend {backend} uses none; drop one of the two")
        }
        _ => Ok(()),
    }
}

/// Checks that the adapter asked for exists, before long work begins.
pub fn ensure_there(device: &DeviceArgs) -> Result<()> {
    if !device.backend.takes_adapters() {
        return Ok(());
    }
    let names: Vec<_> = ranked()?.iter().map(|adapter| adapter.get_info().name).collect();
    if let Some(wanted) = &device.adapter {
        choose(&names, wanted)?;
    }
    ensure!(
        device.backend != Backend::Gpu || !names.is_empty(),
        "--backend is gpu, but there is no adapter{}; install a Vulkan driver, or use auto or cpu",
        environment::why_none()
    );
    Ok(())
}

/// A device, and the errors that it reported outside any call.
#[derive(Debug)]
pub struct Opened {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// The adapter it was opened on.
    pub info: AdapterInfo,
    fault: Arc<Mutex<Option<String>>>,
}

/// Opens a device with the features and limits that the kernels need.
pub fn open(adapter: &wgpu::Adapter) -> Result<Opened, Error> {
    let descriptor = wgpu::DeviceDescriptor {
        label: Some("gpu-stereo"),
        required_features: StereoMatcher::required_features(adapter),
        required_limits: StereoMatcher::required_limits(adapter),
        ..Default::default()
    };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
        .map_err(|error| Error::Adapter(format!("{} cannot be opened: {error}", plain(&adapter.get_info().name))))?;
    let fault = Arc::new(Mutex::new(None));
    let note = |fault: &Arc<Mutex<Option<String>>>| {
        let fault = Arc::clone(fault);
        move |text: String| {
            fault.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(text);
        }
    };
    // Without these handlers wgpu panics.
    let (on_error, on_loss) = (note(&fault), note(&fault));
    device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| on_error(error.to_string())));
    device.set_device_lost_callback(move |reason, text| {
        if reason != wgpu::DeviceLostReason::Destroyed {
            on_loss(text);
        }
    });
    Ok(Opened { device, queue, info: adapter.get_info(), fault })
}

impl Opened {
    /// The first error that the device reported outside any call.
    pub fn fault(&self) -> Result<(), Error> {
        match self.fault.lock().unwrap_or_else(PoisonError::into_inner).take() {
            Some(text) => Err(Error::Lost(format!("{text}; run again, or use another adapter"))),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn adapters_are_chosen_by_index_or_part_of_the_name() {
        let names = ["NVIDIA GeForce RTX 3090".to_owned(), "llvmpipe (LLVM 15.0.6, 256 bits)".to_owned()];
        assert_eq!(choose(&names, "0").unwrap(), 0);
        assert_eq!(choose(&names, "1").unwrap(), 1);
        assert_eq!(choose(&names, "LLVMPipe").unwrap(), 1);
        assert_eq!(choose(&names, "3090").unwrap(), 0); // no such index, but a name
        for wanted in ["2", "-1", "", "voodoo"] {
            let error = choose(&names, wanted).unwrap_err().to_string();
            assert!(error.contains("0 (NVIDIA GeForce RTX 3090), 1 (llvmpipe"), "{error}");
        }
        assert!(choose(&[], "0").unwrap_err().to_string().contains("there is no adapter"));
    }
}
