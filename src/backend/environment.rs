//! Environment variables about adapters. Invalid values are refused, since wgpu would ignore them silently.

use std::env;
use std::path::Path;

use wgpu::{Backends, GlFenceBehavior, InstanceDescriptor};

use crate::Error;

const BACKEND: &str = "WGPU_BACKEND";

/// The backends that `WGPU_BACKEND` can name, by the names that wgpu knows them by.
const BACKENDS: [(&[&str], Backends); 4] = [
    (&["vulkan", "vk"], Backends::VULKAN),
    (&["metal", "mtl"], Backends::METAL),
    (&["dx12", "d3d12"], Backends::DX12),
    (&["gl", "gles", "opengl"], Backends::GL),
];

/// Other variables that wgpu reads, and their valid values, in upper or lower case.
const CHOICES: [(&str, &[&str]); 5] = [
    ("WGPU_GLES_MINOR_VERSION", &["automatic", "0", "1", "2"]),
    ("WGPU_GL_DEBUG_FNS", &["auto", "enabled", "forceenabled", "force_enabled", "disabled"]),
    ("WGPU_DX12_COMPILER", &["fxc", "dxc", "dynamicdxc", "staticdxc"]),
    ("WGPU_DX12_PRESENTATION_SYSTEM", &["hwnd", "dxgifromhwnd", "visual", "dxgifromvisual"]),
    ("WGPU_DX12_AGILITY_SDK_REQUIRE", &["0", "1"]),
];

/// Variables that wgpu programs often read, but this one does not.
const UNREAD: [&str; 2] = ["WGPU_ADAPTER_NAME", "WGPU_POWER_PREF"];

/// Where the Vulkan loader looks for drivers: lists of files and folders.
const DRIVERS: [&str; 2] = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"];

/// Which of these drivers the loader uses.
const FILTERS: [&str; 2] = ["VK_LOADER_DRIVERS_SELECT", "VK_LOADER_DRIVERS_DISABLE"];

/// Refuses invalid values of the variables that wgpu reads, and passes variables that have no effect to `note`, a sentence each.
///
/// # Errors
/// [`Error::Adapter`] with the variable, its value and those that are allowed.
pub fn ensure_known(note: &mut dyn FnMut(String)) -> Result<(), Error> {
    backends(env::var_os(BACKEND).as_deref())?;
    for (variable, allowed) in CHOICES {
        let Some(value) = env::var_os(variable) else { continue };
        if !value.to_str().is_some_and(|value| allowed.contains(&value.to_lowercase().as_str())) {
            return Err(Error::Adapter(format!(
                "the environment has {variable}={value:?}, but must have one of {}; correct or unset it",
                allowed.join(", ")
            )));
        }
    }
    for variable in UNREAD {
        if let Some(value) = env::var_os(variable) {
            note(format!(
                "the environment has {variable}={value:?}, which has no effect here; choose an adapter by name"
            ));
        }
    }
    Ok(())
}

/// The backends that a value of `WGPU_BACKEND` names; `None` if it is unset or empty.
fn backends(value: Option<&std::ffi::OsStr>) -> Result<Option<Backends>, Error> {
    let Some(value) = value.filter(|value| !value.is_empty()) else { return Ok(None) };
    let known: Vec<_> = BACKENDS.iter().map(|(names, _)| names[0]).collect();
    let unknown = || {
        Error::Adapter(format!(
            "the environment has {BACKEND}={value:?}, but must have one or several, with commas between them, of {}; correct or \
             unset it",
            known.join(", ")
        ))
    };
    let text = value.to_str().ok_or_else(unknown)?.to_lowercase();
    let mut all = Backends::empty();
    for word in text.split(',').map(str::trim).filter(|word| !word.is_empty()) {
        let found = BACKENDS.iter().find(|(names, _)| names.contains(&word));
        all |= found.ok_or_else(unknown)?.1;
    }
    if all.is_empty() {
        return Err(unknown());
    }
    let here = wgpu::Instance::enabled_backend_features();
    if !here.intersects(all) {
        let here = BACKENDS.iter().filter(|(_, backend)| here.contains(*backend)).map(|(names, _)| names[0]);
        let here = here.collect::<Vec<_>>().join(", ");
        return Err(Error::Adapter(format!(
            "the environment has {BACKEND}={value:?}, but here are only {here}; use one of these, or unset it"
        )));
    }
    Ok(Some(all))
}

/// The descriptor of the wgpu instance.
pub(super) fn descriptor() -> Result<InstanceDescriptor, Error> {
    let mut descriptor = InstanceDescriptor::new_without_display_handle().with_env();
    // OpenGL only on request: it would list most adapters a second time, with smaller limits.
    descriptor.backends = backends(env::var_os(BACKEND).as_deref())?.unwrap_or(Backends::PRIMARY);
    // These would return maps that were never computed.
    descriptor.backend_options.noop.enable = false;
    descriptor.backend_options.gl.fence_behavior = GlFenceBehavior::Normal;
    Ok(descriptor)
}

/// The variables that may be the reason why there is no adapter, for the end of a sentence; empty if none is set.
pub fn why_none() -> String {
    let mut told = Vec::new();
    for variable in [BACKEND].into_iter().chain(FILTERS) {
        if let Some(value) = env::var_os(variable).filter(|value| !value.is_empty()) {
            told.push(format!("{variable}={value:?}"));
        }
    }
    for variable in DRIVERS {
        let Some(value) = env::var_os(variable) else { continue };
        let missing = env::split_paths(&value).all(|path| !Path::new(&path).exists());
        let note = if missing { ", where no file is" } else { "" };
        told.push(format!("{variable}={value:?}{note}"));
    }
    match told[..] {
        [] => String::new(),
        _ => format!(" (the environment has {})", told.join(" and ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn backends_are_those_that_wgpu_names() {
        let of = |value: &str| backends(Some(value.as_ref()));
        assert!(backends(None).unwrap().is_none() && of("").unwrap().is_none());
        let here = wgpu::Instance::enabled_backend_features();
        for (names, backend) in BACKENDS {
            for name in names {
                assert_eq!(Backends::from_comma_list(name), backend, "{name}");
                match here.contains(backend) {
                    true => assert_eq!(of(&format!(" {}, ", name.to_uppercase())).unwrap(), Some(backend)),
                    false => assert!(of(name).unwrap_err().to_string().contains("here are only")),
                }
            }
        }
        for wrong in ["vulcan", "noop", "webgpu", "vulkan;gl", ",", "vulkan,x", "\u{1b}[2J"] {
            let error = of(wrong).unwrap_err().to_string();
            let shown = format!("WGPU_BACKEND={wrong:?}");
            assert!(error.contains(&shown) && error.contains("vulkan, metal, dx12, gl; correct"), "{error}");
        }
    }
}
