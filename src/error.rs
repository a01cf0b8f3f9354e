//! Everything that can go wrong, each said once: the value given, the values allowed, the remedy.

use std::fmt;

/// Why a pair could not be matched.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter lies outside its range.
    #[error("{name} is {given}, but must be {allowed}; {remedy}")]
    #[non_exhaustive]
    Parameter {
        /// The parameter's name on the command line and in [`crate::Params`].
        name: &'static str,
        /// The value that was given.
        given: String,
        /// The values that are allowed.
        allowed: String,
        /// What to change.
        remedy: &'static str,
    },
    /// The two images do not form a pair, or one is not what the matcher was made for.
    #[error("{0}")]
    Image(String),
    /// Weights that are not those of a network, or damaged.
    #[error("{0}")]
    Network(String),
    /// The device cannot hold or run what was asked of it.
    #[error("{what} needs {needed} bytes, but the device allows {allowed}; {remedy}")]
    #[non_exhaustive]
    TooLarge {
        /// The thing that does not fit.
        what: String,
        /// Bytes needed.
        needed: u64,
        /// Bytes allowed.
        allowed: u64,
        /// What to change.
        remedy: &'static str,
    },
    /// Less memory is left than a CPU adapter or the CPU reference needs: found before anything is allocated.
    #[error(
        "{what} needs {} of memory, but {left}; use fewer disparities (--disp), crop or scale the images, or allow more memory \
         (with memory-check off it is tried)",
        Mebibytes(*needed)
    )]
    #[non_exhaustive]
    Memory {
        /// The thing that does not fit.
        what: String,
        /// Bytes needed, beyond those in use.
        needed: u64,
        /// What is left, and by which limit.
        left: Left,
    },
    /// The device has no room left for the buffers of a pair.
    #[error("the device ran out of memory; use fewer disparities or smaller images")]
    OutOfMemory,
    /// The device lacks what the kernels need; the message lists everything that is missing.
    #[error(
        "the device lacks what the kernels need: {0}; request it when the device is created, or use another adapter"
    )]
    Device(String),
    /// The device is lost, or refused valid work.
    #[error("the device failed: {0}")]
    Lost(String),
    /// A call that does not fit earlier calls or its arguments.
    #[error("{0}")]
    Misuse(String),
    /// A pair of a stream was dropped, since the allowed number was in flight.
    #[error(
        "the frame was dropped, since {in_flight} frames were in flight; fetch results sooner, or allow more in flight"
    )]
    #[non_exhaustive]
    Dropped {
        /// How many were in flight.
        in_flight: usize,
    },
    /// No adapter answered to the name, index or kind asked for.
    #[error("{0}")]
    Adapter(String),
}

/// The memory that is left to this process, and the limit that it results from ([`crate::memory`]).
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Left {
    /// Bytes.
    pub bytes: u64,
    /// The limit that they result from, such as "the machine" or "the control group /jobs/7".
    pub limit: String,
}

impl fmt::Display for Left {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} leaves {}", self.limit, Mebibytes(self.bytes))
    }
}

/// Bytes in words.
pub(crate) struct Mebibytes(pub(crate) u64);

impl fmt::Display for Mebibytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} MiB", self.0.div_ceil(1 << 20))
    }
}
