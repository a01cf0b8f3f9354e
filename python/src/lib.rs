//! The Python module: gpu_stereo/__init__.py shows what is in it.

mod cameras;
mod errors;
mod evaluation;
mod files;
mod images;
mod matched;
mod matcher;
mod opencv;
mod pairs;
mod settings;
mod stream;
mod table;
mod work;

/// What gpu_stereo/__init__.py takes its names from.
#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    use crate::cameras::{PyCalibration, PyCamera, read_calibration, rectify};
    #[pymodule_export]
    use crate::evaluation::{PyScores, evaluate, read_disparity};
    #[pymodule_export]
    use crate::files::read_pair;
    #[pymodule_export]
    use crate::matched::PyMatched;
    #[pymodule_export]
    use crate::pairs::{PyStageCheck, PyStereoMatcher, check, match_pair};
    #[pymodule_export]
    use crate::stream::{PyStream, stream};
    #[pymodule_export]
    use crate::table::{PyAdapter, PyOption, adapters, options};

    /// The version of this package.
    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");

    /// What gpu_stereo.cv computes of given maps.
    #[pymodule_init]
    fn of_given_maps(module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        crate::opencv::register(module)
    }
}
