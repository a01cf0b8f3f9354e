//! PSMNet on the CPU by matrix products: the schedule of the network's definition ([`network()`](crate::reference::network())) for
//! machines without an adapter. It computes in f32; docs/NETWORKS.md has the tolerance.

mod activation;
mod convolutions;
mod images;
mod product;
mod regression;
mod run;
#[cfg(test)]
mod tests;
mod transposed;

pub use run::disparities;
