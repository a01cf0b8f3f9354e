//! The table of filters: a row for each filter of the map of the left view, in the order of the chain.

use crate::params::{Fill, Median, Params};

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
    }
    /// Drops disparities with which the right view disagrees.
    LrCheck {
        stage: "lr_check",
        wanted: |params| params.lr_check.is_some(),
        clear: |params| params.lr_check = None,
        reads_right: |_| true,
        gives_disparities: false,
        steps: BothViews,
    }
    /// Drops small regions.
    Speckle {
        stage: "speckle",
        wanted: |params| params.speckle_window > 0,
        clear: |params| params.speckle_window = 0,
        reads_right: |_| false,
        gives_disparities: false,
        steps: Speckle,
    }
    /// The median of a window.
    Median {
        stage: "median",
        wanted: |params| params.median != Median::Off,
        clear: |params| params.median = Median::Off,
        reads_right: |_| false,
        gives_disparities: true,
        steps: Around,
    }
    /// Fills holes.
    Fill {
        stage: "fill",
        wanted: |params| params.fill != Fill::None,
        clear: |params| params.fill = Fill::None,
        reads_right: |params| matches!(params.fill, Fill::Rays | Fill::Hirschmuller),
        gives_disparities: true,
        steps: Fill,
    }
    /// The median of a window, weighted by the left image.
    WeightedMedian {
        stage: "weighted_median",
        wanted: |params| params.weighted_median.is_some(),
        clear: |params| params.weighted_median = None,
        reads_right: |_| false,
        gives_disparities: true,
        steps: AroundWithImage,
    }
    /// Smooths by weighted least squares.
    Wls {
        stage: "wls",
        wanted: |params| params.wls.is_some(),
        clear: |params| params.wls = None,
        reads_right: |_| false,
        gives_disparities: true,
        steps: Wls,
    }
}
