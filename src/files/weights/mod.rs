//! Weights of networks: tensors by name, from .safetensors and from what `torch.save` writes. The content tells the format,
//! whatever the name says. Nothing of a file is executed.

mod features;
mod file;
mod pickle;
mod safetensors;
#[cfg(test)]
mod tests;
mod torch;
mod values;

pub use file::{Weights, WeightsFormat, fingerprint};
pub use safetensors::encode;
pub use values::Element;
