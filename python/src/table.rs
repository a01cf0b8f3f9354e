//! The table of options, and of adapters.

use crate::errors::{argument, raised, warn};
use crate::work::detached;
use gpu_stereo::backend;
use gpu_stereo::{ParamOption, Params};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// A setting of a matcher.
#[pyclass(name = "Option", module = "gpu_stereo", frozen)]
pub struct PyOption(&'static ParamOption);

#[pymethods]
impl PyOption {
    /// The keyword.
    #[getter]
    fn name(&self) -> String {
        argument(self.0.name)
    }

    /// What it belongs to.
    #[getter]
    fn heading(&self) -> &'static str {
        self.0.heading
    }

    /// The words that are all its values; empty where it takes numbers.
    #[getter]
    fn values(&self) -> Vec<&'static str> {
        self.0.values.iter().map(|(name, _)| *name).collect()
    }

    /// What it takes, in the form ``sgm|bm`` or ``PX|off``.
    #[getter]
    fn allowed(&self) -> String {
        self.0.allowed()
    }

    /// What it does, in a line.
    #[getter]
    fn help(&self) -> &'static str {
        self.0.help
    }

    fn __repr__(&self) -> String {
        format!("<Option: {}={}, {}>", argument(self.0.name), self.0.allowed(), self.0.help)
    }
}

/// Whether it is a keyword of its own, and no option.
fn is_own(option: &ParamOption) -> bool {
    option.name == "disp"
}

/// Every setting that a keyword of :class:`StereoMatcher` changes.
///
/// Returns:
///     A list of :class:`Option`.
///
/// >>> import gpu_stereo
/// >>> [option.allowed for option in gpu_stereo.options() if option.name == "paths"]
/// ['3|4|5|8|16']
#[pyfunction]
pub fn options() -> Vec<PyOption> {
    Params::OPTIONS.iter().filter(|option| !is_own(option)).map(PyOption).collect()
}

/// The values of all settings, by keyword.
pub fn values<'py>(py: Python<'py>, params: &Params) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    Params::OPTIONS.iter().try_for_each(|option| all.set_item(argument(option.name), option.get(params)))?;
    Ok(all)
}

/// An adapter of this machine.
#[pyclass(name = "Adapter", module = "gpu_stereo", frozen, get_all)]
pub struct PyAdapter {
    /// What ``device`` takes for it.
    index: usize,
    /// Its name; ``device`` takes a part of it, too.
    name: String,
    /// The graphics interface.
    backend: String,
    /// The driver's name and version.
    driver: String,
    /// ``"discrete GPU"``, ``"integrated GPU"``, ``"virtual GPU"``, ``"CPU"`` or ``"other"``.
    kind: &'static str,
}

#[pymethods]
impl PyAdapter {
    fn __repr__(&self) -> String {
        let Self { index, name, backend, kind, .. } = self;
        format!("<Adapter {index}: {name}, {kind}, {backend}>")
    }
}

/// The adapters of this machine, the best first: what ``device`` may name.
///
/// Returns:
///     A list of :class:`Adapter`; it is empty where there is no driver. ``device="cpu"`` needs none.
///
/// >>> import gpu_stereo
/// >>> for adapter in gpu_stereo.adapters():
/// ...     assert adapter.name
#[pyfunction]
pub fn adapters(py: Python<'_>) -> PyResult<Vec<PyAdapter>> {
    let mut notes = Vec::new();
    let found = detached(py, || {
        backend::ensure_environment(&mut |note| notes.push(note))?;
        Ok(backend::adapters()?.iter().map(|adapter| adapter.get_info()).collect::<Vec<_>>())
    })?;
    notes.iter().try_for_each(|note| warn(py, note))?;
    let listed = found.map_err(raised)?.into_iter().enumerate().map(|(index, info)| PyAdapter {
        index,
        driver: backend::driver(&info),
        backend: info.backend.to_string(),
        kind: backend::kind(info.device_type),
        name: info.name,
    });
    Ok(listed.collect())
}
