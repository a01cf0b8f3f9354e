//! The network in doubles: what each operation of [`crate::Network::operations`] computes, and all of them in order.

mod convolutions;
mod input;
mod operation;
mod pooling;
mod regression;
mod run;
#[cfg(test)]
mod tests;
mod upsampling;
mod values;

pub use convolutions::{conv3d_transposed, convolution, feature_volume};
pub use input::network_input;
pub use operation::operation;
pub use pooling::average_pool;
pub use regression::{disparity_regression, round_disparities};
pub(crate) use run::{Report, stage};
pub use run::{cropped, network};
pub use upsampling::{neighbours, upsample};
pub use values::Values;
