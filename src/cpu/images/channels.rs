//! An image as the chain takes it, in one channel or three: the twin of [`Images`].

use crate::cpu::features::FeatureRows;
use crate::cpu::images::derivatives::Depth as _;
use crate::cpu::images::padded::{Padded, Samples};
use crate::cpu::images::{gray, prefilter};
use crate::cpu::instructions::Instructions;
use crate::reference::{Channel, Images};
use crate::{ImageView, Params, Prefilter};

/// An image in luma, or with [`Params::color_cost`] in red, green and blue.
#[derive(Clone)]
pub struct Channels {
    pub channels: Vec<Samples>,
    /// Luma, never prefiltered, if the cost compares it, too; in 8 bits beside a prefiltered image.
    pub gray: Option<Samples>,
    instructions: Instructions,
}

impl Channels {
    /// Stage `gray`.
    pub fn new(image: ImageView<'_>, params: &Params, instructions: Instructions) -> Self {
        let channels: &[Channel] = match params.color_cost {
            true => &[Channel::Sample(0), Channel::Sample(1), Channel::Sample(2)],
            false => &[Channel::Luma],
        };
        let channels: Vec<_> = channels.iter().map(|&channel| gray::samples(image, channel, instructions)).collect();
        let gray = params.cost.row().beside_gray.then(|| channels[0].clone());
        Self { channels, gray, instructions }
    }

    /// Stage `prefilter`.
    pub fn prefiltered(self, params: &Params) -> Self {
        if params.prefilter == Prefilter::None {
            return self;
        }
        let Self { channels, gray, instructions } = self;
        let filtered = |samples: &Samples| {
            Samples::Bytes(match samples {
                Samples::Bytes(image) => prefilter::filtered(image, params, instructions),
                Samples::Words(image) => prefilter::filtered(image, params, instructions),
            })
        };
        Self { channels: channels.iter().map(filtered).collect(), gray: gray.map(narrowed), instructions }
    }

    /// Stage `features` of the prefiltered image, where the cost compares such.
    pub fn features(&self, params: &Params) -> Option<FeatureRows> {
        let network = params.feature_network()?;
        Some(FeatureRows::new(&self.channels[0], &network, self.instructions))
    }

    /// The set that the stages are compiled for.
    pub fn instructions(&self) -> Instructions {
        self.instructions
    }

    /// In the definition's layout.
    pub fn images(&self) -> Images {
        let channels = self.channels.iter().map(Samples::plane).collect();
        let unit = if self.channels.iter().any(|samples| matches!(samples, Samples::Words(_))) { 257 } else { 1 };
        Images { channels, unit, gray: self.gray.as_ref().map(Samples::plane) }
    }
}

/// The same image in 8 bits.
fn narrowed(samples: Samples) -> Samples {
    match samples {
        Samples::Bytes(image) => Samples::Bytes(image),
        Samples::Words(image) => Samples::Bytes(Padded::from_rows(image.width, image.height, |y, row| {
            row.iter_mut().zip(image.row(y as i64, 0)).for_each(|(narrow, value)| *narrow = value.narrow());
        })),
    }
}
