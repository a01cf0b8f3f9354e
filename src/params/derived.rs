//! What follows from the settings.

use std::ops::RangeInclusive;

use crate::params::{Census, Filter, Params, Prefilter, RightView, Subpixel};

impl Params {
    /// The disparities that are searched, in pixels.
    pub fn searched(&self) -> RangeInclusive<i32> {
        self.min_disparity..=self.min_disparity.saturating_add_unsigned(self.disparities).saturating_sub(1)
    }

    /// The settings for images that are halved so often, in the early rounds of mutual information: no filter but
    /// `lr_check`, and nothing beside the map of the left view.
    pub(crate) fn rough(&self, halvings: u32) -> Self {
        let last = self.min_disparity + self.disparities as i32 - 1;
        let (from, to) = (self.min_disparity >> halvings, -(-last >> halvings));
        let mut rough = Self {
            min_disparity: from,
            disparities: (to - from + 1) as u32,
            adaptive_p2: false,
            right_view: RightView::Diagonal,
            confidence: false,
            right_map: false,
            depth: None,
            rectify: None,
            masks: None,
            ..self.clone()
        };
        Filter::ALL.iter().for_each(|filter| filter.clear(&mut rough));
        rough.lr_check = Some(1);
        rough
    }

    /// Whether anything reads the right view.
    pub(crate) fn reads_right_view(&self) -> bool {
        self.right_map || Filter::ALL.iter().any(|filter| filter.reads_right(self))
    }

    /// The settings of a second match of the mirrored pair for the right view, if that is wanted and something reads it:
    /// whole pixels, and all of them.
    pub(crate) fn second_match(&self) -> Option<Self> {
        (self.right_view == RightView::Match && self.reads_right_view()).then(|| self.second())
    }

    /// The same for a second match.
    pub(crate) fn second(&self) -> Self {
        Self {
            subpixel: Subpixel::Off,
            uniqueness: 0,
            texture: 0,
            confidence: false,
            right_map: false,
            depth: None,
            rectify: None,
            masks: None,
            right_view: RightView::Diagonal,
            ..self.clone()
        }
    }

    /// Rows and columns by which a block reaches beyond its centre.
    pub(crate) fn radius(&self) -> u32 {
        self.block / 2
    }

    /// Vectors of 16 disparities that hold a pixel's.
    pub(crate) fn quads(&self) -> u32 {
        self.disparities.div_ceil(16)
    }

    /// The largest value of the prefiltered image in 8 bits.
    pub(crate) fn prefiltered_max(&self) -> u32 {
        match self.prefilter {
            Prefilter::XSobel | Prefilter::Sobel | Prefilter::Normalized => 2 * self.prefilter_cap,
            Prefilter::None => 255,
        }
    }

    /// Bits of a census string.
    pub(crate) fn census_bits(&self) -> u32 {
        match self.census {
            Census::Five => 24,
            Census::Seven => 48,
            Census::NineBySeven => 62,
            Census::CentreSymmetric => 31,
        }
    }

    /// Bytes of a census string: one a row, and one for the ninth column.
    pub(crate) fn census_planes(&self) -> u32 {
        match self.census {
            Census::Five => 5,
            Census::Seven => 7,
            Census::NineBySeven => 8,
            Census::CentreSymmetric => 4,
        }
    }

    /// Images that are prefiltered: luma, or three colours.
    pub(crate) fn channels(&self) -> u32 {
        if self.color_cost { 3 } else { 1 }
    }
}
