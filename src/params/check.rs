//! How a range is checked.

use crate::Error;
use crate::params::Params;

/// The largest difference between two disparities, in pixels.
pub(super) const MAX_DIFFERENCE: u32 = 2 * Params::MAX_ABS_DISPARITY as u32 + 1;

/// An error unless a setting is `ok`.
pub(super) fn check(
    ok: bool,
    name: &'static str,
    given: impl ToString,
    allowed: impl Into<String>,
    remedy: &'static str,
) -> Result<(), Error> {
    if ok { Ok(()) } else { Err(Error::Parameter { name, given: given.to_string(), allowed: allowed.into(), remedy }) }
}

/// The names among `values`.
pub(super) fn joined(values: &[(&str, &str)], between: &str) -> String {
    values.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(between)
}
