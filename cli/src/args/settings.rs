//! The matcher's settings: an option for each of [`Params::OPTIONS`], and `--preset`.

use super::names;
use crate::terminal::message;
use anyhow::{Result, anyhow, ensure};
use clap::builder::{PossibleValue, StringValueParser, TypedValueParser};
use clap::{Arg, ArgMatches, Command, FromArgMatches};
use gpu_stereo::{Error, Params, Preset};
use std::ffi::OsStr;

const PRESET: &str = "preset";

/// Where the range of disparities comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// `--disp` and `--min-disp`.
    Given,
    /// The pair: `--disp auto`.
    Found {
        /// Whether `--min-disp` is given.
        min_is_given: bool,
    },
}

impl Range {
    /// That of settings. Of one that is given twice, the last counts.
    pub fn of<'a>(settings: impl Iterator<Item = (&'a str, &'a str)>) -> Self {
        let (mut is_found, mut min_is_given) = (false, false);
        for setting in settings {
            match setting.0 {
                "disp" => is_found = is_auto(setting),
                "min-disp" => min_is_given = true,
                _ => {}
            }
        }
        if is_found { Self::Found { min_is_given } } else { Self::Given }
    }

    /// Whether the pair decides.
    pub fn is_found(self) -> bool {
        self != Self::Given
    }
}

/// The options of [`Params::OPTIONS`] and `preset` that were given, as they were typed.
#[derive(Clone, Debug)]
pub struct Settings(Vec<(&'static str, String)>);

impl Settings {
    /// Where the range comes from.
    pub fn range(&self) -> Range {
        Range::of(self.iter())
    }

    /// Name and value of each.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &str)> {
        self.0.iter().map(|(name, value)| (*name, value.as_str()))
    }
}

impl FromArgMatches for Settings {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let names = Params::OPTIONS.iter().map(|option| option.name).chain([PRESET]);
        let given = names.filter_map(|name| Some((name, matches.get_one::<String>(name)?.clone())));
        let mut given: Vec<_> = given.collect();
        given.sort_by_key(|(name, _)| matches.index_of(name)); // as they were typed
        Ok(Self(given))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl clap::Args for Settings {
    fn augment_args(command: Command) -> Command {
        let preset = Arg::new(PRESET)
            .long(PRESET)
            .value_name("PRESET")
            .value_parser(Words(Preset::NAMES))
            .help(format!("Settings to start from; other options override them [default: {}]", Preset::default()));
        // Both are valid.
        let defaults = ["sgm", "bm"].map(|method| Params::from_options(64, [("method", method)]).ok());
        let described = Params::OPTIONS.iter().map(|option| {
            let [sgm, bm] = defaults.each_ref().map(|params| params.as_ref().map(|params| option.get(params)));
            let default = match (option.name, sgm, bm) {
                ("disp", ..) => ", or auto: what a coarse match of the pair finds".into(),
                (name, Some(sgm), Some(bm)) if sgm != bm && name != "method" => {
                    format!(" [default: sgm {sgm}, bm {bm}]")
                }
                (_, sgm, _) => format!(" [default: {}]", sgm.unwrap_or_default()),
            };
            Arg::new(option.name)
                .long(option.name)
                .help_heading(option.heading)
                .help(format!("{}{default}", option.help))
                .value_name(option.placeholder)
                .hide_possible_values(option.placeholder.contains('|'))
                .value_parser(Words(option.values))
                .allow_negative_numbers(true)
        });
        described.fold(command.arg(preset), Command::arg)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

/// Accepts any text, since the library validates it; the allowed words are listed in the help.
#[derive(Clone, Copy)]
struct Words(&'static [(&'static str, &'static str)]);

impl TypedValueParser for Words {
    type Value = String;

    fn parse_ref(&self, command: &Command, argument: Option<&Arg>, value: &OsStr) -> Result<String, clap::Error> {
        StringValueParser::new().parse_ref(command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let words = self.0.iter().map(|(word, help)| PossibleValue::new(*word).help(*help));
        (!self.0.is_empty()).then(|| Box::new(words) as Box<_>)
    }
}

/// Replaced by `--disp`, which must be given.
const DISPARITIES: u32 = 64;

/// `--disp` has no default.
pub fn ensure_disparities(given: &[&str]) -> Result<()> {
    ensure!(
        given.contains(&"disp"),
        "--disp <N> is needed, the number of disparities, or --disp auto; see gpu-stereo --help"
    );
    Ok(())
}

/// Whether a setting asks for the range that the pair has.
fn is_auto((name, value): (&str, &str)) -> bool {
    name == "disp" && value == "auto"
}

/// The settings that the options make. The range of `--disp auto` is still to be found.
pub fn params<'a>(settings: impl Iterator<Item = (&'a str, &'a str)>) -> Result<Params> {
    Params::from_options(DISPARITIES, settings.filter(|setting| !is_auto(*setting))).map_err(by_option)
}

/// An error of the library, with the names of the options.
pub fn by_option(error: Error) -> anyhow::Error {
    match error {
        Error::Parameter { name: "option", given, allowed, remedy, .. } => {
            let meant =
                names::setting(given.trim_matches('"')).map(|meant| format!("use {meant}; ")).unwrap_or_default();
            anyhow!("{given} is no option; {allowed} is; {meant}{remedy}")
        }
        Error::Parameter { name, given, allowed, remedy, .. } => {
            let meant = names::value(name, &given).map(|meant| format!("use {meant}; ")).unwrap_or_default();
            anyhow!("--{name} is {given}, but must be {allowed}; {meant}{remedy}")
        }
        other => other.into(),
    }
}

/// Reports options that have no effect wherever they are given: nothing is ignored in silence.
pub fn report_unused(given: &[(Vec<&str>, &Params)]) {
    for option in Params::OPTIONS {
        let with = given.iter().filter(|(names, _)| names.contains(&option.name));
        let others: Option<Vec<_>> = with.map(|(_, params)| Some((option.idle(params)?, params))).collect();
        if let Some((other, params)) = others.and_then(|others| others.into_iter().next()) {
            let value = other.get(params);
            message(&format!("note: --{} has no effect with --{} {value}", option.name, other.name));
        }
    }
}
