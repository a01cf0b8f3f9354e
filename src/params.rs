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
    /// The gray image itself.
    None,
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
    /// The four, and the four diagonal ones.
    Eight,
}

impl Paths {
    /// The number of directions.
    pub fn count(self) -> u32 {
        match self {
            Self::Three => 3,
            Self::Four => 4,
            Self::Eight => 8,
        }
    }
}

/// The last filter of the chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Median {
    /// No filter.
    Off,
    /// Median of 3x3 pixels.
    Three,
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
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct Params {
    /// Smallest disparity in pixels, negative allowed.
    pub min_disparity: i32,
    /// Number of disparities searched: `min_disparity ..= min_disparity + disparities - 1`.
    pub disparities: u32,
    /// How the winner is found.
    pub method: Method,
    /// Directions of [`Method::Sgm`].
    pub paths: Paths,
    /// Side of the square block in pixels: odd, 1 to 51.
    pub block: u32,
    /// The image on which costs are computed.
    pub prefilter: Prefilter,
    /// Clip of the prefilter, 1 to 127.
    pub prefilter_cap: u32,
    /// Penalty of a disparity step of 1 between neighbours on a path, in units of the quantised cost (0 to 89), 0 to P2.
    pub p1: u32,
    /// Penalty of a larger disparity step, in the same units, P1 to 127.
    pub p2: u32,
    /// Uniqueness in per cent, 0 to 99; 0 switches the test off.
    pub uniqueness: u32,
    /// Largest difference in pixels between the left and the right view's disparity; `None` switches the check off.
    pub lr_check: Option<u32>,
    /// The last filter.
    pub median: Median,
    /// Refine the winner to 1/16 pixel with a parabola.
    pub subpixel: bool,
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
            paths: Paths::Four,
            block: 5,
            prefilter: Prefilter::XSobel,
            prefilter_cap: 31,
            p1: 16,
            p2: 96,
            uniqueness: 10,
            lr_check: Some(1),
            median: Median::Three,
            subpixel: true,
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
        )
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
            Prefilter::XSobel | Prefilter::Sobel => 2 * self.prefilter_cap,
            Prefilter::None => 255,
        }
    }
}
