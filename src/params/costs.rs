//! The table of costs: all that tells one cost from another, but how its descriptors and the cost of a pixel are computed
//! (src/reference/cost/descriptors.rs and cost_columns.rs, and their twins in shaders/cost). The rest of the code asks the row
//! and never for a certain cost.

use std::ops::RangeInclusive;

use crate::params::choices::{Census, Method, Prefilter};
use crate::params::names::{Named, words};

/// A row of the table.
pub(crate) struct CostRow {
    /// Its name on the command line.
    pub(crate) name: &'static str,
    /// What it is, in a few words.
    pub(crate) help: &'static str,
    /// The usual prefilter.
    pub(crate) prefilter: Prefilter,
    /// The usual block with [`Method::Sgm`].
    pub(crate) block: u32,
    /// The methods that it is for.
    pub(crate) methods: &'static [Method],
    /// The blocks that it is for.
    pub(crate) blocks: RangeInclusive<u32>,
    /// Whether it may compare red, green and blue rather than luma.
    pub(crate) color: bool,
    /// Whether the gray image, which is not prefiltered, is described, too, after the prefiltered one.
    pub(crate) beside_gray: bool,
    /// The options that weight its descriptors.
    pub(crate) weights: &'static [&'static str],
    /// What it compares of a pixel, one after the other: at most one besides a census string and features, which come last.
    pub(crate) descriptors: &'static [Descriptor],
    /// What the cost of a pixel is.
    pub(crate) kind: Kind,
    /// The largest cost of a pixel. At most 255, but for products.
    pub(crate) pixel_max: fn(&Ranges) -> u32,
    /// The largest clip of the prefilter for which that holds.
    pub(crate) largest_cap: fn(&Ranges) -> u32,
    /// 1024 times the quantised cost of the largest block sum, by the largest cost of a pixel: at most [`TOP`].
    pub(crate) top: fn(u32) -> u32,
    /// The WGSL that compares two pixels: `pixel_costs`, or `pixel_pairs` of a product.
    pub(crate) fragments: &'static [&'static str],
    /// Whether the kernel `block_match_small`, which does not use these fragments, supports it.
    pub(crate) small_match: bool,
}

/// What a pixel is compared by: bytes of one image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Descriptor {
    /// The value of the prefiltered image, in 8 bits.
    Value,
    /// The value, and the smallest and the largest that lie up to half a pixel beside it.
    Interval,
    /// The value less the mean of the block around it.
    Excess,
    /// Both derivatives, clipped.
    Gradients,
    /// The census string.
    Census,
    /// What a network says of the pixels around it.
    Features,
}

impl Descriptor {
    /// The names in shaders/cost/descriptors.wgsl of those that it computes beside a census string; `Value` is the default.
    pub(crate) const IN_SHADERS: &[(&'static str, Self)] = &[
        ("DESCRIPTOR_INTERVAL", Self::Interval),
        ("DESCRIPTOR_EXCESS", Self::Excess),
        ("DESCRIPTOR_GRADIENTS", Self::Gradients),
    ];

    /// Its bytes, `features` of a network that makes so many.
    pub(crate) fn planes(self, census: Census, features: u32) -> u32 {
        match self {
            Self::Value | Self::Excess => 1,
            Self::Interval => 3,
            Self::Gradients => 2,
            Self::Census => census.planes(),
            Self::Features => features,
        }
    }

    /// The largest of its bytes that are compared as numbers.
    pub(crate) fn max(self, ranges: &Ranges) -> u32 {
        match self {
            Self::Value | Self::Interval => ranges.value,
            Self::Excess => 127 + ranges.value.min(127),
            Self::Gradients => 2 * ranges.cap,
            Self::Census => 0,
            Self::Features => 255,
        }
    }
}

/// What the cost of a pixel is, and what becomes of the sums over blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A byte, computed from the descriptors.
    Difference,
    /// A product of 16 bits.
    Product,
    /// A product, of whose sum over a block and the blocks' own sums (stage `block_statistics`) the cost is made.
    Correlation,
    /// A byte of a table that is made of a map of the pair, in several rounds.
    Table,
}

impl Kind {
    /// Whether the cost of a pixel is a product, of 16 bits whatever the prefilter.
    pub(crate) fn multiplies(self) -> bool {
        match self {
            Self::Product | Self::Correlation => true,
            Self::Difference | Self::Table => false,
        }
    }
}

/// What the largest values of a cost depend on.
pub(crate) struct Ranges {
    /// The largest value of the prefiltered image in 8 bits.
    pub(crate) value: u32,
    /// The clip of the prefilter and of derivatives.
    pub(crate) cap: u32,
    /// Bits of a census string.
    pub(crate) census_bits: u32,
    /// Weight of an absolute difference, in sixteenths.
    pub(crate) ad_weight: u32,
    /// Weight of a differing bit, in sixteenths.
    pub(crate) census_weight: u32,
    /// Weight of the cost of features, in 64ths.
    pub(crate) learned_weight: u32,
}

/// 1024 times the largest quantised cost: it gives 89.
const TOP: u32 = 59 * 1550;

/// The largest cost of two vectors of features: a right angle, 170 * 170 >> 7.
const FEATURES_MAX: u32 = 225;

/// The largest block, and the largest clip, where a cost sets no lower limit.
const ANY_BLOCK: RangeInclusive<u32> = 1..=51;
const ANY_CAP: fn(&Ranges) -> u32 = |_| 127;

const ALL: &[Method] = &[Method::Sgm, Method::Bm, Method::Bp];

macro_rules! wgsl {
    ($($file:literal),+) => { &[$(include_str!(concat!("../../shaders/cost/parts/", $file, ".wgsl"))),+] };
}

/// The enumeration of the costs, and the row of each.
macro_rules! costs {
    ($($(#[$doc:meta])* $cost:ident { $($row:tt)+ })+) => {
        /// How alike two pixels are, summed over a block: the matching cost.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum Cost {
            $($(#[$doc])* $cost,)+
        }

        impl Cost {
            /// Its row of the table.
            pub(crate) const fn row(self) -> &'static CostRow {
                match self {
                    $(Self::$cost => const { &CostRow { $($row)+ } },)+
                }
            }
        }

        impl Named for Cost {
            const NAMES: &'static [(&'static str, &'static str)] =
                &[$((Self::$cost.row().name, Self::$cost.row().help)),+];
            const VALUES: &'static [Self] = &[$(Self::$cost),+];
            const OPTION: &'static str = "cost";

            fn name(self) -> &'static str {
                self.row().name
            }
        }
    };
}

costs! {
    /// Absolute differences.
    Sad {
        name: "sad", help: "absolute differences",
        prefilter: Prefilter::XSobel, block: 5, methods: ALL, blocks: ANY_BLOCK, color: true, beside_gray: false, weights: &[],
        descriptors: &[Descriptor::Value], kind: Kind::Difference,
        pixel_max: |of| of.value, largest_cap: ANY_CAP, top: |_| TOP,
        fragments: wgsl!("pixel_sad"), small_match: true,
    }
    /// Squared differences.
    Ssd {
        name: "ssd", help: "squared differences",
        prefilter: Prefilter::XSobel, block: 5, methods: ALL, blocks: ANY_BLOCK, color: false, beside_gray: false, weights: &[],
        descriptors: &[Descriptor::Value], kind: Kind::Product,
        pixel_max: |of| of.value * of.value, largest_cap: ANY_CAP, top: |_| TOP,
        fragments: wgsl!("pixel_ssd"), small_match: false,
    }
    /// Absolute differences after the mean of the block around each pixel is subtracted from it.
    ZeroMeanSad {
        name: "zsad", help: "absolute differences less the block's mean",
        prefilter: Prefilter::None, block: 5, methods: ALL, blocks: ANY_BLOCK, color: false, beside_gray: false, weights: &[],
        descriptors: &[Descriptor::Excess], kind: Kind::Difference,
        pixel_max: |of| (2 * of.value).min(254), largest_cap: ANY_CAP, top: |_| TOP,
        fragments: wgsl!("pixel_sad"), small_match: false,
    }
    /// The difference that does not depend on sampling: Birchfield and Tomasi, "A Pixel Dissimilarity Measure That Is
    /// Insensitive to Image Sampling", IEEE TPAMI 20(4), 1998.
    BirchfieldTomasi {
        name: "bt", help: "Birchfield-Tomasi: the same between two pixels as on them",
        prefilter: Prefilter::XSobel, block: 5, methods: ALL, blocks: ANY_BLOCK, color: true, beside_gray: false, weights: &[],
        descriptors: &[Descriptor::Interval], kind: Kind::Difference,
        pixel_max: |of| of.value, largest_cap: ANY_CAP, top: |_| TOP,
        fragments: wgsl!("pixel_bt"), small_match: false,
    }
    /// [`Cost::BirchfieldTomasi`] of the prefiltered image, and a quarter of it of the gray one: that of OpenCV's StereoSGBM.
    BirchfieldTomasiGray {
        name: "bt-gray", help: "bt, and a quarter of it on the gray image: that of StereoSGBM",
        prefilter: Prefilter::XSobel, block: 5, methods: ALL, blocks: ANY_BLOCK, color: false, beside_gray: true, weights: &[],
        descriptors: &[Descriptor::Interval], kind: Kind::Difference,
        pixel_max: |of| (of.value + 63).min(255), largest_cap: |_| (255 - 63) / 2, top: |_| TOP,
        fragments: wgsl!("pixel_bt"), small_match: false,
    }
    /// Absolute differences of the horizontal and of the vertical Sobel derivative.
    SadXy {
        name: "sad-xy", help: "absolute differences of both Sobel derivatives",
        prefilter: Prefilter::None, block: 5, methods: ALL, blocks: ANY_BLOCK, color: false, beside_gray: false, weights: &[],
        descriptors: &[Descriptor::Gradients], kind: Kind::Difference,
        pixel_max: |of| 4 * of.cap, largest_cap: |_| 255 / 4, top: |_| TOP,
        fragments: wgsl!("pixel_sad"), small_match: false,
    }
    /// Hamming distance of census strings ([`Census`]): Zabih and Woodfill, "Non-parametric Local Transforms for
    /// Computing Visual Correspondence", ECCV 1994.
    Census {
        name: "census", help: "differing bits of census strings",
        prefilter: Prefilter::None, block: 1, methods: ALL, blocks: ANY_BLOCK, color: false, beside_gray: false, weights: &[],
        descriptors: &[Descriptor::Census], kind: Kind::Difference,
        pixel_max: |of| of.census_bits, largest_cap: ANY_CAP, top: |_| TOP,
        fragments: wgsl!("pixel_census", "pixel_bits"), small_match: false,
    }
    /// Twice the Hamming distance of census strings, and the absolute differences of both Sobel derivatives.
    CensusSobel {
        name: "census-sobel", help: "census and sad-xy together",
        prefilter: Prefilter::None, block: 1, methods: ALL, blocks: ANY_BLOCK, color: false, beside_gray: false, weights: &[],
        descriptors: &[Descriptor::Census, Descriptor::Gradients], kind: Kind::Difference,
        pixel_max: |of| 2 * of.census_bits + 4 * of.cap, largest_cap: |of| (255 - 2 * of.census_bits) / 4,
        top: |pixel_max| 128 * pixel_max,
        fragments: wgsl!("pixel_census_sobel", "pixel_bits"), small_match: false,
    }
    /// Absolute differences and the Hamming distance of census strings, each with a weight.
    AdCensus {
        name: "ad-census", help: "absolute differences and census, each with a weight",
        prefilter: Prefilter::None, block: 1, methods: ALL, blocks: ANY_BLOCK, color: false, beside_gray: false, weights: &["ad-weight", "census-weight"],
        descriptors: &[Descriptor::Census, Descriptor::Value], kind: Kind::Difference,
        pixel_max: |of| ((of.ad_weight * of.value + of.census_weight * of.census_bits + 8) >> 4).clamp(1, 255),
        largest_cap: ANY_CAP, top: |_| TOP,
        fragments: wgsl!("pixel_ad_census", "pixel_bits"), small_match: false,
    }
    /// The angle between vectors of features that a network makes of both sides ([`crate::FeatureNetwork`]).
    Learned {
        name: "learned", help: "the angle between features that a network makes",
        prefilter: Prefilter::None, block: 1, methods: ALL, blocks: ANY_BLOCK, color: false, beside_gray: false, weights: &[],
        descriptors: &[Descriptor::Features], kind: Kind::Difference,
        pixel_max: |_| FEATURES_MAX, largest_cap: ANY_CAP, top: |pixel_max| 128 * pixel_max,
        fragments: wgsl!("pixel_sad"), small_match: false,
    }
    /// [`Cost::Learned`] and [`Cost::CensusSobel`], each with a weight.
    LearnedCensus {
        name: "learned-census", help: "learned and census-sobel, each with a weight",
        prefilter: Prefilter::None, block: 1, methods: ALL, blocks: ANY_BLOCK, color: false, beside_gray: false,
        weights: &["learned-weight", "census-weight"],
        descriptors: &[Descriptor::Census, Descriptor::Gradients, Descriptor::Features], kind: Kind::Difference,
        pixel_max: |of| {
            let beside = 2 * of.census_bits + 4 * of.cap;
            ((of.learned_weight * FEATURES_MAX + of.census_weight * beside + 32) >> 6).clamp(1, 255)
        },
        largest_cap: |of| (255 - 2 * of.census_bits) / 4, top: |pixel_max| 128 * pixel_max,
        fragments: wgsl!("pixel_census_sobel", "pixel_bits"), small_match: false,
    }
    /// Normalised cross correlation; for [`Method::Bm`].
    Ncc {
        name: "ncc", help: "normalised cross correlation, for bm",
        prefilter: Prefilter::None, block: 5, methods: &[Method::Bm], blocks: 3..=19, color: false, beside_gray: false, weights: &[],
        descriptors: &[Descriptor::Value], kind: Kind::Correlation,
        pixel_max: |of| of.value * of.value, largest_cap: ANY_CAP, top: |_| TOP,
        fragments: wgsl!("pixel_ncc"), small_match: false,
    }
    /// Mutual information: Hirschmüller, "Accurate and Efficient Stereo Processing by Semi-Global Matching and Mutual
    /// Information", CVPR 2005.
    MutualInformation {
        name: "mi", help: "mutual information",
        prefilter: Prefilter::None, block: 1, methods: ALL, blocks: ANY_BLOCK, color: false, beside_gray: false, weights: &[],
        descriptors: &[Descriptor::Value], kind: Kind::Table,
        pixel_max: |_| 255, largest_cap: ANY_CAP, top: |_| 64 * 1024,
        fragments: wgsl!("pixel_mi"), small_match: false,
    }
}

words!(Cost);

#[cfg(all(test, feature = "gpu"))] // it compares with the kernels, too
mod tests;
