//! Images from files.

use crate::errors::{of_file, warn_in_python, wrong};
use crate::images::to_array;
use crate::work::detached;
use gpu_stereo::files::images::{Arrangement, Bits, Split, read_both, read_pair as read_two};
use pyo3::prelude::*;
use std::path::PathBuf;

/// How one picture shows both views, by its name.
const SPLITS: [(&str, Split); 6] = [
    ("sbs", Split::both(Arrangement::SideBySide, false)),
    ("sbs-swapped", Split::both(Arrangement::SideBySide, true)),
    ("tb", Split::both(Arrangement::TopBottom, false)),
    ("tb-swapped", Split::both(Arrangement::TopBottom, true)),
    ("interlaced", Split::both(Arrangement::Interlaced, false)),
    ("interlaced-swapped", Split::both(Arrangement::Interlaced, true)),
];

/// Reads a pair of images: PNG, JPEG, TIFF, PNM, BMP, WebP and others.
///
/// Args:
///     left, right: the files; or one file with both views: MPO, JPS, or a picture with ``split``.
///     split: how one picture shows both: ``"sbs"``, ``"tb"``, ``"interlaced"``, or these with ``"-swapped"``.
///
/// Returns:
///     ``(left, right)``: arrays of one kind, uint8 or uint16, rows x columns or rows x columns x 3, red first. Samples of 9 to 14 bits
///     are brought to 16.
///
/// >>> import gpu_stereo
/// >>> left, right = gpu_stereo.read_pair("data/motorcycle/left.png", "data/motorcycle/right.png")
/// >>> left.shape, left.dtype
/// ((500, 741, 3), dtype('uint8'))
#[pyfunction]
#[pyo3(signature = (left, right=None, split=None))]
pub fn read_pair<'py>(
    py: Python<'py>,
    left: PathBuf,
    right: Option<PathBuf>,
    split: Option<&str>,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    let named = |name: &str| {
        let found = SPLITS.iter().find(|(known, _)| *known == name).map(|(_, split)| *split);
        let names = SPLITS.map(|(name, _)| name).join(", ");
        found.ok_or_else(|| wrong(format!("split is {name:?}, but must be one of {names}")))
    };
    let split = split.map(named).transpose()?;
    let pair = detached(py, || match (&right, split) {
        (Some(_), Some(_)) => Err(None),
        (Some(right), None) => read_two(&left, right, Bits::Auto).map_err(Some),
        (None, split) => read_both(&left, split.unwrap_or(Split::Auto), Bits::Auto).map_err(Some),
    })?;
    let pair = pair.map_err(|error| match error {
        Some(error) => of_file(&error),
        None => {
            wrong("split is for one picture that shows both views, but two are given; drop it, or drop one of them")
        }
    })?;
    pair.doubts.iter().try_for_each(|doubt| warn_in_python(py, doubt))?;
    Ok((to_array(py, &pair.left, 3)?, to_array(py, &pair.right, 3)?))
}
