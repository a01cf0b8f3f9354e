//! What the first layer reads: an image less its mean, 32 to a standard deviation.

use crate::cpu::images::Samples;
use crate::reference::{FeatureStatistics, feature_statistics};

/// A prefiltered image and its statistics.
pub struct Input<'a> {
    samples: &'a Samples,
    pub statistics: FeatureStatistics,
}

impl<'a> Input<'a> {
    pub fn new(samples: &'a Samples) -> Self {
        let unit = if matches!(samples, Samples::Words(_)) { 257 } else { 1 };
        Self { samples, statistics: feature_statistics(&samples.plane(), unit) }
    }

    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        match self.samples {
            Samples::Bytes(image) => [image.width, image.height],
            Samples::Words(image) => [image.width, image.height],
        }
    }

    /// Row y from the column `from` on.
    #[inline(always)]
    pub fn row(&self, y: usize, from: usize, out: &mut [f32]) {
        match self.samples {
            Samples::Bytes(image) => {
                let values = image.row(y as i64, 0)[from..].iter();
                out.iter_mut().zip(values).for_each(|(out, &v)| *out = self.value(256 * i32::from(v)));
            }
            Samples::Words(image) => {
                let values = image.row(y as i64, 0)[from..].iter();
                out.iter_mut().zip(values).for_each(|(out, &v)| *out = self.value(v.into()));
            }
        }
    }

    /// As in [`feature_input`](crate::reference::feature_input). The quotient of floats is on the right side of each whole number up
    /// to 127: one of whole numbers below it differs from it by at least 1 / 16368.
    #[inline(always)]
    fn value(&self, v: i32) -> f32 {
        let FeatureStatistics { mean, deviation } = self.statistics;
        let (above, deviation) = (v - mean as i32, deviation as i32);
        let size = (16 * above.abs() + deviation) as f32 / (2 * deviation) as f32;
        let size = size.min(127.0) as i32;
        if above < 0 { -size as f32 } else { size as f32 }
    }
}
