//! The energy of the winners, which is told of every method: so methods can be compared by what they minimise.

use anyhow::Result;
use gpu_stereo::backend::Beforehand;
use gpu_stereo::{Error, Image, Matched, Method, Params, reference};
use serde::Serialize;

use crate::terminal::message;

/// The energy of the winners, and its two parts.
#[derive(Debug, Serialize)]
pub struct EnergyReport {
    data: u64,
    smoothness: u64,
    sum: u64,
}

impl EnergyReport {
    /// That of a matched pair; a network has none, nor has a pair without labels.
    pub fn new(left: &Image, right: &Image, matched: &Matched, params: &Params) -> Result<Option<Self>> {
        let Some(labels) = &matched.labels else { return Ok(None) };
        let before = Beforehand::of(params)?;
        let energy = reference::energy(&*before.image(left, 0)?, &*before.image(right, 1)?, labels, &before.params)?;
        Ok(Some(Self { data: energy.data, smoothness: energy.smoothness, sum: energy.sum() }))
    }

    /// For a person: the sum, and its parts.
    pub fn words(&self) -> String {
        format!("{} (data {}, smoothness {})", self.sum, self.data, self.smoothness)
    }
}

/// Has the labels made that the energy is of, if it is `wanted`.
pub fn want(params: &mut Params, wanted: bool) {
    params.labels = wanted && params.method != Method::Psmnet;
}

/// Opens something with these settings, or without the labels where a binding of the device does not hold them. Returns the
/// settings that it was opened with.
pub fn opened<T>(params: &Params, mut open: impl FnMut(&Params) -> Result<T>) -> Result<(T, Params)> {
    let failure = match open(params) {
        Ok(opened) => return Ok((opened, params.clone())),
        Err(failure) => failure,
    };
    if !params.labels || !matches!(failure.downcast_ref(), Some(Error::TooLarge { .. })) {
        return Err(failure);
    }
    let mut without = params.clone();
    without.labels = false;
    let opened = open(&without)?;
    message("note: the energy is not told, since the device has no room for the labels of so large an image");
    Ok((opened, without))
}
