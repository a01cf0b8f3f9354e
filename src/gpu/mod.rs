//! The chain on a device.

pub(crate) mod chain;
pub(crate) mod check;
pub(crate) mod device;
#[cfg(test)]
pub(crate) mod edits;
pub(crate) mod interop;
pub(crate) mod kernels;
pub(crate) mod layout;
pub(crate) mod map_layout;
pub(crate) mod maps;
pub(crate) mod matcher;
pub(crate) mod plan;
pub(crate) mod readback;
pub(crate) mod reading;
pub(crate) mod recording;
pub(crate) mod rounds;
pub(crate) mod scopes;
pub(crate) mod spans;
pub(crate) mod stream;
pub(crate) mod uploads;
