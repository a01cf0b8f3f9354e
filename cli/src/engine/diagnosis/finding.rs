//! Findings: what is wrong with a pair, and what to do about it.

use std::fmt;
use std::ops::RangeInclusive;

/// What is wrong with a pair.
#[derive(Clone, Debug, PartialEq)]
pub enum Finding {
    /// Both images show the same view.
    Same,
    /// An image has hardly any contrast.
    Flat { side: &'static str, levels: u8 },
    /// Hardly any corner of the left image is in the right one.
    Unrelated { found: usize, of: usize },
    /// The right image is the partner once it is turned.
    Turned { how: &'static str },
    /// What is near lies farther right in the right image.
    Exchanged { negative: usize, of: usize },
    /// Partners lie in other rows: in the middle by `offset` px lower, at most by `most` px.
    Rows { offset: f64, degrees: f64, most: f64 },
    /// Disparities lie outside the range.
    Range { searched: RangeInclusive<i32>, needed: RangeInclusive<i32>, share: f64, of: usize },
    /// Much of a map lies at an end of the range.
    Pressed { searched: RangeInclusive<i32>, share: f64, is_last: bool },
}

impl Finding {
    /// The kind of finding, without its figures.
    pub fn kind(&self) -> std::mem::Discriminant<Self> {
        std::mem::discriminant(self)
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Same => f.write_str(
                "LEFT and RIGHT are the same image (one file given twice?), so every disparity is 0; give both views",
            ),
            Self::Flat { side, levels } => write!(
                f,
                "the {side} image is one gray (its samples differ by {levels} of 255), so nothing can be matched; check \
                 the camera and the exposure"
            ),
            Self::Unrelated { found, of } => write!(
                f,
                "LEFT and RIGHT look like unrelated pictures ({found} of {of} corners have a partner); give two views of \
                 one scene, taken at once"
            ),
            Self::Turned { how } => {
                write!(f, "RIGHT is {how} compared with LEFT, so nothing matches; turn one of the two and run again")
            }
            Self::Exchanged { negative, of } => write!(
                f,
                "LEFT and RIGHT look exchanged ({negative} of {of} corners have a negative disparity); swap them, or add \
                 --swap"
            ),
            Self::Rows { offset, degrees, most } => {
                write!(f, "rows do not match: RIGHT is ")?;
                let way = if *offset < 0.0 { "higher" } else { "lower" };
                write!(f, "{:.1} px {way} in the middle", offset.abs())?;
                if degrees.abs() >= 0.05 {
                    let way = if *degrees < 0.0 { "counterclockwise" } else { "clockwise" };
                    write!(f, " and rotated by {:.1} degrees {way}", degrees.abs())?;
                }
                write!(f, ", up to {most:.1} px; rectify the pair, for example with --rectify FILE")
            }
            Self::Pressed { searched, share, is_last } => {
                let percent = 100.0 * share;
                let (first, last) = (searched.start(), searched.end());
                match is_last {
                    true => write!(
                        f,
                        "{percent:.0} % of the map lie at {last} px, where the range ends, so what is nearer is wrong or has "
                    )?,
                    false => write!(
                        f,
                        "{percent:.0} % of the map lie at {first} px, where the range begins, so what is farther is wrong or has "
                    )?,
                }
                write!(f, "no disparity; give --min-disp and --disp of a larger range than {first} to {last} px")
            }
            Self::Range { searched, needed, share, of } => {
                let (first, last) = (*needed.start(), *needed.end());
                let percent = 100.0 * share;
                write!(
                    f,
                    "the range of disparities is too small: {percent:.0} % of {of} corners lie outside {} to {} px; try ",
                    searched.start(),
                    searched.end()
                )?;
                if first < *searched.start() {
                    write!(f, "--min-disp {first} ")?;
                }
                // Rounded up to a multiple of 16.
                write!(f, "--disp {}", (last - first + 1 + 15) / 16 * 16)
            }
        }
    }
}
