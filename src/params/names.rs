//! The names of the values of enumerations; those of the costs stand in their table.

use crate::Error;
use crate::params::check::{joined, refused};
use crate::params::choices::{
    Census, Fill, Median, Method, Paths, Prefilter, Preset, RightView, Schedule, Smoothness, Subpixel,
};

/// An enumeration whose values have names.
pub(crate) trait Named: Copy + 'static {
    /// Every value with its name and a few words.
    const NAMES: &'static [(&'static str, &'static str)];
    const VALUES: &'static [Self];
    /// The option that takes them.
    const OPTION: &'static str;

    fn name(self) -> &'static str;

    fn of(name: &str) -> Option<Self> {
        Self::NAMES.iter().position(|(known, _)| *known == name).map(|i| Self::VALUES[i])
    }
}

/// The names of enumerations, and that no value was forgotten.
macro_rules! names {
    ($($kind:ident $option:literal { $($value:ident $name:literal $help:literal,)+ })+) => {$(
        impl Named for $kind {
            const NAMES: &'static [(&'static str, &'static str)] = &[$(($name, $help)),+];
            const VALUES: &'static [Self] = &[$(Self::$value),+];
            const OPTION: &'static str = $option;

            fn name(self) -> &'static str {
                match self {
                    $(Self::$value => $name,)+
                }
            }
        }

        words!($kind);
    )+};
}

/// An enumeration whose values have names, as text and from text.
macro_rules! words {
    ($kind:ident) => {
        impl std::fmt::Display for $kind {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad($crate::params::names::Named::name(*self))
            }
        }

        impl std::str::FromStr for $kind {
            type Err = $crate::Error;

            /// The value of this name, as the command takes it.
            fn from_str(name: &str) -> Result<Self, $crate::Error> {
                $crate::params::names::named(name)
            }
        }
    };
}
pub(crate) use words;

/// The value of a name.
pub(crate) fn named<T: Named>(name: &str) -> Result<T, Error> {
    let allowed = || format!("one of {}", joined(T::NAMES, ", "));
    T::of(name).ok_or_else(|| refused(T::OPTION, name, allowed()))
}

names! {
    Preset "preset" {
        Classic "classic" "the plain chain and a speckle filter",
        Fast "fast" "both derivatives, along three directions",
        Balanced "balanced" "census and gradients, P2 by the intensity step",
        Strict "strict" "balanced, and only what a second match confirms",
        Dense "dense" "balanced, and every hole filled",
    }
    Method "method" {
        Sgm "sgm" "semi-global matching",
        Bm "bm" "block matching",
        Bp "bp" "belief propagation",
        Psmnet "psmnet" "a network, whose --weights are given",
    }
    Smoothness "smoothness" {
        Linear "linear" "in proportion to the difference",
        Quadratic "quadratic" "with its square",
        Potts "potts" "the same for every difference",
    }
    Census "census" {
        Five "5x5" "24 bits",
        Seven "7x7" "48 bits",
        NineBySeven "9x7" "62 bits",
        CentreSymmetric "cs9x7" "31 pairs of opposite pixels",
    }
    Prefilter "prefilter" {
        XSobel "xsobel" "horizontal derivative, clipped",
        Sobel "sobel" "gradient magnitude, clipped",
        Normalized "normalized" "difference from the mean of a window, clipped",
        None "none" "the gray image",
    }
    Paths "paths" {
        Three "3" "horizontal and downwards",
        Four "4" "horizontal and vertical",
        Five "5" "horizontal, and all three downwards",
        Eight "8" "diagonal, too",
        Sixteen "16" "and between those",
    }
    RightView "right-view" {
        Diagonal "diagonal" "from the costs of the left view",
        Match "match" "a second match: twice the time",
    }
    Subpixel "subpixel" {
        Parabola "parabola" "through three costs; on is the same",
        Equiangular "equiangular" "two lines of equal and opposite slope",
        Off "off" "whole pixels",
    }
    Median "median" {
        Three "3" "3x3 pixels",
        Five "5" "5x5 pixels",
        Off "off" "no filter",
    }
    Fill "fill" {
        None "none" "holes stay",
        Background "background" "the farther neighbour in the row",
        Rays "rays" "occlusions by the row, mismatches by the median of 8 rays",
        Hirschmuller "hirschmuller" "second lowest and median of 8 rays",
    }
    Schedule "schedule" {
        Auto "auto" "as the adapter is",
        PerThread "per-thread" "a path an invocation, for CPU adapters",
        PerSubgroup "per-subgroup" "a path for several, for GPUs",
    }
}

impl Preset {
    /// Every preset by name, with a few words.
    pub const NAMES: &'static [(&'static str, &'static str)] = <Self as Named>::NAMES;
}
