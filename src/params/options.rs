//! Every setting by name: the one table behind the command's options, sweeps and measurements.

use crate::{
    Census, Cost, Error, Fill, Median, Method, Params, Paths, Prefilter, Preset, RightView, Schedule, Subpixel, Wls,
};

/// An enumeration whose values have names.
pub(crate) trait Named: Copy + 'static {
    /// Every value with its name and a few words.
    const NAMES: &'static [(&'static str, &'static str)];
    const VALUES: &'static [Self];

    fn name(self) -> &'static str;

    fn of(name: &str) -> Option<Self> {
        Self::NAMES.iter().position(|(known, _)| *known == name).map(|i| Self::VALUES[i])
    }
}

/// The names of enumerations, and that no value was forgotten.
macro_rules! names {
    ($($kind:ident { $($value:ident $name:literal $help:literal,)+ })+) => {$(
        impl Named for $kind {
            const NAMES: &'static [(&'static str, &'static str)] = &[$(($name, $help)),+];
            const VALUES: &'static [Self] = &[$(Self::$value),+];

            fn name(self) -> &'static str {
                match self {
                    $(Self::$value => $name,)+
                }
            }
        }

        impl std::fmt::Display for $kind {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad(self.name())
            }
        }
    )+};
}

names! {
    Preset {
        Classic "classic" "the plain chain and a speckle filter",
        Fast "fast" "both derivatives, along three directions",
        Balanced "balanced" "census and gradients, P2 by the intensity step",
        Strict "strict" "balanced, and only what a second match confirms",
        Dense "dense" "balanced, and every hole filled",
    }
    Method {
        Sgm "sgm" "semi-global matching",
        Bm "bm" "block matching",
    }
    Cost {
        Sad "sad" "absolute differences",
        Ssd "ssd" "squared differences",
        ZeroMeanSad "zsad" "absolute differences less the block's mean",
        BirchfieldTomasi "bt" "Birchfield-Tomasi: the same between two pixels as on them",
        SadXy "sad-xy" "absolute differences of both Sobel derivatives",
        Census "census" "differing bits of census strings",
        CensusSobel "census-sobel" "census and sad-xy together",
        AdCensus "ad-census" "absolute differences and census, each with a weight",
        Ncc "ncc" "normalised cross correlation, for bm",
        MutualInformation "mi" "mutual information",
    }
    Census {
        Five "5x5" "24 bits",
        Seven "7x7" "48 bits",
        NineBySeven "9x7" "62 bits",
        CentreSymmetric "cs9x7" "31 pairs of opposite pixels",
    }
    Prefilter {
        XSobel "xsobel" "horizontal derivative, clipped",
        Sobel "sobel" "gradient magnitude, clipped",
        Normalized "normalized" "difference from the mean of a window, clipped",
        None "none" "the gray image",
    }
    Paths {
        Three "3" "horizontal and downwards",
        Four "4" "horizontal and vertical",
        Five "5" "horizontal, and all three downwards",
        Eight "8" "diagonal, too",
        Sixteen "16" "and between those",
    }
    RightView {
        Diagonal "diagonal" "from the costs of the left view",
        Match "match" "a second match: twice the time",
    }
    Subpixel {
        Parabola "parabola" "through three costs; on is the same",
        Equiangular "equiangular" "two lines of equal and opposite slope",
        Off "off" "whole pixels",
    }
    Median {
        Three "3" "3x3 pixels",
        Five "5" "5x5 pixels",
        Off "off" "no filter",
    }
    Fill {
        None "none" "holes stay",
        Background "background" "the farther neighbour in the row",
        Rays "rays" "occlusions by the row, mismatches by the median of 8 rays",
        Hirschmuller "hirschmuller" "second lowest and median of 8 rays",
    }
    Schedule {
        Auto "auto" "as the adapter is",
        PerThread "per-thread" "a path an invocation, for CPU adapters",
        PerSubgroup "per-subgroup" "a path for several, for GPUs",
    }
}

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
        (self.idle)(params).and_then(find)
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
                idle by "cost" if |params| !matches!(params.cost, Cost::Census | Cost::CensusSobel | Cost::AdCensus);
            "ad-weight" "W" natural ad_weight
                "ad-census: weight of an absolute difference in sixteenths, 0 to 64"
                idle by "cost" if |params| params.cost != Cost::AdCensus;
            "census-weight" "W" natural census_weight
                "ad-census: weight of a differing bit in sixteenths, 0 to 64"
                idle by "cost" if |params| params.cost != Cost::AdCensus;
            "color-cost" "on|off" switch color_cost
                "sad, bt: compare red, green and blue rather than luma";
            "block" "B" natural block
                "Side of the square block, odd, 1 to 51";
            "prefilter" "PREFILTER" Prefilter prefilter
                "The image on which costs are computed";
            "prefilter-cap" "C" natural prefilter_cap
                "Clip of the prefilter and of derivatives, 1 to 127"
                idle by "prefilter" if |params| params.prefilter == Prefilter::None && params.texture == 0
                    && !matches!(params.cost, Cost::SadXy | Cost::CensusSobel);
            "prefilter-window" "W" natural prefilter_window
                "normalized: side of the window, odd, 3 to 51"
                idle by "prefilter" if |params| params.prefilter != Prefilter::Normalized;
        }
        "Aggregation" {
            "method" "METHOD" Method method
                "How costs become disparities; bm brings its own cost and block along";
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
    /// counts.
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
            if params.method == Method::Bm {
                params = params.with_bm();
            }
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
        match params.validate() {
            // As it was given: a number beyond its type's range was replaced by another that is out of range.
            Err(Error::Parameter { name, given: meant, allowed, remedy }) => {
                let given = given(name).map_or(meant, Into::into);
                Err(Error::Parameter { name, given, allowed, remedy })
            }
            other => other.map(|()| params),
        }
    }
}

impl Preset {
    /// Every preset by name, with a few words.
    pub const NAMES: &'static [(&'static str, &'static str)] = <Self as Named>::NAMES;
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
mod tests {
    use super::*;

    const PRESETS: &[Preset] = <Preset as Named>::VALUES;

    /// Values of an option: its words, or numbers at both ends of what it may hold.
    fn values(option: &ParamOption) -> Vec<&'static str> {
        let words = option.values.iter().map(|(name, _)| *name);
        let numbers: &[&str] = match option.name {
            "min-disp" => &["-2047", "0", "12"],
            "wls-lambda" | "wls-sigma" => &["0.1", "8000", "off"],
            _ if !option.values.is_empty() => &[],
            _ if option.placeholder.ends_with("|off") => &["1", "15", "off"],
            _ => &["3", "51"],
        };
        words.chain(numbers.iter().copied()).collect()
    }

    #[test]
    fn every_option_gives_back_what_it_was_set_to() {
        for option in Params::OPTIONS {
            let values = values(option);
            assert!(values.len() > 1 && !option.help.is_empty() && !option.heading.is_empty(), "{option:?}");
            let mut got = Vec::new();
            for value in &values {
                let before = Params::sgm(64);
                let mut params = before.clone();
                params.set(option.name, value).unwrap();
                assert_eq!(params.get(option.name), *value, "{}", option.name);
                let others = Params::OPTIONS.iter().filter(|other| !other.name.starts_with("wls"));
                for other in others.filter(|other| other.name != option.name) {
                    assert_eq!(other.get(&params), other.get(&before), "{} changes {}", option.name, other.name);
                }
                got.push(params);
            }
            assert!(got.windows(2).all(|pair| pair[0] != pair[1]), "{} changes nothing", option.name);
        }
    }

    #[test]
    fn all_that_an_option_holds_makes_the_same_parameters_again() {
        for &preset in PRESETS {
            let params = Params::preset(preset, 48);
            let told: Vec<_> = Params::OPTIONS.iter().map(|option| (option.name, option.get(&params))).collect();
            let told = || told.iter().map(|(name, value)| (*name, value.as_str()));
            let mut copy = Params::bm(1);
            told().for_each(|(name, value)| copy.set(name, value).unwrap());
            assert_eq!(copy, params);
            assert_eq!(Params::from_options(1, told()).unwrap(), params);
        }
    }

    #[test]
    fn names_are_known_once() {
        for (i, option) in Params::OPTIONS.iter().enumerate() {
            assert!(Params::OPTIONS[..i].iter().all(|other| other.name != option.name), "{}", option.name);
            let words: Vec<_> = option.values.iter().map(|(name, _)| name).collect();
            assert!(words.iter().enumerate().all(|(i, word)| !words[..i].contains(word)), "{words:?}");
            assert!(!option.placeholder.is_empty(), "{}", option.name);
            for params in PRESETS.iter().map(|&preset| Params::preset(preset, 8)).chain([Params::bm(8)]) {
                assert_eq!((option.idle)(&params).is_some(), option.idle(&params).is_some(), "{}", option.name);
            }
        }
    }

    #[test]
    fn what_is_no_value_is_refused_with_what_is_one() {
        for option in Params::OPTIONS {
            for value in ["", " ", "magic", "1 2", "٣", "0x10", "--1", "+", "\n"] {
                let mut params = Params::sgm(64);
                let error = params.set(option.name, value).unwrap_err().to_string();
                assert!(error.starts_with(&format!("{} is ", option.name)) && error.contains("must be "), "{error}");
                assert!(option.values.iter().all(|(word, _)| error.contains(word)), "{error}");
                assert_eq!((error.lines().count(), &params), (1, &Params::sgm(64)), "{error}");
            }
        }
        let error = Params::sgm(64).set("frobnicate", "1").unwrap_err().to_string();
        assert!(error.contains("\"frobnicate\"") && error.contains("min-disp, "), "{error}");
    }

    /// A number that no type holds is never taken for another one that is allowed.
    #[test]
    fn numbers_beyond_every_type_are_refused_as_they_were_given() {
        let numbers = Params::OPTIONS.iter().filter(|option| option.values.is_empty());
        for option in numbers.filter(|option| !option.name.starts_with("wls")) {
            for value in ["99999999999999999999999", "-99999999999999999999999", "4294967296", "1e39", "nan"] {
                let error = Params::from_options(64, [(option.name, value)]).unwrap_err().to_string();
                assert!(error.starts_with(&format!("{} is {value}, but must be ", option.name)), "{error}");
            }
        }
        for value in ["nan", "inf", "-inf", "-1", "1e99"] {
            for (name, allowed) in [("wls-lambda", "from 0 to 1000000"), ("wls-sigma", "from 0.1 to 1000")] {
                let error = Params::from_options(64, [(name, value)]).unwrap_err().to_string();
                assert!(error.starts_with(&format!("{name} is {value}, but must be {allowed}")), "{error}");
            }
        }
    }

    #[test]
    fn presets_are_valid_and_options_override_them_in_any_order() {
        let of = |options: &[(&'static str, &'static str)]| Params::from_options(64, options.iter().copied()).unwrap();
        for &preset in PRESETS {
            let name = preset.name();
            assert_eq!(of(&[("preset", name)]), Params::preset(preset, 64));
            let changed = Params { p2: 70, median: Median::Off, ..Params::preset(preset, 64) };
            let (p2, median) = (("p2", "70"), ("median", "off"));
            assert_eq!(of(&[("preset", name), p2, median]), changed);
            assert_eq!(of(&[median, p2, ("preset", name)]), changed);
            // Block matching has a cost and a block of its own, and the preset's filters.
            let (bm, plain) = (of(&[("method", "bm"), ("preset", name)]), Params::bm(64));
            assert_eq!((bm.method, bm.cost, bm.block, bm.uniqueness), (Method::Bm, Cost::Sad, 15, 15));
            assert_eq!((bm.prefilter, bm.fill), (plain.prefilter, changed.fill));
            assert_eq!(of(&[("block", "7"), ("method", "bm"), ("preset", name)]).block, 7);
        }
        assert_eq!(of(&[]), Params::preset(Preset::default(), 64));
        assert_eq!(of(&[("p2", "70"), ("p2", "80")]).p2, 80);
    }

    #[test]
    fn a_cost_brings_its_usual_prefilter_unless_another_is_given() {
        let of = |options: &[(&'static str, &'static str)]| Params::from_options(64, options.iter().copied()).unwrap();
        for &cost in Cost::VALUES {
            let method = if cost == Cost::Ncc { "bm" } else { "sgm" };
            for preset in ["classic", "balanced"] {
                let given = [("method", method), ("cost", cost.name()), ("preset", preset)];
                let usual = of(&given);
                assert_eq!((usual.cost, usual.method.name()), (cost, method));
                let sobel = of(&[&[("prefilter", "sobel"), ("block", "9")], &given[..]].concat());
                assert_eq!(sobel, Params { prefilter: Prefilter::Sobel, block: 9, ..usual });
            }
        }
        assert_eq!(of(&[("cost", "sad"), ("preset", "balanced")]).prefilter, Prefilter::XSobel);
        assert_eq!(of(&[("cost", "census"), ("preset", "classic")]).prefilter, Prefilter::None);
        // The preset's own cost stays as the preset has it.
        let balanced = Params::preset(Preset::Balanced, 64);
        assert_eq!(of(&[("cost", "census-sobel"), ("preset", "balanced")]), balanced);
    }

    #[test]
    fn the_numbers_of_wls_switch_it_on_and_off_has_the_last_word() {
        let of = |options: &[(&'static str, &'static str)]| Params::from_options(64, options.iter().copied()).unwrap();
        let wls = Wls { lambda: 500.0, ..Wls::default() };
        assert_eq!(of(&[("wls-lambda", "500")]).wls, Some(wls));
        assert_eq!(of(&[("wls-lambda", "5e2"), ("wls", "on")]).wls, Some(wls));
        assert_eq!(of(&[("wls", "on")]).wls, Some(Wls::default()));
        assert_eq!(of(&[("wls", "off"), ("wls-lambda", "500")]).wls, None);
    }
}
