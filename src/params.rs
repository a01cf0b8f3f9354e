//! What a user may ask for, and the checks that come before anything touches a device.

use crate::{Error, Schedule};

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
pub struct Wls {
    /// Strength of the smoothing; 8000 is usual.
    pub lambda: f32,
    /// Intensity step that stops it; 1 to 2 is usual.
    pub sigma: f32,
}

/// What a user may ask for. Start from [`Params::sgm`] or [`Params::bm`] and change what differs.
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
    /// Compile the kernels with checks of every index and loop: slower, the same result. For a device that misbehaves.
    pub shader_checks: bool,
    /// How the kernels are laid out on the device; the same result.
    pub schedule: Schedule,
}

impl Params {
    /// The largest disparity, and minus the smallest, that can be asked for: 1/16 pixel of it fit an `i16`.
    pub const MAX_ABS_DISPARITY: i32 = 2047;
    /// The largest block side.
    pub const MAX_BLOCK: u32 = 51;
    /// The largest clip of a prefilter: twice it fits a byte.
    pub const MAX_CAP: u32 = 127;
    /// The largest P2: a forward and a backward path without their costs, at most P2 each, sum in a byte.
    pub const MAX_P2: u32 = 127;

    /// The classic chain with semi-global matching over `disparities` disparities from 0.
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
            shader_checks: false,
            schedule: Schedule::Auto,
        }
    }

    /// The classic chain with block matching over `disparities` disparities from 0.
    pub fn bm(disparities: u32) -> Self {
        Self { method: Method::Bm, block: 15, uniqueness: 15, ..Self::sgm(disparities) }
    }

    /// Checks every range.
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
            "take the next odd number",
        )?;
        check(
            (1..=Self::MAX_CAP).contains(&self.prefilter_cap),
            "prefilter-cap",
            self.prefilter_cap.to_string(),
            format!("from 1 to {}", Self::MAX_CAP),
            "31 is usual",
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
        )
    }

    /// The settings of a second match of the mirrored pair for the right view, if that is wanted and something reads it:
    /// whole pixels, and all of them.
    pub(crate) fn second_match(&self) -> Option<Self> {
        let wanted = self.right_view == RightView::Match && self.lr_check.is_some();
        wanted.then(|| Self {
            subpixel: Subpixel::Off,
            uniqueness: 0,
            texture: 0,
            confidence: false,
            right_view: RightView::Diagonal,
            ..self.clone()
        })
    }

    /// Rows and columns by which a block reaches beyond its centre.
    pub(crate) fn radius(&self) -> u32 {
        self.block / 2
    }

    /// Vectors of 16 disparities that hold a pixel's.
    pub(crate) fn quads(&self) -> u32 {
        self.disparities.div_ceil(16)
    }

    /// The largest value of the prefiltered image.
    pub(crate) fn prefiltered_max(&self) -> u32 {
        match self.prefilter {
            Prefilter::XSobel | Prefilter::Sobel | Prefilter::Normalized => 2 * self.prefilter_cap,
            Prefilter::None => 255,
        }
    }
}
