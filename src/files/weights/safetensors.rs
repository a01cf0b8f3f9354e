//! The format .safetensors: a header in JSON, then the numbers of all tensors.

use super::values::{Budget, Element, Found, Given, View};
use crate::files::error::{Result, ensure, error};
use crate::network::Tensors;
use ::safetensors::tensor::{Dtype, SafeTensors, TensorView};

/// Digits of a number in the header: places in a file have fewer, and the library would add up larger ones beyond 64 bits.
const MAX_DIGITS: usize = 19;

/// Whether a file begins as one: with the length of a header, which is an object.
pub(super) fn is_one(bytes: &[u8]) -> bool {
    let Some((length, rest)) = bytes.split_first_chunk::<8>() else { return false };
    rest.first() == Some(&b'{') && u64::from_le_bytes(*length) <= rest.len() as u64
}

fn element(kind: Dtype) -> Option<Element> {
    Some(match kind {
        Dtype::F64 => Element::F64,
        Dtype::F32 => Element::F32,
        Dtype::F16 => Element::F16,
        Dtype::BF16 => Element::Bf16,
        Dtype::I64 => Element::I64,
        Dtype::I32 => Element::I32,
        Dtype::I16 => Element::I16,
        Dtype::I8 => Element::I8,
        Dtype::U8 => Element::U8,
        Dtype::BOOL => Element::Bool,
        _ => return None,
    })
}

/// A file, of which the header was checked.
pub(super) fn opened(bytes: &[u8]) -> Result<SafeTensors<'_>> {
    let header = bytes.split_first_chunk::<8>().map(|(length, rest)| {
        &rest[..usize::try_from(u64::from_le_bytes(*length)).unwrap_or(usize::MAX).min(rest.len())]
    });
    let digits = header.unwrap_or_default().split(|byte| !byte.is_ascii_digit()).map(<[u8]>::len).max();
    ensure!(
        digits.is_none_or(|digits| digits <= MAX_DIGITS),
        "its header has a number of more than {MAX_DIGITS} digits; save it again"
    );
    SafeTensors::deserialize(bytes).map_err(|error| {
        let told: String = error.to_string().chars().take(200).collect();
        error!("it is damaged or cut short ({told}); save or download it again")
    })
}

/// The tensors of a file.
pub(super) fn parse(bytes: &[u8]) -> Result<Vec<Given>> {
    let file = opened(bytes)?;
    let mut budget = Budget::of(bytes);
    let mut all = Vec::new();
    for (name, tensor) in file.iter() {
        let mut read = || {
            let element = element(tensor.dtype()).ok_or_else(|| {
                error!("it is of type {}, but floats or whole numbers are needed; convert it to F32", tensor.dtype())
            })?;
            let shape = tensor.shape();
            let mut strides = vec![1; shape.len()];
            for axis in (1..shape.len()).rev() {
                strides[axis - 1] = strides[axis] * shape[axis].max(1);
            }
            let view = View { element, storage: tensor.data(), offset: 0, shape, strides: &strides };
            Ok(Found { element, shape: shape.to_vec(), values: view.values(&mut budget)? })
        };
        all.push(Given::new(name, read())?);
    }
    Ok(all)
}

/// The contents of a file with these tensors, as 32-bit floats.
///
/// # Errors
/// If their names are too long for a header.
pub fn encode(tensors: &Tensors) -> Result<Vec<u8>> {
    let bytes: Vec<Vec<u8>> =
        tensors.values().map(|t| t.data().iter().flat_map(|v| v.to_le_bytes()).collect()).collect();
    let views = tensors
        .iter()
        .zip(&bytes)
        .map(|((name, tensor), bytes)| Ok((name, TensorView::new(Dtype::F32, tensor.shape().to_vec(), bytes)?)));
    let views = views.collect::<Result<Vec<_>, ::safetensors::SafeTensorError>>();
    let encoded = views.and_then(|views| ::safetensors::serialize(views, None));
    encoded.map_err(|error| error!("the weights cannot be written as .safetensors ({error}); give others"))
}
