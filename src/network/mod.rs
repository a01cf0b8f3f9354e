//! PSMNet (Chang and Chen, 2018): its weights, and its structure as one list of operations.
//!
//! [`Network::new`] takes the tensors of a published file by their names, recognises the [`Architecture`], checks every
//! tensor and folds batch normalisation into the convolutions. [`Network::operations`] is the network: a list in the order
//! of computation, which the definition, the device and the check walk alike. [`Padded`] has the sizes. docs/NETWORKS.md
//! describes the layers.

mod architecture;
mod graph;
#[allow(clippy::module_inception)] // the network itself
mod network;
mod tensor;
#[cfg(test)]
mod tests;
#[cfg(test)]
pub(crate) mod tiny;

pub use architecture::{Architecture, Problem};
pub use graph::{Extent, Kind, Operation, Padded, Parameters};
pub use network::{Convolution, Network};
pub use tensor::{Tensor, Tensors};
