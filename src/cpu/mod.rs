//! The schedule for CPUs: what machines without a GPU compute with. Needs the feature `cpu`.
//!
//! PSMNet by matrix products: the schedule of the network's definition ([`network()`](crate::reference::network())). It computes in
//! f32; docs/NETWORKS.md has the tolerance.

#[allow(dead_code)] // until the matcher takes them
pub(crate) mod aligned;
#[allow(dead_code)]
pub(crate) mod cost;
#[allow(dead_code)]
pub(crate) mod images;
#[allow(dead_code)]
pub(crate) mod instructions;
mod network;

#[allow(unused_imports)]
pub(crate) use aligned::LANES;
pub use network::{compute, compute_timed, disparities};
