//! Arrays of numbers with names.

use std::collections::BTreeMap;
use std::fmt;

use crate::Error;

/// Tensors by their names, such as `module.dres0.0.0.weight`.
pub type Tensors = BTreeMap<String, Tensor>;

/// An array of any number of dimensions. The last index runs fastest.
#[derive(Clone, PartialEq)]
pub struct Tensor {
    shape: Vec<usize>,
    data: Vec<f32>,
}

impl fmt::Debug for Tensor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Tensor").field("shape", &self.shape).finish_non_exhaustive()
    }
}

impl Tensor {
    /// Of this shape; without dimensions it is one number.
    ///
    /// # Errors
    /// [`Error::Network`] if the shape holds another number of values.
    pub fn new(shape: Vec<usize>, data: Vec<f32>) -> Result<Self, Error> {
        let values = shape.iter().try_fold(1_usize, |product, &side| product.checked_mul(side));
        if values != Some(data.len()) {
            return Err(Error::Network(format!(
                "a tensor of shape {shape:?} was given {} values; give as many as the shape holds",
                data.len()
            )));
        }
        Ok(Self { shape, data })
    }

    /// The number of values along each dimension.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// The values.
    pub fn data(&self) -> &[f32] {
        &self.data
    }
}
