//! The memory that the reference takes.

use crate::network::{Operation, Padded};
use crate::{Error, Method, Params, memory};

/// About the bytes per pixel and disparity that belief propagation takes: the cost, four messages of each level, data terms of
/// two bytes of the coarse ones, and what half of the pixels send at a time.
const BELIEF_BYTES: u64 = 12;

/// About the bytes per pixel that images, planes and maps take.
const PIXEL_BYTES: u64 = 36;

/// About the bytes per pixel and feature: numbers of two bytes of two layers and of the other side, and descriptors of both.
const FEATURE_BYTES: u64 = 10;

/// Refuses pairs of `size`, columns and rows, for which less memory is left than the reference takes, unless
/// [`Params::memory_check`] is off. Else the system would end the process without a message. `more`: bytes for each pixel and
/// disparity besides; `what` computes, in the words of the error.
///
/// # Errors
/// [`Error::Memory`].
pub fn ensure_memory(what: &str, size: [u32; 2], params: &Params, more: u64) -> Result<(), Error> {
    if !params.memory_check {
        return Ok(());
    }
    // At the peak: column sums of four bytes, and with sgm the costs of one that are made of them; with bp messages; with a
    // network floats of four.
    let each = more
        + match params.method {
            Method::Sgm => 5,
            Method::Bp => BELIEF_BYTES,
            Method::Bm | Method::Psmnet => 4,
        };
    let [width, height] = size.map(u64::from);
    let values = match &params.network {
        Some(network) => Operation::peak(network.operations(), &Padded::new(size[0], size[1], params.disparities)),
        None => (width + u64::from(params.block) - 1) * height * u64::from(params.disparities),
    };
    let features = u64::from(params.feature_planes());
    let what = format!("{what} of {width}x{height} pixels at {} disparities", params.disparities);
    memory::ensure(&what, each * values + (PIXEL_BYTES + FEATURE_BYTES * features) * width * height)
}
