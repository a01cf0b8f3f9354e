//! Several settings of one run: `--variants`.

use crate::args::{self, Range};
use anyhow::{Context as _, Result, bail, ensure};
use gpu_stereo::{Params, Preset};
use serde::{Serialize, Serializer};

/// The most maps of a sheet.
pub const MAX_MAPS: usize = 1000;

/// Settings under a label.
pub struct Variant {
    /// The settings that distinguish it, in words.
    pub label: String,
    /// Option and value of each setting; later ones override earlier ones.
    pub settings: Vec<(String, String)>,
    /// The settings for the matcher.
    pub params: Params,
}

impl Variant {
    /// Where its range of disparities comes from.
    pub fn range(&self) -> Range {
        Range::of(self.settings.iter().map(|(name, value)| (name.as_str(), value.as_str())))
    }
}

/// The variants of `--variants`, each with the settings that all have in common.
pub fn named(variants: &[String], common: &[(&str, &str)]) -> Result<Vec<Variant>> {
    ensure!(
        variants.len() <= MAX_MAPS,
        "--variants has {} variants, but at most {MAX_MAPS} are computed; give fewer",
        variants.len()
    );
    let variants = variants.iter().map(|text| {
        let context = || format!("--variants has {text:?}");
        let own = text.split('+').map(setting).collect::<Result<Vec<_>>>().with_context(context)?;
        let label = in_words(own.iter().map(|(name, value)| (*name, value.as_str())));
        let common = common.iter().map(|(name, value)| (*name, (*value).to_owned()));
        let settings: Vec<_> = common.chain(own).map(|(name, value)| (name.to_owned(), value)).collect();
        let params = args::params(settings.iter().map(|(name, value)| (name.as_str(), value.as_str())));
        Ok(Variant { label, params: params.with_context(context)?, settings })
    });
    variants.collect()
}

/// A part of a variant: `option=value`, or a word that implies its option.
fn setting(part: &str) -> Result<(&str, String)> {
    if let Some((name, value)) = part.split_once('=') {
        return Ok((name, value.into()));
    }
    let has = |words: &[(&str, &str)], word| words.iter().any(|(known, _)| *known == word);
    if has(Preset::NAMES, part) {
        return Ok(("preset", part.into()));
    }
    for option in Params::OPTIONS {
        if ["method", "cost"].contains(&option.name) && has(option.values, part) {
            return Ok((option.name, part.into()));
        }
        if option.name == part && has(option.values, "on") {
            return Ok((part, "on".into()));
        }
    }
    let meant = args::word(part).map(|word| format!("use {word}, or ")).unwrap_or_default();
    bail!(
        "{part:?} is neither a preset, a method or a cost nor an option that can be on; {meant}give OPTION=VALUE, several \
         joined by +, and see gpu-stereo --help"
    )
}

/// Settings in words.
pub fn in_words<'a>(settings: impl Iterator<Item = (&'a str, &'a str)>) -> String {
    settings.map(|(name, value)| format!("{name} {value}")).collect::<Vec<_>>().join(", ")
}

/// Options and values as an object; of an option given twice the last counts.
pub fn settings<S: Serializer>(settings: &[(String, String)], serializer: S) -> Result<S::Ok, S::Error> {
    let map: serde_json::Map<_, _> =
        settings.iter().map(|(name, value)| (name.clone(), value.as_str().into())).collect();
    map.serialize(serializer)
}
