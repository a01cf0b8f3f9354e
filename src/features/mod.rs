//! The networks that make features, by which the learned costs compare pixels: layers of small integers, and the checks that
//! nothing in them overflows.
//!
//! [`FeatureNetwork::built_in`] is the one that the costs take unless another is given ([`crate::Params::features`]). What the layers
//! compute is said in docs/ALGORITHMS.md under `features`; [`crate::reference::feature_layer`] states it in Rust.

mod built_in;
mod layer;
mod network;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod tiny;

/// Whether features are left out of a program: of one that computes on the CPU alone, with `--cfg gpu_stereo_without_networks`. web/build
/// wants it small. Settings that want them are refused.
pub(crate) const LEFT_OUT: bool = cfg!(all(gpu_stereo_without_networks, not(feature = "gpu")));

pub use layer::{Layer, LayerKind};
pub use network::FeatureNetwork;
#[cfg(test)]
pub(crate) use tiny::tiny;
