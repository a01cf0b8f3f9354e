//! A setting by its name, and how values are read and written.

use crate::params::Params;
use crate::params::check::joined;
use crate::params::names::Named;

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
    pub(super) set: fn(&mut Params, &str) -> Result<(), String>,
    pub(super) get: fn(&Params) -> String,
    pub(super) idle: fn(&Params) -> Option<&'static str>,
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
}

/// A whole number as digits with a sign. One beyond an `i64` is the nearest, which no range holds.
pub(super) fn whole(text: &str) -> Option<i64> {
    let digits = text.strip_prefix(['-', '+']).unwrap_or(text);
    let good = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
    good.then(|| text.parse().unwrap_or(if text.starts_with('-') { i64::MIN } else { i64::MAX }))
}

/// The same as an `i32`, the nearest.
pub(super) fn signed(text: &str) -> Option<i32> {
    whole(text).map(|value| value.clamp(i32::MIN.into(), i32::MAX.into()) as i32)
}

/// The same as a `u32`: one outside becomes the largest, which no range holds, so that the range is told.
pub(super) fn natural(text: &str) -> Option<u32> {
    whole(text).map(|value| u32::try_from(value).unwrap_or(u32::MAX))
}

/// A number, or nothing for `off`.
pub(super) fn unless_off<T>(text: &str, number: fn(&str) -> Option<T>) -> Option<Option<T>> {
    if text == "off" { Some(None) } else { number(text).map(Some) }
}

pub(super) fn or_off(value: Option<impl ToString>) -> String {
    value.map_or("off".into(), |value| value.to_string())
}

pub(super) fn on(text: &str) -> Option<bool> {
    matches!(text, "on" | "off").then(|| text == "on")
}

pub(super) fn switch(value: bool) -> String {
    if value { "on" } else { "off" }.into()
}

pub(super) fn set<T>(to: &mut T, value: Option<T>, allowed: impl Into<String>) -> Result<(), String> {
    *to = value.ok_or_else(|| allowed.into())?;
    Ok(())
}

pub(super) fn set_named<T: Named>(to: &mut T, text: &str) -> Result<(), String> {
    set(to, T::of(text), format!("one of {}", joined(T::NAMES, ", ")))
}

pub(super) const ON_OFF: &[(&str, &str)] = &[("on", ""), ("off", "")];
pub(super) const NUMBER: &str = "a whole number, such as 64";
pub(super) const NUMBER_OR_OFF: &str = "a whole number or off";

/// An option with nothing that makes it idle.
pub(super) const PLAIN: ParamOption = ParamOption {
    name: "",
    heading: "",
    placeholder: "",
    values: &[],
    help: "",
    set: |_, _| Ok(()),
    get: |_| String::new(),
    idle: |_| None,
};
