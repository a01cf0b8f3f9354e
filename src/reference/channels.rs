//! An image as the chain takes it, in one channel or three.

use crate::reference::{Channel, Plane, deep_gray, depth_unit, prefilter, window_sum};
use crate::{Image, Params, Prefilter};

/// An image as the chain takes it: luma, or with [`Params::color_cost`] red, green and blue.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Images {
    /// One, or three of one size.
    pub channels: Vec<Plane<u16>>,
    /// How much of a value stands for one of 256 levels.
    pub unit: i32,
}

/// The images that are prefiltered.
pub fn images(image: &Image, params: &Params) -> Images {
    let channels = match params.color_cost {
        true => [0, 1, 2].map(|sample| deep_gray(image, Channel::Sample(sample))).into(),
        false => vec![deep_gray(image, Channel::Luma)],
    };
    Images { channels, unit: depth_unit(image) }
}

impl Images {
    /// All of them prefiltered.
    pub fn prefiltered(&self, params: &Params) -> Self {
        let unit = if params.prefilter == Prefilter::None { self.unit } else { 1 };
        Self { channels: self.channels.iter().map(|image| prefilter(image, self.unit, params)).collect(), unit }
    }

    /// The sums over windows of `side` x `side` pixels of all of them.
    pub fn window_sums(&self, side: u32) -> Vec<Plane<u32>> {
        self.channels.iter().map(|image| image.map(|x, y| window_sum(image, side, x, y) as u32)).collect()
    }
}
