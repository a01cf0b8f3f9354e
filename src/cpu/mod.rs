//! The schedule for CPUs: what machines without a GPU compute with. Needs the feature `cpu`.
//!
//! PSMNet by matrix products: the schedule of the network's definition ([`network()`](crate::reference::network())). It computes in
//! f32; docs/NETWORKS.md has the tolerance.

mod network;

pub use network::{compute, compute_timed, disparities};
