//! Settings that go well together.

use crate::params::{
    Census, Cost, Fill, Filter, Median, Method, Params, Paths, Prefilter, Preset, RightView, Subpixel,
};

impl Params {
    /// What the command takes unless it is asked for something else: the default preset, over `disparities` disparities from 0.
    #[must_use]
    pub fn default_for(disparities: u32) -> Self {
        Self::preset(Preset::default(), disparities)
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
            p1: 18,
            p2: 90,
            adaptive_p2: true,
            uniqueness: 10,
            subpixel: Subpixel::Equiangular,
            speckle_range: 1,
            weighted_median: Some(3),
            ..classic.clone()
        };
        let steps = Self { p1: 21, p2: 110, p2_step: 6, adaptive_p1: true, passes: 2, ..balanced.clone() };
        let matched = Self { uniqueness: 0, right_view: RightView::Match, ..steps };
        let twice = Self { speckle_range: 2, median: Median::Off, ..matched };
        match preset {
            Preset::Classic => classic,
            Preset::Fast => {
                let derivatives = Self { cost: Cost::SadXy, prefilter: Prefilter::None, ..classic };
                Self { paths: Paths::Three, p1: 22, p2: 127, ..derivatives }
            }
            Preset::Balanced => balanced,
            Preset::Strict => Self { right_view: RightView::Match, speckle_window: 200, ..balanced },
            Preset::Dense => Self { fill: Fill::WeightedRays, ..twice },
            Preset::Accurate => {
                let learned = Self { cost: Cost::LearnedCensus, learned_weight: 8, census_weight: 56, ..twice };
                Self { uniqueness: 24, ..learned }
            }
        }
    }

    /// The same with block matching: its own cost, block and uniqueness, the same filters.
    pub(crate) fn with_bm(self) -> Self {
        let Self { method, cost, block, prefilter, uniqueness, .. } = Self::bm(self.disparities);
        Self { method, cost, block, prefilter, uniqueness, ..self }
    }

    /// The same with a network: the same filters, of which those that read the right view take that of a second match.
    pub(crate) fn with_psmnet(self) -> Self {
        Self { method: Method::Psmnet, right_view: RightView::Match, ..self }
    }

    /// The same without a filter of the map.
    pub(crate) fn without_filters(mut self) -> Self {
        Filter::ALL.iter().for_each(|filter| filter.clear(&mut self));
        self
    }

    /// The prefilter and the block that are usual for the cost.
    pub(crate) fn take_usual(&mut self) {
        let row = self.cost.row();
        self.prefilter = row.prefilter;
        if self.method.quantises() {
            self.block = row.block;
        }
    }
}
