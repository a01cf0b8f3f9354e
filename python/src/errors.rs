//! Errors of the library become the exceptions of gpu_stereo/_errors.py, with their texts; doubts become warnings.

use gpu_stereo::{Error, files};
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;

pyo3::import_exception!(gpu_stereo._errors, DeviceError);
pyo3::import_exception!(gpu_stereo._errors, FileError);
pyo3::import_exception!(gpu_stereo._errors, InputError);
pyo3::import_exception!(gpu_stereo._errors, OutOfMemoryError);

/// An error of the library as an exception.
pub fn raised(error: Error) -> PyErr {
    let text = match &error {
        Error::Parameter { name: "option", given, .. } => {
            format!("{} is no keyword; see gpu_stereo.options() for those that are", given.replace('-', "_"))
        }
        // Where to compute is one argument here.
        Error::Parameter { name: "backend" | "adapter", given, allowed, remedy, .. } => {
            format!("device is {given}, but must be {allowed}; {remedy}")
        }
        Error::Parameter { name, given, allowed, remedy, .. } => {
            let remedy = if *remedy == SEE { "see gpu_stereo.options()" } else { remedy };
            format!("{} is {given}, but must be {allowed}; {}", argument(name), in_python(remedy))
        }
        other => in_python(&other.to_string()),
    };
    match error {
        Error::Memory { .. } | Error::OutOfMemory | Error::TooLarge { .. } => OutOfMemoryError::new_err(text),
        Error::Device(_) | Error::Lost(_) | Error::Refused(_) | Error::Adapter(_) => DeviceError::new_err(text),
        _ => InputError::new_err(text),
    }
}

/// Where the library refers to for options.
const SEE: &str = "see gpu-stereo --help";

/// An error of a file as an exception.
pub fn of_file(error: &files::Error) -> PyErr {
    FileError::new_err(in_python(&error.to_string()))
}

/// An exception about an argument.
pub fn wrong(text: impl Into<String>) -> PyErr {
    InputError::new_err(text.into())
}

/// The keyword for an option of the command.
pub fn argument(option: &str) -> String {
    match option {
        "disp" => "disparities".into(),
        other => other.replace('-', "_"),
    }
}

/// A text that names options of the command, with this module's keywords for them: `--calib-scale` is calib_scale.
pub fn in_python(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find("--") {
        let (before, after) = rest.split_at(at);
        let after = &after[2..];
        let end = after.find(|c: char| !(c.is_ascii_lowercase() || c == '-')).unwrap_or(after.len());
        shown += before;
        shown += if end == 0 { "--" } else { "" };
        shown += &argument(after[..end].trim_end_matches('-'));
        rest = &after[end..];
    }
    shown + rest
}

/// A warning of Python's.
pub fn warn(py: Python<'_>, text: &str) -> PyResult<()> {
    let text = std::ffi::CString::new(text.replace('\0', " ")).unwrap_or_default();
    PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text, 1)
}

/// Refuses a number of rows or columns that is none.
pub fn ensure_count(name: &str, count: i64) -> PyResult<u32> {
    u32::try_from(count)
        .ok()
        .filter(|&count| count > 0)
        .ok_or_else(|| raised(Error::Image(format!("{name} is {count}, but must be at least 1"))))
}

/// A text of the library about options, as a warning.
pub fn warn_in_python(py: Python<'_>, text: &str) -> PyResult<()> {
    warn(py, &in_python(text))
}
