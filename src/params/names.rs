//! The names of the values of enumerations; those of the costs stand in their table.

use crate::Error;
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
    )+

        /// A test of each.
        #[cfg(test)]
        pub(super) const CHECKS: &[fn()] = &[$(tests::text_and_value_are_inverse::<$kind>),+];
    };
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

        /// As its name.
        #[cfg(feature = "serde")]
        impl ::serde::Serialize for $kind {
            fn serialize<S: ::serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
                to.serialize_str($crate::params::names::Named::name(*self))
            }
        }

        #[cfg(feature = "serde")]
        impl<'de> ::serde::Deserialize<'de> for $kind {
            fn deserialize<D: ::serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
                let name = String::deserialize(from)?;
                $crate::params::names::named(&name).map_err(::serde::de::Error::custom)
            }
        }
    };
}
pub(crate) use words;

/// The value of a name.
pub(crate) fn named<T: Named>(name: &str) -> Result<T, Error> {
    T::of(name).ok_or_else(|| Error::no_name(T::OPTION, name, T::NAMES.iter().map(|(known, _)| *known)))
}

names! {
    Preset "preset" {
        Classic "classic" "the plain chain and a speckle filter",
        Fast "fast" "both derivatives, along three directions",
        Balanced "balanced" "census and gradients, P2 by the intensity step",
        Strict "strict" "balanced, and only what a second match confirms",
        Dense "dense" "balanced, aggregated twice, and every hole filled",
        Accurate "accurate" "learned costs beside those of balanced, aggregated twice, confirmed by a second match",
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
        WeightedRays "weighted-rays" "as rays, by medians: of three in the row, and weighted by gray",
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::Cost;

    /// Of one enumeration: each value has a name of its own, and is made of it again; all else is refused with all names.
    pub(super) fn text_and_value_are_inverse<T>()
    where
        T: Named + PartialEq + std::fmt::Debug + std::fmt::Display + std::str::FromStr<Err = Error>,
    {
        assert!(T::VALUES.len() > 1 && T::VALUES.len() == T::NAMES.len());
        for (&value, (name, _)) in T::VALUES.iter().zip(T::NAMES) {
            assert_eq!((value.to_string().as_str(), value.name()), (*name, *name), "{value:?}");
            assert_eq!(name.parse::<T>().unwrap(), value);
            assert_eq!(format!("{value:>20}").trim_start(), *name, "{value:?} is not padded as text");
            for wrong in [format!("{name} "), name.to_uppercase() + "!", String::new()] {
                let Err(Error::Parameter { name: option, allowed, .. }) = wrong.parse::<T>() else {
                    panic!("{wrong:?}")
                };
                assert!(option == T::OPTION && T::NAMES.iter().all(|(name, _)| allowed.contains(name)), "{allowed}");
            }
        }
    }

    #[test]
    fn every_value_is_made_of_its_name_again() {
        assert_eq!(CHECKS.len(), 11);
        CHECKS.iter().for_each(|check| check());
        text_and_value_are_inverse::<Cost>();
    }
}
