//! What a user may ask for, and the checks that come before anything touches a device.

use crate::{Camera, Error, Masks, Rectification};

/// How the kernels are laid out on a device. The result is the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Schedule {
    /// [`Schedule::PerThread`] on CPU adapters, [`Schedule::PerSubgroup`] on all others.
    #[default]
    Auto,
    /// A path an invocation: all its disparities stay in registers. Two or more invocations share a path of many
    /// disparities where the device has subgroups. For CPU adapters such as lavapipe.
    PerThread,
    /// A path for neighbouring invocations, 16 disparities each. They talk through the subgroup, or through workgroup
    /// memory where the device has no subgroups. For GPUs.
    PerSubgroup,
}

/// The image on which the matching cost is computed (`prefilter` in docs/ALGORITHMS.md).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Prefilter {
    /// Horizontal Sobel derivative, clipped to [-cap, cap] and shifted by cap.
    XSobel,
    /// Sobel gradient magnitude, rounded down and clipped to [0, 2 cap].
    Sobel,
    /// Normalised response: the smoothed pixel less the mean of the window around it, clipped to [-cap, cap] and shifted
    /// by cap.
    Normalized,
    /// The gray image itself.
    None,
}

/// How alike two pixels are, summed over a block: the matching cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Cost {
    /// Absolute differences.
    Sad,
    /// Squared differences.
    Ssd,
    /// Absolute differences after the mean of the block around each pixel is subtracted from it.
    ZeroMeanSad,
    /// The difference that does not depend on sampling: Birchfield and Tomasi, "A Pixel Dissimilarity Measure That Is
    /// Insensitive to Image Sampling", IEEE TPAMI 20(4), 1998.
    BirchfieldTomasi,
    /// Absolute differences of the horizontal and of the vertical Sobel derivative.
    SadXy,
    /// Hamming distance of census strings ([`Census`]): Zabih and Woodfill, "Non-parametric Local Transforms for
    /// Computing Visual Correspondence", ECCV 1994.
    Census,
    /// Twice the Hamming distance of census strings, and the absolute differences of both Sobel derivatives.
    CensusSobel,
    /// Absolute differences and the Hamming distance of census strings, each with a weight.
    AdCensus,
    /// Normalised cross correlation; for [`Method::Bm`].
    Ncc,
    /// Mutual information: Hirschmüller, "Accurate and Efficient Stereo Processing by Semi-Global Matching and Mutual
    /// Information", CVPR 2005.
    MutualInformation,
}

/// The neighbours that a census string compares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Census {
    /// 5 x 5 pixels with their centre: 24 bits.
    Five,
    /// 7 x 7 pixels with their centre: 48 bits.
    Seven,
    /// 9 columns x 7 rows with their centre: 62 bits.
    NineBySeven,
    /// The 31 pairs of 9 columns x 7 rows that lie opposite to each other: centre-symmetric, as in libSGM.
    CentreSymmetric,
}

/// How the block cost becomes a disparity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Method {
    /// Semi-global matching: Hirschmüller, "Stereo Processing by Semiglobal Matching and Mutual Information",
    /// IEEE TPAMI 30(2), 2008, equation 14.
    Sgm,
    /// Block matching: the disparity of the smallest block cost.
    Bm,
}

/// Directions along which semi-global matching aggregates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Paths {
    /// Both horizontal directions and the downward one: what OpenCV's `MODE_SGBM_3WAY` takes.
    Three,
    /// Both horizontal and both vertical directions.
    Four,
    /// Both horizontal directions, the downward one and the two diagonal ones downwards: OpenCV's `MODE_SGBM`.
    Five,
    /// The four, and the four diagonal ones.
    Eight,
    /// The eight, and the eight that go two pixels one way and one the other.
    Sixteen,
}

impl Paths {
    /// The number of directions.
    pub fn count(self) -> u32 {
        match self {
            Self::Three => 3,
            Self::Four => 4,
            Self::Five => 5,
            Self::Eight => 8,
            Self::Sixteen => 16,
        }
    }
}

/// Where the right view comes from that the left-right check compares with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum RightView {
    /// The costs of the left view, read along the diagonal: almost free.
    Diagonal,
    /// A full matching of its own, with the right image as the one that is matched: twice the time.
    Match,
}

/// The part of a pixel by which a winner is refined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Subpixel {
    /// Whole pixels.
    Off,
    /// The vertex of the parabola through the winner's cost and its neighbours'.
    Parabola,
    /// Where two lines of equal and opposite slope through those three costs meet.
    Equiangular,
}

/// The median filter of the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Median {
    /// No filter.
    Off,
    /// Median of 3x3 pixels.
    Three,
    /// Median of 5x5 pixels.
    Five,
}

impl Median {
    /// The side of the window in pixels.
    pub(crate) fn side(self) -> Option<usize> {
        match self {
            Self::Off => None,
            Self::Three => Some(3),
            Self::Five => Some(5),
        }
    }
}

/// How pixels without a disparity are given one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Fill {
    /// They stay without.
    None,
    /// The farther of the two neighbours in the row, as the KITTI development kit does.
    Background,
    /// Occlusions by the farther neighbour in the row, then mismatches by the median along eight rays.
    Rays,
    /// Occlusions by the second lowest and mismatches by the median along eight rays: Hirschmüller 2008, section 2.6.
    Hirschmuller,
}

/// Edge-preserving smoothing of the map, guided by the left image: Min et al., "Fast Global Image Smoothing Based on
/// Weighted Least Squares", IEEE TIP 23(12), 2014.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Wls {
    /// Strength of the smoothing: 4 keeps the accuracy; 8000, as is usual with OpenCV, smooths for the eye and costs it.
    pub lambda: f32,
    /// Intensity step that stops it; 1 to 2 is usual.
    pub sigma: f32,
}

impl Wls {
    /// Smoothing of this strength, that stops at this intensity step.
    #[must_use]
    pub fn new(lambda: f32, sigma: f32) -> Self {
        Self { lambda, sigma }
    }
}

impl Default for Wls {
    fn default() -> Self {
        Self { lambda: 4.0, sigma: 1.5 }
    }
}

/// Settings that go well together ([`Params::preset`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Preset {
    /// The plain chain, [`Params::sgm`], and the speckle filter.
    Classic,
    /// As balanced, along three directions.
    Fast,
    /// Census strings and gradients, four directions, P2 by the intensity step.
    #[default]
    Balanced,
    /// As balanced, and only what a second match confirms.
    Strict,
    /// As balanced, with every hole filled.
    Dense,
}

/// What a user may ask for. Start from [`Params::preset`], [`Params::sgm`] or [`Params::bm`] and change what differs, or
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
    /// Weight of a differing bit in [`Cost::AdCensus`], in sixteenths.
    pub census_weight: u32,
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
    /// Lower P2 where the intensity changes along the path.
    pub adaptive_p2: bool,
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
    /// Intensity step at which a weight of that median halves, 1 to 255.
    pub weighted_median_sigma: u32,
    /// Smoothing by weighted least squares.
    pub wls: Option<Wls>,
    /// Compute a confidence for each pixel, too.
    pub confidence: bool,
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
    /// The largest weight of [`Cost::AdCensus`]: four times what it counts.
    pub const MAX_WEIGHT: u32 = 64;
    /// The largest texture: every pixel of the largest block at the largest clip.
    pub const MAX_TEXTURE: u32 = Self::MAX_BLOCK * Self::MAX_BLOCK * Self::MAX_CAP;
    /// The largest P2: a forward and a backward path without their costs, at most P2 each, sum in a byte.
    pub const MAX_P2: u32 = 127;

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
            color_cost: false,
            block: 5,
            prefilter: Prefilter::XSobel,
            prefilter_cap: 31,
            prefilter_window: 9,
            paths: Paths::Four,
            p1: 16,
            p2: 96,
            adaptive_p2: false,
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
            confidence: false,
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

    /// A preset over `disparities` disparities from 0.
    ///
    /// ```
    /// use gpu_stereo::{Params, Preset, Wls};
    /// let mut params = Params::preset(Preset::Strict, 128);
    /// params.min_disparity = -16; // -16 to 111
    /// params.wls = Some(Wls::default());
    /// ```
    #[must_use]
    pub fn preset(preset: Preset, disparities: u32) -> Self {
        let classic = Self { speckle_window: 100, ..Self::sgm(disparities) };
        let balanced = Self {
            cost: Cost::CensusSobel,
            block: 1,
            census: Census::Seven,
            prefilter: Prefilter::None,
            prefilter_cap: 24,
            p1: 21,
            p2: 90,
            adaptive_p2: true,
            uniqueness: 6,
            subpixel: Subpixel::Equiangular,
            speckle_range: 1,
            ..classic.clone()
        };
        match preset {
            Preset::Classic => classic,
            Preset::Fast => {
                let derivatives = Self { cost: Cost::SadXy, prefilter: Prefilter::None, ..classic };
                Self { paths: Paths::Three, p1: 22, p2: 127, ..derivatives }
            }
            Preset::Balanced => balanced,
            Preset::Strict => Self { right_view: RightView::Match, uniqueness: 10, speckle_window: 200, ..balanced },
            Preset::Dense => {
                let matched = Self { p1: 28, p2: 110, uniqueness: 0, right_view: RightView::Match, ..balanced };
                Self { speckle_range: 2, fill: Fill::Rays, weighted_median: Some(5), ..matched }
            }
        }
    }

    /// The same with block matching: its own cost, block and uniqueness, the same filters.
    pub(crate) fn with_bm(self) -> Self {
        let Self { method, cost, block, prefilter, uniqueness, .. } = Self::bm(self.disparities);
        Self { method, cost, block, prefilter, uniqueness, ..self }
    }

    /// The prefilter and the block that are usual for the cost.
    pub(crate) fn take_usual(&mut self) {
        let (prefilter, block) = match self.cost {
            Cost::Sad | Cost::Ssd | Cost::BirchfieldTomasi => (Prefilter::XSobel, 5),
            Cost::ZeroMeanSad | Cost::SadXy | Cost::Ncc => (Prefilter::None, 5),
            Cost::Census | Cost::CensusSobel | Cost::AdCensus | Cost::MutualInformation => (Prefilter::None, 1),
        };
        self.prefilter = prefilter;
        if self.method == Method::Sgm {
            self.block = block;
        }
    }

    /// Checks every range, and that the settings go together. Whatever takes settings does so itself.
    ///
    /// ```
    /// use gpu_stereo::{Error, Params};
    /// let mut params = Params::sgm(64);
    /// params.block = 4;
    /// let Err(Error::Parameter { name, allowed, .. }) = params.validate() else { panic!() };
    /// assert_eq!((name, allowed.as_str()), ("block", "odd and from 1 to 51"));
    /// ```
    ///
    /// # Errors
    /// [`Error::Parameter`] for the first parameter outside its range.
    pub fn validate(&self) -> Result<(), Error> {
        let limit = Self::MAX_ABS_DISPARITY;
        let check = |ok: bool, name, given: String, allowed: String, remedy| {
            if ok { Ok(()) } else { Err(Error::Parameter { name, given, allowed, remedy }) }
        };
        check(
            (-limit..=limit).contains(&self.min_disparity),
            "min-disp",
            self.min_disparity.to_string(),
            format!("from -{limit} to {limit}"),
            "shift the images against each other if they really are that far apart",
        )?;
        let room = (limit - self.min_disparity + 1) as u32;
        check(
            (1..=room).contains(&self.disparities),
            "disp",
            self.disparities.to_string(),
            format!("from 1 to {room} (the largest disparity is {limit})"),
            "take the number of disparities that the scene spans",
        )?;
        check(
            self.block % 2 == 1 && self.block <= Self::MAX_BLOCK,
            "block",
            self.block.to_string(),
            format!("odd and from 1 to {}", Self::MAX_BLOCK),
            "take an odd number in that range",
        )?;
        check(
            self.p2 <= Self::MAX_P2,
            "p2",
            self.p2.to_string(),
            format!("from p1 to {}, in units of the quantised cost (0 to 89)", Self::MAX_P2),
            "4 to 8 times p1 is usual",
        )?;
        check(
            self.p1 <= self.p2,
            "p1",
            self.p1.to_string(),
            format!("from 0 to p2, which is {}", self.p2),
            "lower p1 or raise p2",
        )?;
        check(
            self.uniqueness <= 99,
            "uniqueness",
            self.uniqueness.to_string(),
            "from 0 (off) to 99 per cent".into(),
            "10 is usual",
        )?;
        check(
            self.lr_check.is_none_or(|px| px <= 2 * limit as u32 + 1),
            "lr-check",
            self.lr_check.unwrap_or_default().to_string(),
            format!("off, or from 0 to {} px", 2 * limit + 1),
            "1 is usual",
        )?;
        check(
            self.prefilter_window % 2 == 1 && (3..=Self::MAX_BLOCK).contains(&self.prefilter_window),
            "prefilter-window",
            self.prefilter_window.to_string(),
            format!("odd and from 3 to {}", Self::MAX_BLOCK),
            "9 is usual",
        )?;
        check(
            self.speckle_range <= 2 * limit as u32 + 1,
            "speckle-range",
            self.speckle_range.to_string(),
            format!("from 0 to {} px", 2 * limit + 1),
            "1 or 2 is usual",
        )?;
        for (name, weight) in [("ad-weight", self.ad_weight), ("census-weight", self.census_weight)] {
            check(
                weight <= Self::MAX_WEIGHT,
                name,
                weight.to_string(),
                format!("from 0 to {} sixteenths", Self::MAX_WEIGHT),
                "16 counts once",
            )?;
        }
        check(
            self.texture <= Self::MAX_TEXTURE,
            "texture",
            self.texture.to_string(),
            format!("from 0 (off) to {}", Self::MAX_TEXTURE),
            "a few units for each pixel of the block are usual",
        )?;
        check(
            self.speckle_window <= i32::MAX as u32,
            "speckle-window",
            self.speckle_window.to_string(),
            format!("from 0 (off) to {} px", i32::MAX),
            "100 is usual",
        )?;
        if let Some(Wls { lambda, sigma }) = self.wls {
            for (name, value, least, most, remedy) in
                [("wls-lambda", lambda, 0.0, 1e6, "4 is usual"), ("wls-sigma", sigma, 0.1, 1000.0, "1 to 2 is usual")]
            {
                let good = (least..=most).contains(&value);
                check(good, name, value.to_string(), format!("from {least} to {most}"), remedy)?;
            }
        }
        self.depth.as_ref().map_or(Ok(()), Camera::validate)?;
        let (cost, method) = (self.cost, self.method);
        check(
            cost != Cost::Ncc || method == Method::Bm,
            "cost",
            cost.to_string(),
            format!("another one with method {method}"),
            "take method bm",
        )?;
        check(
            cost != Cost::Ncc || (3..=19).contains(&self.block),
            "block",
            self.block.to_string(),
            "odd and from 3 to 19 with cost ncc".into(),
            "11 is usual",
        )?;
        check(
            !self.color_cost || matches!(cost, Cost::Sad | Cost::BirchfieldTomasi),
            "color-cost",
            "on".into(),
            format!("off with cost {cost}"),
            "take cost sad or bt",
        )?;
        check(
            self.weighted_median.is_none_or(|radius| (1..=15).contains(&radius)),
            "weighted-median",
            self.weighted_median.unwrap_or_default().to_string(),
            "off, or a radius from 1 to 15 px".into(),
            "5 is usual",
        )?;
        check(
            (1..=255).contains(&self.weighted_median_sigma),
            "weighted-median-sigma",
            self.weighted_median_sigma.to_string(),
            "from 1 to 255".into(),
            "20 is usual",
        )?;
        check(
            self.ad_weight + self.census_weight > 0,
            "ad-weight",
            "0".into(),
            "more than 0 if census-weight is 0".into(),
            "8 and 32 are usual",
        )?;
        let most_cap = match self.cost {
            Cost::SadXy => 63,
            Cost::CensusSobel => (255 - 2 * self.census_bits()) / 4,
            _ => Self::MAX_CAP,
        };
        check(
            (1..=most_cap).contains(&self.prefilter_cap),
            "prefilter-cap",
            self.prefilter_cap.to_string(),
            match most_cap {
                Self::MAX_CAP => format!("from 1 to {most_cap}"),
                _ => format!("from 1 to {most_cap} with this cost, whose largest value for a pixel must fit a byte"),
            },
            "24 is usual",
        )
    }

    /// A rectification and masks are for pairs of one size. Whatever takes pairs asks for it itself.
    ///
    /// # Errors
    /// [`Error::Image`] if pairs of `width` x `height` pixels are not of it.
    pub fn accepts(&self, width: u32, height: u32) -> Result<(), Error> {
        self.rectify.as_ref().map_or(Ok(()), |rectification| rectification.accepts(width, height))?;
        self.masks.as_ref().map_or(Ok(()), |masks| masks.accepts(width, height))
    }

    /// The same for images that are halved so often, without what comes after the map of the left view.
    pub(crate) fn rough(&self, halvings: u32) -> Self {
        let last = self.min_disparity + self.disparities as i32 - 1;
        let (from, to) = (self.min_disparity >> halvings, -(-last >> halvings));
        Self {
            min_disparity: from,
            disparities: (to - from + 1) as u32,
            adaptive_p2: false,
            texture: 0,
            lr_check: Some(1),
            right_view: RightView::Diagonal,
            speckle_window: 0,
            median: Median::Off,
            fill: Fill::None,
            weighted_median: None,
            wls: None,
            confidence: false,
            right_map: false,
            depth: None,
            rectify: None,
            masks: None,
            ..self.clone()
        }
    }

    /// Whether anything reads the right view.
    pub(crate) fn reads_right_view(&self) -> bool {
        self.right_map || self.lr_check.is_some() || matches!(self.fill, Fill::Rays | Fill::Hirschmuller)
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
        let scale = crate::reference::matching_cost_scale(self);
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
}
