//! What follows from the settings.

use std::ops::RangeInclusive;

use crate::Error;
use crate::features::{FeatureNetwork, LEFT_OUT};
use crate::network::{Network, Padded};
use crate::params::costs::{Descriptor, Kind, Ranges};
use crate::params::{Filter, Method, Params, Prefilter, RightView, Subpixel};

impl Params {
    /// The disparities that are searched, in pixels.
    pub fn searched(&self) -> RangeInclusive<i32> {
        self.min_disparity..=self.min_disparity.saturating_add_unsigned(self.disparities).saturating_sub(1)
    }

    /// The network of the settings, for the method that needs one. With `--cfg gpu_stereo_without_networks` the code that computes
    /// networks on the CPU is left out of a program: web/build wants it small.
    ///
    /// # Errors
    /// [`Error::Misuse`] without a network; [`Error::Network`] in a program that computes none.
    #[inline]
    pub(crate) fn given_network(&self) -> Result<&Network, Error> {
        if cfg!(gpu_stereo_without_networks) {
            return Err(Error::Network("this program computes no networks on the CPU; choose another method".into()));
        }
        self.network.as_ref().ok_or_else(|| Error::Misuse("method psmnet needs a network".into()))
    }

    /// The settings for images that are halved `halvings` times, in the early rounds of mutual information: no filter but
    /// `lr_check`, and no result but the map of the left view.
    pub(crate) fn rough(&self, halvings: u32) -> Self {
        let last = self.min_disparity + self.disparities as i32 - 1;
        let (from, to) = (self.min_disparity >> halvings, -(-last >> halvings));
        let mut rough = Self {
            min_disparity: from,
            disparities: (to - from + 1) as u32,
            adaptive_p1: false,
            adaptive_p2: false,
            passes: 1,
            smoothness_edge: None,
            right_view: RightView::Diagonal,
            confidence: false,
            labels: false,
            unrounded: false,
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

    /// Whether the penalties of the steps of paths depend on the left image.
    pub(crate) fn adapts_penalties(&self) -> bool {
        self.method == Method::Sgm && (self.adaptive_p1 || self.adaptive_p2)
    }

    /// Whether the sum of the path costs is aggregated a second time.
    pub(crate) fn aggregates_twice(&self) -> bool {
        self.method == Method::Sgm && self.passes == 2
    }

    /// Whether anything reads the smoothness: belief propagation does, and of other methods' labels the energy.
    pub(crate) fn reads_smoothness(&self) -> bool {
        match self.method {
            Method::Bp => true,
            Method::Sgm | Method::Bm => self.labels,
            Method::Psmnet => false,
        }
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

    /// Multiplications with the weights of the network for a pair of `width` x `height` pixels, of both runs where the right
    /// view has one of its own; 0 without a network. [`crate::Network::done`] tells how many are done.
    #[must_use]
    pub fn multiplications(&self, width: u32, height: u32) -> u64 {
        let Some(network) = self.network.as_ref().filter(|_| self.method == Method::Psmnet) else { return 0 };
        let (operations, padded) = (network.operations(), Padded::new(width, height, self.disparities));
        let once: u64 = operations.iter().map(|operation| operation.multiplications(operations, &padded)).sum();
        if self.second_match().is_some() { 2 * once } else { once }
    }

    /// Whether labels are asked for, and there are any: a network has none.
    pub(crate) fn has_labels(&self) -> bool {
        self.labels && self.method != Method::Psmnet
    }

    /// The settings of a second match.
    pub(crate) fn second(&self) -> Self {
        Self {
            subpixel: Subpixel::Off,
            uniqueness: 0,
            texture: 0,
            confidence: false,
            labels: false,
            unrounded: false,
            right_map: false,
            depth: None,
            rectify: None,
            masks: None,
            right_view: RightView::Diagonal,
            ..self.clone()
        }
    }

    /// Whether winners are chosen and refined as OpenCV's StereoBM does.
    pub(crate) fn chooses_as_stereo_bm(&self) -> bool {
        self.opencv_rules && self.method == Method::Bm
    }

    /// The factors of [`Prefilter::Normalized`] by the rules of OpenCV's StereoBM: of the smoothed pixel, and of the
    /// difference in 1024ths.
    pub(crate) fn normalized_scales(&self) -> [u32; 2] {
        let eighth = self.prefilter_window * self.prefilter_window / 8;
        [eighth, (1024 + eighth) / (2 * eighth)]
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
            Prefilter::XSobel | Prefilter::Sobel | Prefilter::Normalized => 2 * self.bounded_cap(),
            Prefilter::None => 255,
        }
    }

    /// Levels of belief propagation: as many as asked for, but none after one of a single pixel.
    pub(crate) fn levels(&self, width: u32, height: u32) -> u32 {
        self.bp_levels.min(width.max(height).next_power_of_two().ilog2() + 1)
    }

    /// Images that are prefiltered: luma, or three colours.
    pub(crate) fn channels(&self) -> u32 {
        if self.color_cost { 3 } else { 1 }
    }

    /// Images whose descriptors the cost compares.
    pub(crate) fn described(&self) -> u32 {
        self.channels() + u32::from(self.cost.row().beside_gray)
    }

    /// The cap, no larger than any cost allows: this is also called before the settings are validated.
    fn bounded_cap(&self) -> u32 {
        self.prefilter_cap.min(Self::MAX_CAP)
    }

    /// What the largest values of the cost depend on.
    fn ranges(&self) -> Ranges {
        Ranges {
            value: self.prefiltered_max(),
            cap: self.bounded_cap(),
            census_bits: self.census.bits(),
            ad_weight: self.ad_weight,
            census_weight: self.census_weight,
            learned_weight: self.learned_weight,
        }
    }

    /// Whether the cost compares this of a pixel.
    pub(crate) fn compares(&self, descriptor: Descriptor) -> bool {
        self.cost.row().descriptors.contains(&descriptor)
    }

    /// Whether the cost compares the prefiltered images themselves.
    pub(crate) fn compares_values(&self) -> bool {
        self.cost.row().descriptors == [Descriptor::Value]
    }

    /// Planes of the census string that the cost compares, if it compares one.
    pub(crate) fn census_planes(&self) -> u32 {
        if self.compares(Descriptor::Census) { self.census.planes() } else { 0 }
    }

    /// What the cost compares as numbers: beside a census string and features, if it compares such; else it is the census string.
    pub(crate) fn numeric_descriptor(&self) -> Descriptor {
        let mut descriptors = self.cost.row().descriptors.iter();
        let beside = [Descriptor::Census, Descriptor::Features];
        descriptors.find(|descriptor| !beside.contains(descriptor)).copied().unwrap_or(Descriptor::Census)
    }

    /// Bytes of a pixel that the cost compares.
    pub(crate) fn planes(&self) -> u32 {
        let descriptors = self.cost.row().descriptors.iter();
        let features = self.feature_planes();
        self.described() * descriptors.map(|descriptor| descriptor.planes(self.census, features)).sum::<u32>()
    }

    /// The network that makes features, where the cost compares such.
    pub(crate) fn feature_network(&self) -> Option<FeatureNetwork> {
        if LEFT_OUT {
            return None; // `validate` refuses such costs
        }
        let given = || self.features.clone().unwrap_or_else(FeatureNetwork::built_in);
        self.takes_features().then(given)
    }

    /// Whether a network makes features for the cost: [`Params::features`] has an effect.
    #[must_use]
    pub fn takes_features(&self) -> bool {
        self.method != Method::Psmnet && self.compares(Descriptor::Features)
    }

    /// Features of a pixel that the cost compares.
    pub(crate) fn feature_planes(&self) -> u32 {
        self.feature_network().map_or(0, |network| network.channels() as u32)
    }

    /// The largest value of those bytes, as far as they are compared as numbers.
    pub(crate) fn descriptor_max(&self) -> u32 {
        let descriptors = self.cost.row().descriptors.iter();
        let filtered = descriptors.map(|descriptor| descriptor.max(&self.ranges())).max().unwrap_or(0);
        if self.cost.row().beside_gray { 255 } else { filtered }
    }

    /// The largest cost of a pixel.
    pub(crate) fn pixel_max(&self) -> u32 {
        (self.cost.row().pixel_max)(&self.ranges())
    }

    /// The largest clip of the prefilter that is allowed with the cost.
    pub(crate) fn largest_cap(&self) -> u32 {
        (self.cost.row().largest_cap)(&self.ranges())
    }

    /// The largest sum of pixel costs over a block: at most 51 * 51 * 255 * 255.
    pub(crate) fn largest_sum(&self) -> u32 {
        self.block * self.block * self.pixel_max()
    }

    /// Whether the sum of a column of the block may need more than 16 bits.
    pub(crate) fn wide_sums(&self) -> bool {
        self.block * self.pixel_max() > 0xffff
    }

    /// Bytes of a pixel that the cost compares beside its features.
    pub(crate) fn compared_planes(&self) -> u32 {
        self.planes() - self.feature_planes()
    }

    /// Whether the cost compares features and more.
    pub(crate) fn mixes_features(&self) -> bool {
        self.feature_planes() > 0 && self.compared_planes() > 0
    }

    /// Whether the matching cost is made without column sums in memory: pixel costs of a byte, whose block sums fit 16
    /// bits, and few rows of planes in a block.
    pub(crate) fn sums_small_blocks(&self) -> bool {
        const MOST_ROWS: u32 = 64; // more rows take seconds to compile
        let bytes = self.pixel_max() <= 255 && !self.multiplies();
        if self.compares(Descriptor::Features) {
            return self.block == 1;
        }
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
        self.prefilter == Prefilter::Normalized || self.compares(Descriptor::Excess)
    }

    /// Whether the cost of a pixel is a product, of 16 bits whatever the prefilter.
    pub(crate) fn multiplies(&self) -> bool {
        self.cost.row().kind.multiplies()
    }

    /// Whether block sums become costs by the correlation of the blocks.
    pub(crate) fn correlates(&self) -> bool {
        self.cost.row().kind == Kind::Correlation
    }

    /// Whether the cost of two values is looked up in a table that is computed from a map of the pair.
    pub(crate) fn has_table(&self) -> bool {
        self.cost.row().kind == Kind::Table
    }

    /// Bits by which block sums are shifted down: as many as bring the largest below 2^20; none where the sums are not
    /// yet the costs.
    pub(crate) fn narrowing(&self) -> u32 {
        if self.correlates() {
            return 0;
        }
        (32 - self.largest_sum().leading_zeros()).saturating_sub(20)
    }

    /// 1024 times the quantised cost of the largest block sum: at most 59 * 1550, which gives 89.
    pub(crate) fn cost_top(&self) -> u32 {
        (self.cost.row().top)(self.pixel_max())
    }

    /// The largest quantised cost.
    pub(crate) fn largest_cost(&self) -> u32 {
        (self.cost_top() + 512) >> 10
    }

    /// The factor that brings a narrowed block sum to the quantised cost: round(top 2^14 / largest), of the largest sum
    /// and [`Params::cost_top`].
    pub(crate) fn cost_scale(&self) -> u32 {
        let largest = self.largest_sum() >> self.narrowing();
        (self.cost_top() * (1 << 14) + largest / 2) / largest
    }
}
