//! An image as the chain takes it, in one channel or three.

use crate::reference::images::gray::narrow;
use crate::reference::{Channel, Plane, deep_gray, depth_unit, prefilter, window_sum};
use crate::{ImageView, Params, Prefilter};

/// An image as the chain takes it: luma, or with [`Params::color_cost`] red, green and blue.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Images {
    /// One, or three of one size.
    pub channels: Vec<Plane<u16>>,
    /// How much of a value stands for one of 256 levels.
    pub unit: i32,
    /// Luma of the same unit, never prefiltered, if the cost compares it, too.
    pub gray: Option<Plane<u16>>,
}

/// The images that are prefiltered.
pub fn images<'a>(image: impl Into<ImageView<'a>>, params: &Params) -> Images {
    let image = image.into();
    let channels = match params.color_cost {
        true => [0, 1, 2].map(|sample| deep_gray(image, Channel::Sample(sample))).into(),
        false => vec![deep_gray(image, Channel::Luma)],
    };
    let gray = params.cost.row().beside_gray.then(|| deep_gray(image, Channel::Luma));
    Images { channels, unit: depth_unit(image), gray }
}

impl Images {
    /// All of them prefiltered.
    pub fn prefiltered(&self, params: &Params) -> Self {
        let unit = if params.prefilter == Prefilter::None { self.unit } else { 1 };
        let narrowed = |gray: &Plane<u16>| match unit == self.unit {
            true => gray.clone(),
            false => gray.map(|x, y| narrow(gray.clamped(x, y) as u16).into()),
        };
        let channels = self.channels.iter().map(|image| prefilter(image, self.unit, params)).collect();
        Self { channels, unit, gray: self.gray.as_ref().map(narrowed) }
    }

    /// The sums over windows of `side` x `side` pixels of all of them.
    pub fn window_sums(&self, side: u32) -> Vec<Plane<u32>> {
        self.channels.iter().map(|image| image.map(|x, y| window_sum(image, side, x, y) as u32)).collect()
    }
}
