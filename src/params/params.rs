//! The settings, and those to start from.

use crate::params::{
    Camera, Census, Cost, Fill, Masks, Median, Method, Paths, Prefilter, Rectification, RightView, Schedule,
    Smoothness, Subpixel, Wls,
};
use crate::{FeatureNetwork, Network};

/// What a user may ask for. Start from [`Params::default_for`], [`Params::preset`], [`Params::sgm`], [`Params::bm`] or [`Params::bp`]
/// and change what differs, or
/// set it by name ([`Params::set`], [`Params::from_options`]).
///
/// ```
/// use gpu_stereo::{Params, Paths};
/// let mut params = Params::sgm(64);
/// params.paths = Paths::Eight;
/// params.uniqueness = 15;
/// assert!(params.validate().is_ok());
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Params {
    /// Smallest disparity in pixels, negative allowed.
    pub min_disparity: i32,
    /// Number of disparities searched: `min_disparity ..= min_disparity + disparities - 1`.
    pub disparities: u32,
    /// How the winner is found.
    pub method: Method,
    /// The matching cost.
    pub cost: Cost,
    /// The window of the costs with a census.
    pub census: Census,
    /// Weight of an absolute difference in [`Cost::AdCensus`], in sixteenths.
    pub ad_weight: u32,
    /// Weight of a differing bit in [`Cost::AdCensus`], in sixteenths; of [`Cost::CensusSobel`] in [`Cost::LearnedCensus`], in 64ths.
    pub census_weight: u32,
    /// Weight of [`Cost::Learned`] in [`Cost::LearnedCensus`], in 64ths.
    pub learned_weight: u32,
    /// The network that makes the features of [`Cost::Learned`] and [`Cost::LearnedCensus`]; `None` for the one that comes with the
    /// library.
    pub features: Option<FeatureNetwork>,
    /// Compare red, green and blue rather than luma: [`Cost::Sad`] and [`Cost::BirchfieldTomasi`].
    pub color_cost: bool,
    /// Side of the square block in pixels: odd, 1 to 51.
    pub block: u32,
    /// The image on which costs are computed.
    pub prefilter: Prefilter,
    /// Clip of the prefilter, 1 to 127.
    pub prefilter_cap: u32,
    /// Side of the window of [`Prefilter::Normalized`] in pixels: odd, 3 to 51.
    pub prefilter_window: u32,
    /// Directions of [`Method::Sgm`].
    pub paths: Paths,
    /// Penalty of a disparity step of 1 between neighbours on a path, in units of the quantised cost (0 to 89), 0 to P2.
    pub p1: u32,
    /// Penalty of a larger disparity step, in the same units, P1 to 127.
    pub p2: u32,
    /// Lower P1 where the intensity changes along the path.
    pub adaptive_p1: bool,
    /// Lower P2 where the intensity changes along the path.
    pub adaptive_p2: bool,
    /// Step of the intensity up to which an adaptive P2 is whole, in gray levels, 1 to 255.
    pub p2_step: u32,
    /// Passes of aggregation of [`Method::Sgm`], 1 or 2: the second one aggregates the mean of the cost and of what the first one gave.
    pub passes: u32,
    /// How the smoothness term of [`Method::Bp`] grows with the difference between the disparities of two neighbours.
    pub smoothness: Smoothness,
    /// The smoothness of a difference of 1, in units of the quantised cost (0 to 89), 0 to 127; of no effect with
    /// [`Smoothness::Potts`].
    pub smoothness_weight: u32,
    /// The largest smoothness of two neighbours, in the same units, 0 to 127.
    pub smoothness_truncation: u32,
    /// Intensity step between two neighbours, 1 to 255, from which on their smoothness is half; `None` for nowhere.
    pub smoothness_edge: Option<u32>,
    /// Levels on which [`Method::Bp`] passes messages, each of half the size of the one before, 1 to 10.
    pub bp_levels: u32,
    /// How often messages are passed on each level, 1 to 1000.
    pub bp_iterations: u32,
    /// The share of a pixel's belief in what it sends, in sixteenths, 4 to 16: 8 of tree-reweighted messages, 16 of plain ones.
    pub bp_reweighting: u32,
    /// The network of [`Method::Psmnet`], which needs it.
    pub network: Option<Network>,
    /// [`Method::Psmnet`]: whether interpolation lays the corner pixels of the smaller image on those of the larger one, as
    /// published weights want it, or their outer corners.
    pub align_corners: bool,
    /// Texture that a block needs: the sum over it of the clipped horizontal derivative; 0 switches the test off.
    pub texture: u32,
    /// Uniqueness in per cent, 0 to 99; 0 switches the test off.
    pub uniqueness: u32,
    /// How the winner is refined to 1/16 pixel.
    pub subpixel: Subpixel,
    /// Largest difference in pixels between the left and the right view's disparity; `None` switches the check off.
    pub lr_check: Option<u32>,
    /// The right view that the check compares with.
    pub right_view: RightView,
    /// Regions of at most so many pixels are removed; 0 switches the filter off.
    pub speckle_window: u32,
    /// Largest disparity step in pixels between neighbours of a region.
    pub speckle_range: u32,
    /// Median filter.
    pub median: Median,
    /// How holes are filled.
    pub fill: Fill,
    /// Radius in pixels of the median weighted by the left image, 1 to 15; `None` switches it off.
    pub weighted_median: Option<u32>,
    /// Intensity step at which a weight of that median halves, 1 to 255; also of [`Fill::WeightedRays`].
    pub weighted_median_sigma: u32,
    /// Smoothing by weighted least squares.
    pub wls: Option<Wls>,
    /// Decide as OpenCV's StereoBM where it decides otherwise: at the border of a prefiltered image, in the quotient of
    /// [`Prefilter::Normalized`], and about ties, uniqueness and the refinement, with [`Method::Sgm`] and [`Method::Bp`] as its StereoSGBM. And give no disparity where
    /// the range of disparities leaves the right image, or with [`Method::Bm`] a block either of them.
    pub opencv_rules: bool,
    /// Compute a confidence for each pixel, too.
    pub confidence: bool,
    /// Give the labels, too: the index of each winner, before any test of it.
    pub labels: bool,
    /// Give the disparities of [`Method::Psmnet`], too, before they are rounded to sixteenths of a pixel.
    pub unrounded: bool,
    /// Give the right view's map, too: as [`Params::right_view`] makes it, in whole pixels, before any check or filter but
    /// `validity`.
    pub right_map: bool,
    /// Compute the depth of each pixel, too, seen by these cameras.
    pub depth: Option<Camera>,
    /// Rectify the pair first. All else is then of the rectified pair. Pixels that show what lies outside the given image
    /// have no disparity, nor have those that lead to one.
    pub rectify: Option<Rectification>,
    /// Which pixels of the given images have content. Those that have none have no disparity, nor have those that lead to
    /// one.
    pub masks: Option<Masks>,
    /// Compile the kernels with checks of every index and loop: slower, the same result. For a device that misbehaves.
    pub shader_checks: bool,
    /// How the kernels are laid out on the device; the same result.
    pub schedule: Schedule,
    /// On a CPU adapter, compare what is needed with the memory that is left ([`crate::memory`]) before anything is made.
    pub memory_check: bool,
}

impl Params {
    /// The largest disparity, and minus the smallest, that can be asked for: 1/16 pixel of it fit an `i16`.
    pub const MAX_ABS_DISPARITY: i32 = 2047;
    /// The largest block side.
    pub const MAX_BLOCK: u32 = 51;
    /// The largest block that is summed without column sums in memory: 15 * 15 * 255 fits 16 bits, and 15 * 15 * 127 fits
    /// 15.
    pub(crate) const SMALL_BLOCK: u32 = 15;
    /// The largest clip of a prefilter: twice it fits a byte.
    pub const MAX_CAP: u32 = 127;
    /// The largest weight of [`Cost::AdCensus`], four times what it counts, and of [`Cost::LearnedCensus`], once.
    pub const MAX_WEIGHT: u32 = 64;
    /// The largest texture: every pixel of the largest block at the largest clip.
    pub const MAX_TEXTURE: u32 = Self::MAX_BLOCK * Self::MAX_BLOCK * Self::MAX_CAP;
    /// The largest smoothness of two neighbours: a message fits a byte with a sign.
    pub const MAX_SMOOTHNESS: u32 = 127;
    /// The largest P2: a forward and a backward path without their costs, at most P2 each, sum in a byte.
    pub const MAX_P2: u32 = 127;
    /// The largest number of disparities of [`Method::Psmnet`].
    pub const MOST_OF_NETWORK: u32 = 512;

    /// The classic chain with semi-global matching over `disparities` disparities from 0.
    #[must_use]
    pub fn sgm(disparities: u32) -> Self {
        Self {
            min_disparity: 0,
            disparities,
            method: Method::Sgm,
            cost: Cost::Sad,
            census: Census::NineBySeven,
            ad_weight: 8,
            census_weight: 32,
            learned_weight: 40,
            features: None,
            color_cost: false,
            block: 5,
            prefilter: Prefilter::XSobel,
            prefilter_cap: 31,
            prefilter_window: 9,
            paths: Paths::Four,
            p1: 16,
            p2: 96,
            adaptive_p1: false,
            adaptive_p2: false,
            p2_step: 10,
            passes: 1,
            smoothness: Smoothness::Linear,
            smoothness_weight: 2,
            smoothness_truncation: 20,
            smoothness_edge: None,
            bp_levels: 5,
            bp_iterations: 60,
            bp_reweighting: 8,
            network: None,
            align_corners: true,
            texture: 0,
            uniqueness: 10,
            subpixel: Subpixel::Parabola,
            lr_check: Some(1),
            right_view: RightView::Diagonal,
            speckle_window: 0,
            speckle_range: 2,
            median: Median::Three,
            fill: Fill::None,
            weighted_median: None,
            weighted_median_sigma: 20,
            wls: None,
            opencv_rules: false,
            confidence: false,
            labels: false,
            unrounded: false,
            right_map: false,
            depth: None,
            rectify: None,
            masks: None,
            shader_checks: false,
            schedule: Schedule::Auto,
            memory_check: true,
        }
    }

    /// The classic chain with block matching over `disparities` disparities from 0.
    #[must_use]
    pub fn bm(disparities: u32) -> Self {
        Self { method: Method::Bm, block: 15, uniqueness: 15, ..Self::sgm(disparities) }
    }

    /// The classic chain with belief propagation over `disparities` disparities from 0.
    #[must_use]
    pub fn bp(disparities: u32) -> Self {
        Self { method: Method::Bp, ..Self::sgm(disparities) }
    }

    /// A network over `disparities` disparities from 0, a multiple of 16 from 16 to [`Params::MOST_OF_NETWORK`], without a
    /// filter.
    #[must_use]
    pub fn psmnet(disparities: u32, network: Network) -> Self {
        Self { network: Some(network), ..Self::sgm(disparities).with_psmnet().without_filters() }
    }
}
