//! The ranges of the settings, and which go together.

use crate::Error;
use crate::params::names::Named;
use crate::params::{Camera, Cost, Method, Params, Wls};

/// The largest difference between two disparities, in pixels.
const MAX_DIFFERENCE: u32 = 2 * Params::MAX_ABS_DISPARITY as u32 + 1;

fn check(
    ok: bool,
    name: &'static str,
    given: impl ToString,
    allowed: impl Into<String>,
    remedy: &'static str,
) -> Result<(), Error> {
    if ok { Ok(()) } else { Err(Error::Parameter { name, given: given.to_string(), allowed: allowed.into(), remedy }) }
}

impl Params {
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
        self.validate_disparities()?;
        self.validate_windows()?;
        self.validate_penalties()?;
        self.validate_checks()?;
        self.validate_filters()?;
        self.depth.as_ref().map_or(Ok(()), Camera::validate)?;
        self.validate_cost()
    }

    fn validate_disparities(&self) -> Result<(), Error> {
        let limit = Self::MAX_ABS_DISPARITY;
        check(
            (-limit..=limit).contains(&self.min_disparity),
            "min-disp",
            self.min_disparity,
            format!("from -{limit} to {limit}"),
            "shift the images against each other if they really are that far apart",
        )?;
        let room = (limit - self.min_disparity + 1) as u32;
        check(
            (1..=room).contains(&self.disparities),
            "disp",
            self.disparities,
            format!("from 1 to {room} (the largest disparity is {limit})"),
            "take the number of disparities that the scene spans",
        )
    }

    fn validate_windows(&self) -> Result<(), Error> {
        check(
            self.block % 2 == 1 && self.block <= Self::MAX_BLOCK,
            "block",
            self.block,
            format!("odd and from 1 to {}", Self::MAX_BLOCK),
            "take an odd number in that range",
        )?;
        check(
            self.prefilter_window % 2 == 1 && (3..=Self::MAX_BLOCK).contains(&self.prefilter_window),
            "prefilter-window",
            self.prefilter_window,
            format!("odd and from 3 to {}", Self::MAX_BLOCK),
            "9 is usual",
        )
    }

    fn validate_penalties(&self) -> Result<(), Error> {
        check(
            self.p2 <= Self::MAX_P2,
            "p2",
            self.p2,
            format!("from p1 to {}, in units of the quantised cost (0 to 89)", Self::MAX_P2),
            "4 to 8 times p1 is usual",
        )?;
        check(self.p1 <= self.p2, "p1", self.p1, format!("from 0 to p2, which is {}", self.p2), "lower p1 or raise p2")
    }

    /// What drops disparities of the winner.
    fn validate_checks(&self) -> Result<(), Error> {
        check(self.uniqueness <= 99, "uniqueness", self.uniqueness, "from 0 (off) to 99 per cent", "10 is usual")?;
        check(
            self.lr_check.is_none_or(|px| px <= MAX_DIFFERENCE),
            "lr-check",
            self.lr_check.unwrap_or_default(),
            format!("off, or from 0 to {MAX_DIFFERENCE} px"),
            "1 is usual",
        )?;
        check(
            self.texture <= Self::MAX_TEXTURE,
            "texture",
            self.texture,
            format!("from 0 (off) to {}", Self::MAX_TEXTURE),
            "a few units for each pixel of the block are usual",
        )
    }

    fn validate_filters(&self) -> Result<(), Error> {
        check(
            self.speckle_range <= MAX_DIFFERENCE,
            "speckle-range",
            self.speckle_range,
            format!("from 0 to {MAX_DIFFERENCE} px"),
            "1 or 2 is usual",
        )?;
        check(
            self.speckle_window <= i32::MAX as u32,
            "speckle-window",
            self.speckle_window,
            format!("from 0 (off) to {} px", i32::MAX),
            "100 is usual",
        )?;
        check(
            self.weighted_median.is_none_or(|radius| (1..=15).contains(&radius)),
            "weighted-median",
            self.weighted_median.unwrap_or_default(),
            "off, or a radius from 1 to 15 px",
            "5 is usual",
        )?;
        check(
            (1..=255).contains(&self.weighted_median_sigma),
            "weighted-median-sigma",
            self.weighted_median_sigma,
            "from 1 to 255",
            "20 is usual",
        )?;
        let Some(Wls { lambda, sigma }) = self.wls else { return Ok(()) };
        check((0.0..=1e6).contains(&lambda), "wls-lambda", lambda, "from 0 to 1000000", "4 is usual")?;
        check((0.1..=1000.0).contains(&sigma), "wls-sigma", sigma, "from 0.1 to 1000", "1 to 2 is usual")
    }

    /// What is allowed with this cost.
    fn validate_cost(&self) -> Result<(), Error> {
        for (name, weight) in [("ad-weight", self.ad_weight), ("census-weight", self.census_weight)] {
            let allowed = format!("from 0 to {} sixteenths", Self::MAX_WEIGHT);
            check(weight <= Self::MAX_WEIGHT, name, weight, allowed, "16 counts once")?;
        }
        let none = self.ad_weight + self.census_weight == 0;
        check(!none, "ad-weight", 0, "more than 0 if census-weight is 0", "8 and 32 are usual")?;
        let (cost, method, row) = (self.cost, self.method, self.cost.row());
        check(
            row.methods.contains(&method),
            "cost",
            cost,
            format!("another one with method {method}"),
            match method {
                Method::Sgm => "take method bm or another cost",
                Method::Bm => "take method sgm or another cost",
            },
        )?;
        let [least, most] = [row.blocks.start(), row.blocks.end()];
        check(
            row.blocks.contains(&self.block),
            "block",
            self.block,
            format!("odd and from {least} to {most} with cost {cost}"),
            "take an odd number in that range",
        )?;
        let in_colour = Cost::VALUES.iter().filter(|cost| cost.row().color).map(|cost| cost.name());
        check(
            !self.color_cost || row.color,
            "color-cost",
            "on",
            format!("off with cost {cost} (on is for {})", in_colour.collect::<Vec<_>>().join(", ")),
            "switch it off or take one of those",
        )?;
        let most_cap = self.largest_cap();
        let why = match most_cap {
            Self::MAX_CAP => "",
            _ => " with this cost, whose largest value for a pixel must fit a byte",
        };
        check(
            (1..=most_cap).contains(&self.prefilter_cap),
            "prefilter-cap",
            self.prefilter_cap,
            format!("from 1 to {most_cap}{why}"),
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
}
