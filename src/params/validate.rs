//! The ranges of the settings, and which go together.

use crate::Error;
use crate::features::LEFT_OUT;
use crate::params::check::check;
use crate::params::names::Named;
use crate::params::{Camera, Cost, Filter, Method, Params, RightView};

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
    /// [`Error::Parameter`] for the first parameter outside its range; [`Error::Network`] if the method needs a network and
    /// has none.
    pub fn validate(&self) -> Result<(), Error> {
        self.validate_options()?;
        if self.method == Method::Psmnet && self.network.is_none() {
            let text = "method psmnet needs a network; give a file of its weights (--weights, Params::network)";
            return Err(Error::Network(text.into()));
        }
        Ok(())
    }

    /// The same for all that has a name: the network is given in another way.
    pub(super) fn validate_options(&self) -> Result<(), Error> {
        self.validate_disparities()?;
        self.validate_windows()?;
        self.validate_penalties()?;
        self.validate_smoothness()?;
        self.validate_filters()?;
        self.depth.as_ref().map_or(Ok(()), Camera::validate)?;
        if self.method == Method::Psmnet {
            return self.validate_psmnet();
        }
        self.validate_cost()?;
        self.validate_passes()
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
        check(
            self.p1 <= self.p2,
            "p1",
            self.p1,
            format!("from 0 to p2, which is {}", self.p2),
            "lower p1 or raise p2",
        )?;
        check((1..=255).contains(&self.p2_step), "p2-step", self.p2_step, "from 1 to 255 gray levels", "10 is usual")?;
        check((1..=2).contains(&self.passes), "passes", self.passes, "1 or 2", "1 is usual, 2 is more accurate")
    }

    /// A path cost of the second pass fits a byte: the cost, half of P2, rounded up, and P2.
    fn validate_passes(&self) -> Result<(), Error> {
        let (cost, largest) = (self.cost, self.largest_cost());
        let most = (0..=Self::MAX_P2).rev().find(|p2| largest + p2.div_ceil(2) + p2 <= 255).unwrap_or(0);
        check(
            !self.aggregates_twice() || self.p2 <= most,
            "p2",
            self.p2,
            format!("from p1 to {most} with passes 2 and cost {cost}"),
            "lower p2 or take passes 1",
        )
    }

    fn validate_smoothness(&self) -> Result<(), Error> {
        let most = Self::MAX_SMOOTHNESS;
        let units = format!("from 0 to {most}, in units of the quantised cost (0 to 89)");
        check(self.smoothness_weight <= most, "smoothness-weight", self.smoothness_weight, &units, "2 is usual")?;
        let truncation = self.smoothness_truncation;
        check(truncation <= most, "smoothness-truncation", truncation, units, "10 times the weight is usual")?;
        let edge = self.smoothness_edge.unwrap_or(1);
        check((1..=255).contains(&edge), "smoothness-edge", edge, "off or from 1 to 255 gray levels", "10 is usual")?;
        for (name, value, least, most, remedy) in [
            ("bp-levels", self.bp_levels, 1, 10, "5 is usual"),
            ("bp-iterations", self.bp_iterations, 1, 1000, "60 is usual"),
            ("bp-reweighting", self.bp_reweighting, 4, 16, "8 is usual, and 16 plain belief propagation"),
        ] {
            check((least..=most).contains(&value), name, value, format!("from {least} to {most}"), remedy)?;
        }
        Ok(())
    }

    /// The ranges of the filters are in their rows.
    fn validate_filters(&self) -> Result<(), Error> {
        check(self.uniqueness <= 99, "uniqueness", self.uniqueness, "from 0 (off) to 99 per cent", "10 is usual")?;
        // Of two faults the first is reported: lr-check before texture.
        Filter::LrCheck.validate(self)?;
        Filter::ALL.iter().try_for_each(|filter| filter.validate(self))
    }

    /// What is allowed with a network, which has no costs.
    fn validate_psmnet(&self) -> Result<(), Error> {
        check(self.min_disparity == 0, "min-disp", self.min_disparity, "0 with method psmnet", "leave it away")?;
        check(
            self.disparities.is_multiple_of(16) && self.disparities <= Self::MOST_OF_NETWORK,
            "disp",
            self.disparities,
            format!("a multiple of 16 up to {} with method psmnet", Self::MOST_OF_NETWORK),
            "take the next larger multiple; 192 is usual",
        )?;
        let diagonal = self.right_view == RightView::Diagonal && self.reads_right_view();
        let (given, remedy) = (self.right_view, "take match, which computes the right view's map by a second run");
        check(!diagonal, "right-view", given, "match with method psmnet, since a network has no costs", remedy)?;
        let allowed = "off with method psmnet, since a network has no costs to compare";
        check(!self.confidence, "confidence", "on", allowed, "switch it off or take method sgm")
    }

    /// What is allowed with this cost.
    fn validate_cost(&self) -> Result<(), Error> {
        let (sixteenths, in_64ths) = (("sixteenths", "16 counts once"), ("64ths", "64 counts once"));
        let of_census = if self.cost == Cost::LearnedCensus { in_64ths } else { sixteenths };
        for (name, weight, (unit, remedy)) in [
            ("ad-weight", self.ad_weight, sixteenths),
            ("census-weight", self.census_weight, of_census),
            ("learned-weight", self.learned_weight, in_64ths),
        ] {
            let allowed = format!("from 0 to {} {unit}", Self::MAX_WEIGHT);
            check(weight <= Self::MAX_WEIGHT, name, weight, allowed, remedy)?;
        }
        let none = self.ad_weight + self.census_weight == 0;
        check(!none, "ad-weight", 0, "more than 0 if census-weight is 0", "8 and 32 are usual")?;
        let none = self.learned_weight + self.census_weight == 0;
        check(!none, "learned-weight", 0, "more than 0 if census-weight is 0", "40 and 32 are usual")?;
        if LEFT_OUT && self.takes_features() {
            let text = format!(
                "this program computes no networks on the CPU, as cost {} needs; choose another cost",
                self.cost
            );
            return Err(Error::Network(text));
        }
        let (cost, method, row) = (self.cost, self.method, self.cost.row());
        check(
            row.methods.contains(&method),
            "cost",
            cost,
            format!("another one with method {method}"),
            match method {
                Method::Sgm | Method::Bp => "take method bm or another cost",
                Method::Bm | Method::Psmnet => "take method sgm or another cost",
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
        if width == 0 || height == 0 {
            let text = format!("the images are {width}x{height}, but must have at least one pixel; give others");
            return Err(Error::Image(text));
        }
        self.rectify.as_ref().map_or(Ok(()), |rectification| rectification.suits(width, height))?;
        self.masks.as_ref().map_or(Ok(()), |masks| masks.accepts(width, height))
    }
}
