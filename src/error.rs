//! Everything that can go wrong, each said once: the value given, the values allowed, the remedy.

use std::fmt;

/// Why a pair could not be matched. The variants are what a program can tell apart, and each says what it can do then:
///
/// | variant | what a program can do |
/// |---|---|
/// | [`Parameter`](Error::Parameter), [`Image`](Error::Image), [`Network`](Error::Network) | nothing was done: show the text to whoever gave the value |
/// | [`Misuse`](Error::Misuse) | nothing was done: the program is to be corrected |
/// | [`TooLarge`](Error::TooLarge), [`Memory`](Error::Memory), [`OutOfMemory`](Error::OutOfMemory) | try again with less, or elsewhere |
/// | [`Dropped`](Error::Dropped) | go on: one frame of a stream has no result |
/// | [`Adapter`](Error::Adapter), [`Device`](Error::Device) | try another adapter, or the CPU |
/// | [`Refused`](Error::Refused) | try another adapter, or the CPU: the same work fails again on this one |
/// | [`Lost`](Error::Lost) | drop the device with all that was made on it, and begin with a new one |
///
/// A failed call leaves a matcher or a stream as it was, unless the device is lost.
///
/// ```
/// use gpu_stereo::{Error, Params, reference};
/// # use gpu_stereo::{Image, Pixels};
/// # let (left, right) = (Image::new(1, 1, Pixels::Gray8(vec![0]))?, Image::new(1, 1, Pixels::Gray8(vec![0]))?);
/// match reference::compute(&left, &right, &Params::sgm(4096)) {
///     Ok(map) => println!("{} pixels", map.data.len()),
///     Err(Error::Parameter { name, allowed, .. }) => println!("{name} must be {allowed}"),
///     Err(Error::TooLarge { .. } | Error::Memory { .. } | Error::OutOfMemory) => println!("try fewer disparities"),
///     Err(other) => return Err(other),
/// }
/// # Ok::<(), Error>(())
/// ```
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter lies outside its range, or has no such name. Nothing was done.
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
    /// The two images do not form a pair, or one is not what the matcher was made for; also masks, maps and textures. Nothing was
    /// done.
    #[error("{0}")]
    Image(String),
    /// Weights that are not those of a network, or damaged.
    #[error("{0}")]
    Network(String),
    /// The device cannot hold or run what was asked of it: a limit of one buffer or texture. Found before anything is allocated.
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
    /// The device has no room left for the buffers of a pair: found when they were made.
    #[error("the device ran out of memory; use fewer disparities or smaller images")]
    OutOfMemory,
    /// The device lacks what the kernels need; the message lists everything that is missing.
    #[error(
        "the device lacks what the kernels need: {0}; request it when the device is created, or use another adapter"
    )]
    Device(String),
    /// The device is lost: removed, reset or destroyed, or its driver gave no answer. All that was made on it is of no use any more.
    #[error("the device failed: {0}")]
    Lost(String),
    /// The driver refused valid work, such as to compile a kernel. The device goes on.
    #[error("the device failed: it refused the work: {0}; update its driver, or take another adapter")]
    Refused(String),
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
    /// There is no adapter as asked for, or it cannot be opened.
    #[error("{0}")]
    Adapter(String),
}

impl Error {
    /// The error about a text that is none of the values of a setting.
    pub(crate) fn no_value(name: &'static str, text: &str, allowed: String) -> Self {
        let given = if text.is_empty() { "empty".into() } else { text.escape_debug().to_string() };
        Self::Parameter { name, given, allowed, remedy: "see gpu-stereo --help" }
    }

    /// The same for one of several names.
    pub(crate) fn no_name<'a>(name: &'static str, text: &str, names: impl IntoIterator<Item = &'a str>) -> Self {
        Self::no_value(name, text, format!("one of {}", Vec::from_iter(names).join(", ")))
    }
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
