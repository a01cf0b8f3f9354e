//! What the options about adapters say, judged before any work.

use crate::args::{DeviceArgs, by_option};
use crate::terminal::message;
use anyhow::{Result, bail, ensure};
use gpu_stereo::backend::{self, Backend};

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

/// Checks that --adapter and --backend do not contradict each other and that the environment variables about adapters are valid.
pub fn ensure_consistent(device: &DeviceArgs) -> Result<()> {
    if device.backend.takes_adapters() {
        backend::ensure_environment(&mut |text| message(&format!("note: {text}")))?;
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
    let names: Vec<_> = backend::adapters()?.iter().map(|adapter| adapter.get_info().name).collect();
    if let Some(wanted) = &device.adapter {
        backend::choose(&names, wanted).map_err(by_option)?;
    }
    ensure!(
        device.backend != Backend::Gpu || !names.is_empty(),
        "--backend is gpu, but there is no adapter{}; install a Vulkan driver, or use auto or cpu",
        backend::why_none()
    );
    Ok(())
}
