//! The schedule for CPUs: what machines without a GPU compute with. Needs the feature `cpu`.
//!
//! [`CpuMatcher`] gives the bits of the reference ([`mod@crate::reference`]) in a small part of its time. PSMNet is computed by
//! matrix products in f32, a schedule of the network's definition ([`network()`](crate::reference::network())); docs/NETWORKS.md has
//! the tolerance.

#[allow(dead_code)] // until all stages are here
pub(crate) mod aligned;
mod chain;
mod check;
#[allow(dead_code)]
pub(crate) mod cost;
mod filters;
pub(crate) mod images;
pub(crate) mod instructions;
mod matcher;
mod network;
#[allow(dead_code, unused_imports)]
pub(crate) mod paths;
#[allow(dead_code, unused_imports)]
pub(crate) mod winner;

pub(crate) use aligned::LANES;
pub use matcher::CpuMatcher;
pub use network::disparities;
