//! The schedule for CPUs: what machines without a GPU compute with. Needs the feature `cpu`.
//!
//! [`CpuMatcher`] gives the bits of the reference ([`mod@crate::reference`]) in a small part of its time. PSMNet is computed by
//! matrix products in f32, a schedule of the network's definition ([`network()`](crate::reference::network())); docs/NETWORKS.md has
//! the tolerance.

pub(crate) mod aligned;
mod chain;
mod check;
pub(crate) mod cost;
mod features;
mod filters;
pub(crate) mod images;
pub(crate) mod instructions;
mod matcher;
mod network;
pub(crate) mod paths;
pub(crate) mod winner;

pub(crate) use aligned::LANES;
pub use chain::has_own_stages;
pub use matcher::CpuMatcher;
pub use network::disparities;
