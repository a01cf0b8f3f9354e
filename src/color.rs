//! The colours of a disparity map: the same on the host, in the command's pictures and in textures.

use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;

use crate::{DisparityMap, Error};

/// A map from a share of a range to a colour. No colour is near black, which stands for no disparity: where a map begins or
/// ends nearly black, that part is left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Colors {
    /// Blue, green, yellow, red.
    #[default]
    Turbo,
    /// Purple, red, yellow, white.
    Inferno,
    /// Purple, pink, white.
    Magma,
    /// Purple, orange, yellow.
    Plasma,
    /// Blue, green, yellow.
    Viridis,
    /// Blue, gray, yellow: alike to all eyes.
    Cividis,
    /// Dark gray to white.
    Gray,
}

impl Colors {
    /// All of them, by the names that the command has.
    pub const ALL: [(&'static str, Self); 7] = [
        ("turbo", Self::Turbo),
        ("inferno", Self::Inferno),
        ("magma", Self::Magma),
        ("plasma", Self::Plasma),
        ("viridis", Self::Viridis),
        ("cividis", Self::Cividis),
        ("gray", Self::Gray),
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, colors)| *colors == self).map_or("", |(name, _)| name)
    }

    /// Red, green and blue of a share from 0 to 1, of small disparities to large ones; shares below and above are clamped.
    pub fn at(self, share: f64) -> [u8; 3] {
        // What is left out would be darker than a sixth of white.
        let (map, first, last) = match self {
            Self::Turbo => (Some(colorous::TURBO), 0.08, 0.97),
            Self::Inferno => (Some(colorous::INFERNO), 0.32, 1.0),
            Self::Magma => (Some(colorous::MAGMA), 0.3, 1.0),
            Self::Plasma => (Some(colorous::PLASMA), 0.28, 1.0),
            Self::Viridis => (Some(colorous::VIRIDIS), 0.1, 1.0),
            Self::Cividis => (Some(colorous::CIVIDIS), 0.1, 1.0),
            Self::Gray => (None, 0.25, 1.0),
        };
        let place = first + share.clamp(0.0, 1.0) * (last - first);
        match map {
            Some(map) => {
                let color = map.eval_continuous(place);
                [color.r, color.g, color.b]
            }
            None => [(place * 255.0).round() as u8; 3],
        }
    }
}

impl fmt::Display for Colors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Colors {
    type Err = Error;

    /// Those of this name.
    fn from_str(text: &str) -> Result<Self, Error> {
        let named = Self::ALL.iter().find(|(name, _)| *name == text).map(|(_, colors)| *colors);
        named.ok_or_else(|| Error::no_name("colors", text, Self::ALL.iter().map(|(name, _)| *name)))
    }
}

/// Red, green and blue of a share of a range in the colour map turbo, without its dark ends: 0 is blue, 1 is red; shares below
/// and above are clamped. No colour is near black.
pub fn turbo(share: f64) -> [u8; 3] {
    Colors::Turbo.at(share)
}

/// The colour of a disparity in 1/16 px; black for [`DisparityMap::INVALID`].
fn color(value: i32, first: i32, last: i32, colors: Colors) -> [u8; 4] {
    let [red, green, blue] = match value == i32::from(DisparityMap::INVALID) {
        true => [0; 3],
        false => colors.at((f64::from(value) / 16.0 - f64::from(first)) / span(first, last)),
    };
    [red, green, blue, 255]
}

fn span(first: i32, last: i32) -> f64 {
    (f64::from(last) - f64::from(first)).max(1.0)
}

/// The colours of all values from the first one of a range of disparities on; values above the last have its colour.
pub(crate) fn table(range: &RangeInclusive<i32>) -> Vec<[u8; 4]> {
    let (first, last) = (*range.start(), *range.end());
    (0..=16 * span(first, last) as i32).map(|i| color(16 * first + i, first, last, Colors::Turbo)).collect()
}

impl DisparityMap {
    /// A picture of the map: red, green, blue and 255 for each pixel, in the [`turbo`] colours of its place in the range
    /// (mostly [`crate::Params::searched`]), black where there is no disparity.
    ///
    /// ```
    /// # use gpu_stereo::{DisparityMap, Params, turbo};
    /// let map = DisparityMap { width: 2, height: 1, data: vec![16 * 63, DisparityMap::INVALID] };
    /// let [red, green, blue] = turbo(1.0);
    /// assert_eq!(map.color(&Params::sgm(64).searched()), [red, green, blue, 255, 0, 0, 0, 255]);
    /// ```
    pub fn color(&self, range: &RangeInclusive<i32>) -> Vec<u8> {
        self.color_by(range, Colors::Turbo)
    }

    /// As [`DisparityMap::color`], in the colours of another map.
    pub fn color_by(&self, range: &RangeInclusive<i32>, colors: Colors) -> Vec<u8> {
        self.data.iter().flat_map(|&value| color(value.into(), *range.start(), *range.end(), colors)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_colour_is_near_that_of_no_disparity() {
        for (name, colors) in Colors::ALL {
            for share in 0..=1000 {
                let [red, green, blue] = colors.at(f64::from(share) / 1000.0).map(f64::from);
                let luma = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
                assert!(luma > 40.0, "{name} {share}: {red} {green} {blue}, {luma}");
            }
            assert_eq!(colors.at(-1.0), colors.at(0.0));
            assert_eq!(colors.at(f64::INFINITY), colors.at(1.0));
            assert_ne!(colors.at(0.0), colors.at(1.0));
        }
    }
}
