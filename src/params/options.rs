//! Every setting by name: the one table behind the command's options, sweeps and measurements.

use crate::Error;
use crate::params::costs::Descriptor;
use crate::params::names::Named;
use crate::params::{
    Census, Cost, Fill, Median, Method, Params, Paths, Prefilter, Preset, RightView, Schedule, Subpixel, Wls,
};

/// A setting of [`Params`] by its name on the command line: `--name value`.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct ParamOption {
    /// The name, without dashes.
    pub name: &'static str,
    /// What it belongs to.
    pub heading: &'static str,
    /// What stands for a value, such as `PX|off`.
    pub placeholder: &'static str,
    /// The words that are all its values, each with an explanation; empty where it takes numbers.
    pub values: &'static [(&'static str, &'static str)],
    /// What it does, in a line.
    pub help: &'static str,
    set: fn(&mut Params, &str) -> Result<(), String>,
    get: fn(&Params) -> String,
    idle: fn(&Params) -> Option<&'static str>,
}

impl ParamOption {
    /// The values in the form `sgm|bm`, or what stands for them.
    pub fn allowed(&self) -> String {
        match self.values {
            [] => self.placeholder.into(),
            values => joined(values, "|"),
        }
    }

    /// The value in `params`, such that [`Params::set`] takes it.
    pub fn get(&self, params: &Params) -> String {
        (self.get)(params)
    }

    /// The other option whose value in `params` makes this one change nothing.
    pub fn idle(&self, params: &Params) -> Option<&'static Self> {
        let by_network = params.method == Method::Psmnet && self.is_of_costs(params);
        if by_network { find("method") } else { (self.idle)(params).and_then(find) }
    }

    /// Whether it is of costs and how a winner is found by them alone: a network has none.
    fn is_of_costs(&self, params: &Params) -> bool {
        match self.name {
            // `texture` reads these two.
            "block" | "prefilter-cap" => params.texture == 0,
            "uniqueness" | "subpixel" => true,
            _ => self.heading == "Matching cost",
        }
    }
}

fn joined(values: &[(&str, &str)], between: &str) -> String {
    values.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(between)
}

fn find(name: &str) -> Option<&'static ParamOption> {
    Params::OPTIONS.iter().find(|option| option.name == name)
}

/// A whole number as digits with a sign. One beyond an `i64` is the nearest, which no range holds.
fn whole(text: &str) -> Option<i64> {
    let digits = text.strip_prefix(['-', '+']).unwrap_or(text);
    let good = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
    good.then(|| text.parse().unwrap_or(if text.starts_with('-') { i64::MIN } else { i64::MAX }))
}

/// The same as an `i32`, the nearest.
fn signed(text: &str) -> Option<i32> {
    whole(text).map(|value| value.clamp(i32::MIN.into(), i32::MAX.into()) as i32)
}

/// The same as a `u32`: one outside becomes the largest, which no range holds, so that the range is told.
fn natural(text: &str) -> Option<u32> {
    whole(text).map(|value| u32::try_from(value).unwrap_or(u32::MAX))
}

/// A number, or nothing for `off`.
fn unless_off<T>(text: &str, number: fn(&str) -> Option<T>) -> Option<Option<T>> {
    if text == "off" { Some(None) } else { number(text).map(Some) }
}

fn or_off(value: Option<impl ToString>) -> String {
    value.map_or("off".into(), |value| value.to_string())
}

fn on(text: &str) -> Option<bool> {
    matches!(text, "on" | "off").then(|| text == "on")
}

fn switch(value: bool) -> String {
    if value { "on" } else { "off" }.into()
}

fn set<T>(to: &mut T, value: Option<T>, allowed: impl Into<String>) -> Result<(), String> {
    *to = value.ok_or_else(|| allowed.into())?;
    Ok(())
}

fn set_named<T: Named>(to: &mut T, text: &str) -> Result<(), String> {
    set(to, T::of(text), format!("one of {}", joined(T::NAMES, ", ")))
}

const ON_OFF: &[(&str, &str)] = &[("on", ""), ("off", "")];
const NUMBER: &str = "a whole number, such as 64";
const NUMBER_OR_OFF: &str = "a whole number or off";

/// An option with nothing that makes it idle.
const PLAIN: ParamOption = ParamOption {
    name: "",
    heading: "",
    placeholder: "",
    values: &[],
    help: "",
    set: |_, _| Ok(()),
    get: |_| String::new(),
    idle: |_| None,
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

impl Params {
    /// Every setting that a map depends on, and how it is laid out on the device, in the order of `--help`: what a
    /// program needs to show them all.
    ///
    /// ```
    /// use gpu_stereo::Params;
    /// let params = Params::sgm(64);
    /// for option in Params::OPTIONS {
    ///     println!("{} = {} ({}): {}", option.name, option.get(&params), option.allowed(), option.help);
    /// }
    /// ```
    pub const OPTIONS: &'static [ParamOption] = options! {
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
                idle by "cost" if |params| !params.cost.row().weighted;
            "census-weight" "W" natural census_weight
                "ad-census: weight of a differing bit in sixteenths, 0 to 64"
                idle by "cost" if |params| !params.cost.row().weighted;
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
            "adaptive-p2" "on|off" switch adaptive_p2
                "sgm: lower P2 where the intensity changes along the path"
                idle by "method" if |params| params.method != Method::Sgm;
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
                    && !matches!(params.fill, Fill::Rays | Fill::Hirschmuller);
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
                "Intensity step at which a weight halves, 1 to 255"
                idle by "weighted-median" if |params| params.weighted_median.is_none();
            "wls" "on|off" wls switch
                "Edge-preserving smoothing by weighted least squares";
            "wls-lambda" "L|off" wls lambda
                "Strength of that smoothing, 4 unless given; switches it on"
                idle by "wls" if |params| params.wls.is_none();
            "wls-sigma" "S|off" wls sigma
                "Intensity step that stops it, 1.5 unless given; switches it on"
                idle by "wls" if |params| params.wls.is_none();
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

    /// Sets one setting by its name. Ranges are left to [`Params::validate`], which judges all settings together.
    ///
    /// ```
    /// use gpu_stereo::{Params, Paths};
    /// let mut params = Params::sgm(64);
    /// params.set("paths", "8")?;
    /// assert_eq!((params.paths, params.get("paths").as_str()), (Paths::Eight, "8"));
    /// assert!(params.set("paths", "7").is_err());
    /// # Ok::<(), gpu_stereo::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Parameter`] for an unknown name, and for a value that is no number or none of the words that are known.
    pub fn set(&mut self, option: &str, value: &str) -> Result<(), Error> {
        let known = find(option).ok_or_else(|| unknown(option))?;
        (known.set)(self, value).map_err(|allowed| refused(known.name, value, allowed))
    }

    /// The value of a setting by its name, such that [`Params::set`] takes it; empty for an unknown name.
    pub fn get(&self, option: &str) -> String {
        find(option).map(|option| option.get(self)).unwrap_or_default()
    }

    /// Settings as the command makes them of its options, in any order: the preset (`preset`, else the default one),
    /// then `method` and `cost` with what is usual for them, then everything else. Of an option given twice the last
    /// counts. With the method `psmnet` the filters of the map are those of a preset that is given, else none; its network
    /// is no option: set [`Params::network`] afterwards.
    ///
    /// ```
    /// use gpu_stereo::{Params, Prefilter};
    /// let params = Params::from_options(64, [("cost", "census"), ("p2", "80"), ("preset", "strict")])?;
    /// assert_eq!((params.p2, params.prefilter), (80, Prefilter::None));
    /// # Ok::<(), gpu_stereo::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Parameter`] as of [`Params::set`] and [`Params::validate`], with the value as it was given.
    pub fn from_options<'a>(
        disparities: u32,
        options: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Self, Error> {
        let options: Vec<_> = options.into_iter().collect();
        let given = |name: &str| options.iter().rev().find(|(option, _)| *option == name).map(|(_, value)| *value);
        let preset = match given("preset") {
            Some(value) => Preset::of(value)
                .ok_or_else(|| refused("preset", value, format!("one of {}", joined(Preset::NAMES, ", "))))?,
            None => Preset::default(),
        };
        let mut params = Self::preset(preset, disparities);
        if let Some(value) = given("method") {
            params.set("method", value)?;
            params = match params.method {
                Method::Sgm => params,
                Method::Bm => params.with_bm(),
                Method::Psmnet if given("preset").is_some() => params.with_psmnet(),
                Method::Psmnet => params.with_psmnet().without_filters(),
            };
        }
        if let Some(value) = given("cost") {
            let before = params.cost;
            params.set("cost", value)?;
            if params.cost != before {
                params.take_usual();
            }
        }
        for (option, _) in &options {
            if find(option).is_none() && *option != "preset" {
                return Err(unknown(option));
            }
        }
        // From the last to the first: `wls` off has the last word over its numbers.
        for option in Self::OPTIONS.iter().rev() {
            if let Some(value) = given(option.name) {
                params.set(option.name, value)?;
            }
        }
        match params.validate_options() {
            // As it was given: a number beyond its type's range was replaced by another that is out of range.
            Err(Error::Parameter { name, given: meant, allowed, remedy }) => {
                let given = given(name).map_or(meant, Into::into);
                Err(Error::Parameter { name, given, allowed, remedy })
            }
            other => other.map(|()| params),
        }
    }
}

fn refused(name: &'static str, value: &str, allowed: String) -> Error {
    let given = if value.is_empty() { "empty".into() } else { value.escape_debug().to_string() };
    Error::Parameter { name, given, allowed, remedy: "see gpu-stereo --help" }
}

fn unknown(option: &str) -> Error {
    let names: Vec<_> = Params::OPTIONS.iter().map(|option| option.name).collect();
    Error::Parameter {
        name: "option",
        given: format!("{option:?}"),
        allowed: format!("preset or one of {}", names.join(", ")),
        remedy: "see gpu-stereo --help",
    }
}

#[cfg(test)]
mod tests;
