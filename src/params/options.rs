//! Every setting by name: the one table behind the command's options, sweeps and measurements.

mod option;
mod table;

use crate::Error;
use crate::params::names::named;
use crate::params::{Method, Params, Preset};

pub use option::ParamOption;

impl ParamOption {
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

pub(super) fn find(name: &str) -> Option<&'static ParamOption> {
    Params::OPTIONS.iter().find(|option| option.name == name)
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
    pub const OPTIONS: &'static [ParamOption] = table::OPTIONS;

    /// Sets one setting by its name. Ranges are left to [`Params::validate`], which judges all settings together.
    ///
    /// ```
    /// use gpu_stereo::{Params, Paths};
    /// let mut params = Params::sgm(64);
    /// params.set("paths", "8")?;
    /// assert_eq!((params.paths, params.get("paths")?.as_str()), (Paths::Eight, "8"));
    /// assert!(params.set("paths", "7").is_err() && params.get("path").is_err());
    /// # Ok::<(), gpu_stereo::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Parameter`] for an unknown name, and for a value that is no number or none of the words that are known.
    pub fn set(&mut self, option: &str, value: &str) -> Result<(), Error> {
        let known = find(option).ok_or_else(|| unknown(option))?;
        (known.set)(self, value).map_err(|allowed| Error::no_value(known.name, value, allowed))
    }

    /// The value of a setting by its name, such that [`Params::set`] takes it.
    ///
    /// # Errors
    /// [`Error::Parameter`] for an unknown name.
    pub fn get(&self, option: &str) -> Result<String, Error> {
        find(option).map(|option| option.get(self)).ok_or_else(|| unknown(option))
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
            Some(value) => named(value)?,
            None => Preset::default(),
        };
        let mut params = Self::preset(preset, disparities);
        if let Some(value) = given("method") {
            params.set("method", value)?;
            params = match params.method {
                Method::Sgm | Method::Bp => params,
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
