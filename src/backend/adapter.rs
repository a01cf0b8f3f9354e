//! Adapters: listing and ranking them, choosing one, and opening a device on it.

use std::sync::{Arc, Mutex, PoisonError};

use wgpu::{AdapterInfo, DeviceType};

use crate::backend::environment::{self, why_none};
use crate::gpu::readback::block_on;
use crate::{Error, StereoMatcher};

/// All adapters, the best first.
///
/// # Errors
/// [`Error::Adapter`] if the environment variable `WGPU_BACKEND` names no backend of this machine.
pub fn adapters() -> Result<Vec<wgpu::Adapter>, Error> {
    let descriptor = environment::descriptor()?;
    let backends = descriptor.backends;
    let instance = wgpu::Instance::new(descriptor);
    let mut adapters = block_on(instance.enumerate_adapters(backends));
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
///
/// # Errors
/// [`Error::Parameter`] if it names none.
pub fn choose(names: &[String], wanted: &str) -> Result<usize, Error> {
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
    let known: Vec<_> = names.iter().enumerate().map(|(index, name)| format!("{index} ({name})")).collect();
    let (allowed, remedy) = match names.is_empty() {
        true => (
            format!("an index or a name, and there is no adapter{}", why_none()),
            "install a Vulkan driver, or compute on the CPU",
        ),
        false => (format!("the index or a part of the name of one of {}", known.join(", ")), "give one of these"),
    };
    Err(Error::Parameter { name: "adapter", given: format!("{wanted:?}"), allowed, remedy })
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
///
/// # Errors
/// [`Error::Adapter`] if the driver gives none.
pub fn open(adapter: &wgpu::Adapter) -> Result<Opened, Error> {
    let descriptor = wgpu::DeviceDescriptor {
        label: Some("gpu-stereo"),
        required_features: StereoMatcher::required_features(adapter),
        required_limits: StereoMatcher::required_limits(adapter),
        ..Default::default()
    };
    let (device, queue) = block_on(adapter.request_device(&descriptor))
        .map_err(|error| Error::Adapter(format!("{} cannot be opened: {error}", adapter.get_info().name)))?;
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
    ///
    /// # Errors
    /// [`Error::Lost`] if there is one.
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
