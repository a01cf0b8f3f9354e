//! What follows from the cost.

use crate::params::{Cost, Params, Prefilter};

impl Params {
    /// Whether the cost compares the prefiltered images themselves.
    pub(crate) fn compares_values(&self) -> bool {
        matches!(self.cost, Cost::Sad | Cost::Ssd | Cost::Ncc | Cost::MutualInformation)
    }

    /// Bytes of a pixel that the cost compares.
    pub(crate) fn planes(&self) -> u32 {
        match self.cost {
            Cost::Sad => self.channels(),
            Cost::Ssd | Cost::ZeroMeanSad | Cost::Ncc | Cost::MutualInformation => 1,
            Cost::BirchfieldTomasi => 3 * self.channels(),
            Cost::SadXy => 2,
            Cost::Census => self.census_planes(),
            Cost::CensusSobel => self.census_planes() + 2,
            Cost::AdCensus => self.census_planes() + 1,
        }
    }

    /// The largest value of those bytes, as far as they are compared as numbers.
    pub(crate) fn descriptor_max(&self) -> u32 {
        match self.cost {
            Cost::ZeroMeanSad => 127 + self.prefiltered_max().min(127),
            Cost::SadXy | Cost::CensusSobel => 2 * self.prefilter_cap,
            _ => self.prefiltered_max(),
        }
    }

    /// The largest cost of a pixel.
    pub(crate) fn pixel_max(&self) -> u32 {
        match self.cost {
            Cost::Sad | Cost::BirchfieldTomasi => self.prefiltered_max(),
            Cost::MutualInformation => 255,
            Cost::Ssd | Cost::Ncc => self.prefiltered_max().pow(2),
            Cost::ZeroMeanSad => (2 * self.prefiltered_max()).min(254),
            Cost::SadXy => 4 * self.prefilter_cap,
            Cost::Census => self.census_bits(),
            Cost::CensusSobel => 2 * self.census_bits() + 4 * self.prefilter_cap,
            Cost::AdCensus => {
                let weighted = self.ad_weight * self.prefiltered_max() + self.census_weight * self.census_bits();
                ((weighted + 8) >> 4).clamp(1, 255)
            }
        }
    }

    /// The largest sum of pixel costs over a block: at most 51 * 51 * 255 * 255.
    pub(crate) fn largest_sum(&self) -> u32 {
        self.block * self.block * self.pixel_max()
    }

    /// Whether the sum of a column of the block may need more than 16 bits.
    pub(crate) fn wide_sums(&self) -> bool {
        self.block * self.pixel_max() > 0xffff
    }

    /// Whether the matching cost is made without column sums in memory: pixel costs of a byte, whose block sums fit 16
    /// bits, and few rows of planes in a block.
    pub(crate) fn sums_small_blocks(&self) -> bool {
        const MOST_ROWS: u32 = 64; // more make code that compiles for seconds
        let bytes = self.pixel_max() <= 255 && !self.multiplies();
        bytes && self.block <= Self::SMALL_BLOCK && (self.block + 1) * self.planes() <= MOST_ROWS
    }

    /// The shift that quantises sums of a byte, where the scale is a power of two; else 0.
    pub(crate) fn scale_shift(&self) -> u32 {
        let scale = self.cost_scale();
        let shift = 24 - scale.ilog2().min(24);
        let rounded = self.largest_sum() + (1 << shift) / 2;
        if scale.is_power_of_two() && (1..8).contains(&shift) && rounded <= 255 { shift } else { 0 }
    }

    /// Whether a stage needs the sums over windows.
    pub(crate) fn sums_windows(&self) -> bool {
        self.prefilter == Prefilter::Normalized || self.cost == Cost::ZeroMeanSad
    }

    /// Whether the cost of a pixel is a product, of 16 bits whatever the prefilter.
    pub(crate) fn multiplies(&self) -> bool {
        matches!(self.cost, Cost::Ssd | Cost::Ncc)
    }

    /// Bits by which block sums are shifted down: as many as bring the largest below 2^20; none where the sums are not
    /// yet the costs.
    pub(crate) fn narrowing(&self) -> u32 {
        if self.cost == Cost::Ncc {
            return 0;
        }
        (32 - self.largest_sum().leading_zeros()).saturating_sub(20)
    }

    /// 1024 times the quantised cost of the largest block sum: at most 59 * 1550, which gives 89.
    pub(crate) fn cost_top(&self) -> u32 {
        match self.cost {
            Cost::CensusSobel => 128 * self.pixel_max(),
            Cost::MutualInformation => 64 * 1024,
            _ => 59 * 1550,
        }
    }

    /// The factor that brings a narrowed block sum to the quantised cost: round(top 2^14 / largest), of the largest sum
    /// and [`Params::cost_top`].
    pub(crate) fn cost_scale(&self) -> u32 {
        let largest = self.largest_sum() >> self.narrowing();
        (self.cost_top() * (1 << 14) + largest / 2) / largest
    }
}
