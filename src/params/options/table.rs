//! The table of options.

use crate::params::costs::Descriptor;
use crate::params::names::Named;
use crate::params::options::option::{
    NUMBER, NUMBER_OR_OFF, ON_OFF, PLAIN, ParamOption, natural, on, or_off, set, set_named, signed, switch, unless_off,
};
use crate::params::{
    Census, Cost, Fill, Median, Method, Params, Paths, Prefilter, RightView, Schedule, Smoothness, Subpixel, Wls,
};

/// The part of a [`ParamOption`] that follows from how its field of [`Params`] is written; `$kind` is an enumeration.
macro_rules! field {
    (signed $field:ident) => {
        ParamOption {
            set: |params, text| set(&mut params.$field, signed(text), NUMBER),
            get: |params| params.$field.to_string(),
            ..PLAIN
        }
    };
    (natural $field:ident) => {
        ParamOption {
            set: |params, text| set(&mut params.$field, natural(text), NUMBER),
            get: |params| params.$field.to_string(),
            ..PLAIN
        }
    };
    (or_zero $field:ident) => {
        ParamOption {
            set: |params, text| {
                let value = unless_off(text, natural).map(Option::unwrap_or_default);
                set(&mut params.$field, value, NUMBER_OR_OFF)
            },
            get: |params| or_off((params.$field > 0).then_some(params.$field)),
            ..PLAIN
        }
    };
    (or_off $field:ident) => {
        ParamOption {
            set: |params, text| set(&mut params.$field, unless_off(text, natural), NUMBER_OR_OFF),
            get: |params| or_off(params.$field),
            ..PLAIN
        }
    };
    (switch $field:ident) => {
        ParamOption {
            values: ON_OFF,
            set: |params, text| set(&mut params.$field, on(text), "one of on, off"),
            get: |params| switch(params.$field),
            ..PLAIN
        }
    };
    (wls switch) => {
        ParamOption {
            values: ON_OFF,
            set: |params, text| {
                let wls = on(text).map(|on| on.then(|| params.wls.unwrap_or_default()));
                set(&mut params.wls, wls, "one of on, off")
            },
            get: |params| switch(params.wls.is_some()),
            ..PLAIN
        }
    };
    // A number switches the filter on.
    (wls $number:ident) => {
        ParamOption {
            set: |params, text| {
                let number = unless_off(text, |text| text.parse().ok());
                let wls = number.map(|number| number.map(|$number| Wls { $number, ..params.wls.unwrap_or_default() }));
                set(&mut params.wls, wls, "a number or off")
            },
            get: |params| or_off(params.wls.map(|wls| wls.$number)),
            ..PLAIN
        }
    };
    (refinement $field:ident) => {
        ParamOption {
            set: |params, text| set_named(&mut params.$field, if text == "on" { "parabola" } else { text }),
            ..field!(Subpixel $field)
        }
    };
    ($kind:ident $field:ident) => {
        ParamOption {
            values: $kind::NAMES,
            set: |params, text| set_named(&mut params.$field, text),
            get: |params| params.$field.to_string(),
            ..PLAIN
        }
    };
}

/// Rows of: name, placeholder, kind and name of the field, help, and when which other option makes it change nothing.
macro_rules! options {
    ($($heading:literal {
        $($name:literal $placeholder:literal $kind:ident $field:ident
            $help:literal
            $(idle by $other:literal if $idle:expr)?;)+
    })+) => {
        &[$($(ParamOption {
            name: $name,
            heading: $heading,
            placeholder: $placeholder,
            help: $help,
            $(idle: |params| {
                let idle: fn(&Params) -> bool = $idle;
                idle(params).then_some($other)
            },)?
            ..field!($kind $field)
        }),+),+]
    };
}

/// Every option, in the order of `--help`.
pub(super) const OPTIONS: &[ParamOption] = options! {
    "Input" {
        "disp" "N" natural disparities
            "Number of disparities to search, in pixels";
        "min-disp" "M" signed min_disparity
            "Smallest disparity to search, may be negative";
    }
    "Matching cost" {
        "cost" "COST" Cost cost
            "How alike two pixels are; brings its usual prefilter and block along";
        "census" "CENSUS" Census census
            "Neighbours that a census string compares"
            idle by "cost" if |params| !params.compares(Descriptor::Census);
        "ad-weight" "W" natural ad_weight
            "ad-census: weight of an absolute difference in sixteenths, 0 to 64"
            idle by "cost" if |params| !params.cost.row().weights.contains(&"ad-weight");
        "census-weight" "W" natural census_weight
            "ad-census: weight of a differing bit in sixteenths, 0 to 64; learned-census: of census-sobel in 64ths"
            idle by "cost" if |params| !params.cost.row().weights.contains(&"census-weight");
        "learned-weight" "W" natural learned_weight
            "learned-census: weight of learned in 64ths, 0 to 64"
            idle by "cost" if |params| !params.cost.row().weights.contains(&"learned-weight");
        "color-cost" "on|off" switch color_cost
            "sad, bt: compare red, green and blue rather than luma";
        "block" "B" natural block
            "Side of the square block, odd, 1 to 51";
        "prefilter" "PREFILTER" Prefilter prefilter
            "The image on which costs are computed";
        "prefilter-cap" "C" natural prefilter_cap
            "Clip of the prefilter and of derivatives, 1 to 127"
            idle by "prefilter" if |params| params.prefilter == Prefilter::None && params.texture == 0
                && !params.compares(Descriptor::Gradients);
        "prefilter-window" "W" natural prefilter_window
            "normalized: side of the window, odd, 3 to 51"
            idle by "prefilter" if |params| params.prefilter != Prefilter::Normalized;
    }
    "Aggregation" {
        "method" "METHOD" Method method
            "How disparities are found; bm brings its own cost and block along, psmnet no filter but the preset's";
        "paths" "PATHS" Paths paths
            "sgm: directions along which costs are aggregated"
            idle by "method" if |params| params.method != Method::Sgm;
        "p1" "P1" natural p1
            "sgm: penalty of a disparity step of 1, 0 to P2"
            idle by "method" if |params| params.method != Method::Sgm;
        "p2" "P2" natural p2
            "sgm: penalty of a larger step, P1 to 127"
            idle by "method" if |params| params.method != Method::Sgm;
        "adaptive-p1" "on|off" switch adaptive_p1
            "sgm: lower P1 where the intensity changes along the path"
            idle by "method" if |params| params.method != Method::Sgm;
        "adaptive-p2" "on|off" switch adaptive_p2
            "sgm: lower P2 where the intensity changes along the path"
            idle by "method" if |params| params.method != Method::Sgm;
        "p2-step" "STEP" natural p2_step
            "sgm: step of the intensity up to which an adaptive P2 is whole, 1 to 255"
            idle by "adaptive-p2" if |params| !params.adaptive_p2;
        "passes" "1|2" natural passes
            "sgm: how often costs are aggregated; the second time from the mean of the cost and of the first aggregate"
            idle by "method" if |params| params.method != Method::Sgm;
        "smoothness" "SMOOTHNESS" Smoothness smoothness
            "bp, and the energy of all: how the smoothness grows with the difference of two neighbours"
            idle by "method" if |params| !params.reads_smoothness();
        "smoothness-weight" "W" natural smoothness_weight
            "bp, and the energy of all: smoothness of a difference of 1, 0 to 127"
            idle by "method" if |params| !params.reads_smoothness();
        "smoothness-truncation" "T" natural smoothness_truncation
            "bp, and the energy of all: the largest smoothness of two neighbours, 0 to 127"
            idle by "method" if |params| !params.reads_smoothness();
        "smoothness-edge" "STEP|off" or_off smoothness_edge
            "bp, and the energy of all: intensity step from which on the smoothness is half, 1 to 255"
            idle by "method" if |params| !params.reads_smoothness();
        "bp-levels" "L" natural bp_levels
            "bp: levels, each of half the size, 1 to 10"
            idle by "method" if |params| params.method != Method::Bp;
        "bp-iterations" "I" natural bp_iterations
            "bp: how often messages are passed on each level, 1 to 1000"
            idle by "method" if |params| params.method != Method::Bp;
        "bp-reweighting" "G" natural bp_reweighting
            "bp: share of a belief that is sent, in sixteenths, 4 to 16 (16: plain)"
            idle by "method" if |params| params.method != Method::Bp;
        "align-corners" "on|off" switch align_corners
            "psmnet: interpolate from corner pixel to corner pixel, as published weights want it"
            idle by "method" if |params| params.method != Method::Psmnet;
    }
    "After the winner" {
        "texture" "T|off" or_zero texture
            "Horizontal derivative that a block needs in sum";
        "uniqueness" "PCT|off" or_zero uniqueness
            "The winner must cost this many per cent less than all others but its neighbours, 0 (off) to 99";
        "subpixel" "SUBPIXEL" refinement subpixel
            "How the winner is refined to 1/16 pixel";
        "lr-check" "PX|off" or_off lr_check
            "Largest difference in pixels between the left and the right view";
        "right-view" "RIGHT-VIEW" RightView right_view
            "Where the right view comes from"
            idle by "lr-check" if |params| params.lr_check.is_none()
                && !params.fill.reads_right();
        "speckle-window" "PX|off" or_zero speckle_window
            "Regions of at most so many pixels are removed";
        "speckle-range" "PX" natural speckle_range
            "Largest disparity step between neighbours of a region, in pixels"
            idle by "speckle-window" if |params| params.speckle_window == 0;
        "median" "MEDIAN" Median median
            "Median filter";
        "fill" "FILL" Fill fill
            "How holes are filled";
        "weighted-median" "RADIUS|off" or_off weighted_median
            "Median weighted by the left image, its radius in pixels, 1 to 15";
        "weighted-median-sigma" "S" natural weighted_median_sigma
            "Intensity step at which a weight halves, 1 to 255; also of --fill weighted-rays"
            idle by "weighted-median" if |params| params.weighted_median.is_none() && params.fill != Fill::WeightedRays;
        "wls" "on|off" wls switch
            "Edge-preserving smoothing by weighted least squares";
        "wls-lambda" "L|off" wls lambda
            "Strength of that smoothing, 4 unless given; switches it on"
            idle by "wls" if |params| params.wls.is_none();
        "wls-sigma" "S|off" wls sigma
            "Intensity step that stops it, 1.5 unless given; switches it on"
            idle by "wls" if |params| params.wls.is_none();
        "opencv-rules" "on|off" switch opencv_rules
            "Decide as OpenCV's StereoBM and StereoSGBM do; and no disparity where its range leaves the right image";
    }
    "Device" {
        "shader-checks" "on|off" switch shader_checks
            "Compile the kernels with checks of every index and loop: slower, the same result";
        "schedule" "SCHEDULE" Schedule schedule
            "How the kernels are laid out; the same result";
        "memory-check" "on|off" switch memory_check
            "On CPUs, refuse what the memory that is left does not hold, before any work";
    }
};
