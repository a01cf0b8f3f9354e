//! The images of the levels of belief propagation: each has half the sides of the one before.

use crate::gpu::layout::rows::Rows;
use crate::{Method, Params};

/// Volumes of messages, one after the other in the buffer of a band.
pub(crate) const WAYS: u32 = 4;

/// The images of a level, and how their volumes are cut.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Scale {
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// Pixels a row of a volume.
    pub(crate) stride: u32,
    /// The rows of this level that lie in each band.
    pub(crate) bands: Vec<Rows>,
}

impl Scale {
    /// Bytes of a volume of one byte a disparity, of the rows of a band.
    pub(crate) fn volume(&self, band: usize, quads: u32) -> u64 {
        16 * u64::from(quads) * u64::from(self.stride) * u64::from(self.bands[band].count)
    }

    /// The next level.
    fn halved(&self) -> Self {
        let width = self.width.div_ceil(2);
        let half = |rows: &Rows| Rows { first: rows.first / 2, count: rows.count.div_ceil(2) };
        Self { width, height: self.height.div_ceil(2), stride: width | 1, bands: self.bands.iter().map(half).collect() }
    }
}

/// The rows to whose multiples bands are cut, so that what is summed into a pixel of any level lies in one band.
pub(super) fn band_unit(params: &Params, width: u32, height: u32) -> u32 {
    match params.method {
        Method::Bp => 1 << (params.levels(width, height) - 1),
        Method::Sgm | Method::Bm | Method::Psmnet => 1,
    }
}

/// All levels, the finest first; none with other methods.
pub(super) fn scales(params: &Params, width: u32, height: u32, stride: u32, bands: &[Rows]) -> Vec<Scale> {
    match params.method {
        Method::Bp => {
            let finest = Scale { width, height, stride, bands: bands.to_vec() };
            std::iter::successors(Some(finest), |finer| Some(finer.halved()))
                .take(params.levels(width, height) as usize)
                .collect()
        }
        Method::Sgm | Method::Bm | Method::Psmnet => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bands of every level cover its rows once, in order.
    #[test]
    fn bands_of_all_levels_cover_their_rows() {
        let params = Params { bp_levels: 5, ..Params::bp(16) };
        for height in 1..200 {
            let unit = band_unit(&params, 7, height);
            let bands = crate::gpu::layout::cut_to(Rows { first: 0, count: height }, 48, unit);
            for scale in scales(&params, 7, height, 7, &bands) {
                let end = scale.bands.iter().fold(0, |next, band| {
                    assert!(band.first == next && band.count > 0, "{scale:?}");
                    band.end()
                });
                assert_eq!(end, scale.height, "{scale:?}");
            }
        }
    }
}
