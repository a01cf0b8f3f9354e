//! What a setting may be, where it is one of several.

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
    /// A path for neighbouring invocations, 16 disparities each. They exchange values through the subgroup, or through
    /// workgroup memory where the device has no subgroups. For GPUs.
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

impl Census {
    /// Bits of a census string.
    pub(crate) fn bits(self) -> u32 {
        match self {
            Self::Five => 24,
            Self::Seven => 48,
            Self::NineBySeven => 62,
            Self::CentreSymmetric => 31,
        }
    }

    /// Bytes of a census string: one a row, and one for the ninth column.
    pub(crate) fn planes(self) -> u32 {
        match self {
            Self::Five => 5,
            Self::Seven => 7,
            Self::NineBySeven => 8,
            Self::CentreSymmetric => 4,
        }
    }
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
    /// Belief propagation on the Markov random field of all pixels: Felzenszwalb and Huttenlocher, "Efficient Belief Propagation for
    /// Early Vision", International Journal of Computer Vision 70(1), 2006.
    Bp,
    /// A network, [`Params::network`](crate::Params::network), in place of all stages from the cost to the winner: Chang and
    /// Chen, "Pyramid Stereo Matching Network", CVPR 2018. docs/NETWORKS.md defines it.
    Psmnet,
}

impl Method {
    /// Whether it starts from the quantised cost of each pixel and disparity.
    pub(crate) fn quantises(self) -> bool {
        match self {
            Self::Sgm | Self::Bp => true,
            Self::Bm | Self::Psmnet => false,
        }
    }
}

/// How the smoothness grows with the difference between the disparities of two neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Smoothness {
    /// In proportion to the difference.
    Linear,
    /// With its square.
    Quadratic,
    /// The same for every difference: the Potts model.
    Potts,
}

/// Directions along which semi-global matching aggregates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Paths {
    /// Both horizontal directions and the downward one: those of OpenCV's `MODE_SGBM_3WAY`.
    Three,
    /// Both horizontal and both vertical directions.
    Four,
    /// Both horizontal directions, the downward one and the two diagonal ones downwards: OpenCV's `MODE_SGBM`.
    Five,
    /// Horizontal, vertical and diagonal: eight.
    Eight,
    /// The eight, and eight that go two pixels along one axis and one along the other.
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
    /// The costs of the left view, read along the diagonal: takes almost no time.
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
    /// Holes stay.
    None,
    /// The farther of the two neighbours in the row, as the KITTI development kit does.
    Background,
    /// Occlusions by the farther neighbour in the row, then mismatches by the median along eight rays.
    Rays,
    /// As rays, but less sensitive to single values: occlusions by the farther of the medians of three on either side in the row;
    /// where only one side has values, at a row's ends, its median is led on by the slope there, by at most 4 px. Then mismatches by
    /// the median along eight rays, weighted by how near the gray of a value's pixel is, as in
    /// [`Params::weighted_median`](crate::Params::weighted_median).
    WeightedRays,
    /// Occlusions by the second lowest and mismatches by the median along eight rays: Hirschmüller 2008, section 2.6.
    Hirschmuller,
}

impl Fill {
    /// Whether it tells occlusions from mismatches, by the right view.
    pub(crate) fn reads_right(self) -> bool {
        match self {
            Self::Rays | Self::WeightedRays | Self::Hirschmuller => true,
            Self::None | Self::Background => false,
        }
    }
}

/// Edge-preserving smoothing of the map, guided by the left image: Min et al., "Fast Global Image Smoothing Based on
/// Weighted Least Squares", IEEE TIP 23(12), 2014.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Wls {
    /// Strength of the smoothing: 4 keeps the accuracy; 8000, usual with OpenCV, looks smoother and is less accurate.
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

/// Settings that go well together ([`Params::preset`](crate::Params::preset)).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Preset {
    /// The plain chain, [`Params::sgm`](crate::Params::sgm), and the speckle filter.
    Classic,
    /// As balanced, along three directions.
    Fast,
    /// Census strings and gradients, four directions, P2 by the intensity step.
    #[default]
    Balanced,
    /// As balanced, and only what a second match confirms.
    Strict,
    /// As balanced, with every hole filled, and aggregated twice.
    Dense,
    /// As dense, with costs that are learned beside its own, and with holes in place of what is doubtful.
    Accurate,
}
