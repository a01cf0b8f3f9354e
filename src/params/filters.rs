//! The table of filters: a row for each filter of the map of the left view, in the order of the chain.

use crate::Error;
use crate::params::check::{MAX_DIFFERENCE, check};
use crate::params::{Fill, Median, Params, Wls};

/// How a device computes a filter: src/gpu/chain/filters/filtered.rs records it. The first three are one kernel, named as the
/// stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Steps {
    /// From what is around the pixel in the map.
    Around,
    /// From what is around the pixel in the map and in the left image.
    AroundWithImage,
    /// From the maps of both views.
    BothViews,
    /// Sums of the image's columns before.
    Texture,
    /// Trees of regions.
    Speckle,
    /// The kernels of the kind of fill.
    Fill,
    /// A solution along rows and columns in turn.
    Wls,
}

macro_rules! filters {
    ($($(#[$doc:meta])* $name:ident {
        stage: $stage:literal,
        wanted: $wanted:expr,
        clear: $clear:expr,
        reads_right: $reads_right:expr,
        gives_disparities: $gives:literal,
        steps: $steps:ident,
        ranges: $ranges:expr,
    })+) => {
        /// A filter of the map of the left view. Its definition is in src/reference/filters/mod.rs, which does not compile until
        /// it has an arm for each variant.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Filter {
            $($(#[$doc])* $name,)+
        }

        impl Filter {
            /// All filters, in the order of the chain.
            pub(crate) const ALL: &[Self] = &[$(Self::$name),+];

            /// The name of its stage.
            pub(crate) fn stage(self) -> &'static str {
                match self { $(Self::$name => $stage,)+ }
            }

            /// Whether the settings ask for it.
            pub(crate) fn wanted(self, params: &Params) -> bool {
                let wanted: fn(&Params) -> bool = match self { $(Self::$name => $wanted,)+ };
                wanted(params)
            }

            /// Switches it off.
            pub(crate) fn clear(self, params: &mut Params) {
                let clear: fn(&mut Params) = match self { $(Self::$name => $clear,)+ };
                clear(params);
            }

            /// Whether it reads the right view, with settings that ask for it.
            pub(crate) fn reads_right(self, params: &Params) -> bool {
                let reads_right: fn(&Params) -> bool = match self { $(Self::$name => $reads_right,)+ };
                self.wanted(params) && reads_right(params)
            }

            /// Whether it may give a pixel another disparity: `validity` follows then.
            pub(crate) fn gives_disparities(self) -> bool {
                match self { $(Self::$name => $gives,)+ }
            }

            /// Checks the ranges of its settings.
            pub(crate) fn validate(self, params: &Params) -> Result<(), Error> {
                let ranges: fn(&Params) -> Result<(), Error> = match self { $(Self::$name => $ranges,)+ };
                ranges(params)
            }

            /// How the device computes it.
            pub(crate) fn steps(self) -> Steps {
                match self { $(Self::$name => Steps::$steps,)+ }
            }
        }
    };
}

filters! {
    /// Drops disparities of blocks with too little texture.
    Texture {
        stage: "texture",
        wanted: |params| params.texture > 0,
        clear: |params| params.texture = 0,
        reads_right: |_| false,
        gives_disparities: false,
        steps: Texture,
        ranges: |params| check(
            params.texture <= Params::MAX_TEXTURE,
            "texture",
            params.texture,
            format!("from 0 (off) to {}", Params::MAX_TEXTURE),
            "a few units for each pixel of the block are usual",
        ),
    }
    /// Drops disparities with which the right view disagrees.
    LrCheck {
        stage: "lr_check",
        wanted: |params| params.lr_check.is_some(),
        clear: |params| params.lr_check = None,
        reads_right: |_| true,
        gives_disparities: false,
        steps: BothViews,
        ranges: |params| check(
            params.lr_check.is_none_or(|px| px <= MAX_DIFFERENCE),
            "lr-check",
            params.lr_check.unwrap_or_default(),
            format!("off, or from 0 to {MAX_DIFFERENCE} px"),
            "1 is usual",
        ),
    }
    /// Drops small regions.
    Speckle {
        stage: "speckle",
        wanted: |params| params.speckle_window > 0,
        clear: |params| params.speckle_window = 0,
        reads_right: |_| false,
        gives_disparities: false,
        steps: Speckle,
        ranges: |params| {
            check(
                params.speckle_range <= MAX_DIFFERENCE,
                "speckle-range",
                params.speckle_range,
                format!("from 0 to {MAX_DIFFERENCE} px"),
                "1 or 2 is usual",
            )?;
            check(
                params.speckle_window <= i32::MAX as u32,
                "speckle-window",
                params.speckle_window,
                format!("from 0 (off) to {} px", i32::MAX),
                "100 is usual",
            )
        },
    }
    /// The median of a window.
    Median {
        stage: "median",
        wanted: |params| params.median != Median::Off,
        clear: |params| params.median = Median::Off,
        reads_right: |_| false,
        gives_disparities: true,
        steps: Around,
        ranges: |_| Ok(()),
    }
    /// Fills holes.
    Fill {
        stage: "fill",
        wanted: |params| params.fill != Fill::None,
        clear: |params| params.fill = Fill::None,
        reads_right: |params| params.fill.reads_right(),
        gives_disparities: true,
        steps: Fill,
        ranges: |_| Ok(()),
    }
    /// The median of a window, weighted by the left image.
    WeightedMedian {
        stage: "weighted_median",
        wanted: |params| params.weighted_median.is_some(),
        clear: |params| params.weighted_median = None,
        reads_right: |_| false,
        gives_disparities: true,
        steps: AroundWithImage,
        ranges: |params| {
            check(
                params.weighted_median.is_none_or(|radius| (1..=15).contains(&radius)),
                "weighted-median",
                params.weighted_median.unwrap_or_default(),
                "off, or a radius from 1 to 15 px",
                "5 is usual",
            )?;
            let sigma = params.weighted_median_sigma;
            check((1..=255).contains(&sigma), "weighted-median-sigma", sigma, "from 1 to 255", "20 is usual")
        },
    }
    /// Smooths by weighted least squares.
    Wls {
        stage: "wls",
        wanted: |params| params.wls.is_some(),
        clear: |params| params.wls = None,
        reads_right: |_| false,
        gives_disparities: true,
        steps: Wls,
        ranges: |params| {
            let Some(Wls { lambda, sigma }) = params.wls else { return Ok(()) };
            check((0.0..=1e6).contains(&lambda), "wls-lambda", lambda, "from 0 to 1000000", "4 is usual")?;
            check((0.1..=1000.0).contains(&sigma), "wls-sigma", sigma, "from 0.1 to 1000", "1 to 2 is usual")
        },
    }
}
