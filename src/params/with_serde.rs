//! Settings as serde reads and writes them: by the names and the values of the command.

use std::fmt;

use serde::de::{Error as _, IgnoredAny, MapAccess, Visitor};
use serde::ser::{Error as _, SerializeMap as _};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::Error;
use crate::params::options::find;
use crate::params::{Camera, Lens, Params, Rectification};

/// What a program asks for beside the options, each `on` or `off`.
type Switch = (&'static str, fn(&mut Params) -> &mut bool);
const SWITCHES: [Switch; 4] = [
    ("confidence", |params| &mut params.confidence),
    ("labels", |params| &mut params.labels),
    ("unrounded", |params| &mut params.unrounded),
    ("right-map", |params| &mut params.right_map),
];

/// A map of all [`Params::OPTIONS`] by name, each value the text that [`Params::get`] returns; then `confidence`, `labels`,
/// `unrounded` and `right-map`, `on` or `off`; then `depth`, a [`Camera`], and `rectify`, a [`Rectification`], where there is one.
///
/// It is an error if there is a network, also one of features, or if there are masks: take them out before, and set them again afterwards. All numbers keep
/// every bit in formats that do; serde_json alone needs its feature `float_roundtrip` for those of more than 15 digits.
impl Serialize for Params {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        for (name, is_there) in [
            ("network", self.network.is_some()),
            ("features", self.features.is_some()),
            ("masks", self.masks.is_some()),
        ] {
            if is_there {
                return Err(S::Error::custom(format!(
                    "settings with Params::{name} were given, but must be without; take it out, and set it again after they are read"
                )));
            }
        }
        let mut copy = self.clone();
        let cameras = usize::from(self.depth.is_some()) + usize::from(self.rectify.is_some());
        let mut map = to.serialize_map(Some(Self::OPTIONS.len() + SWITCHES.len() + cameras))?;
        for option in Self::OPTIONS {
            map.serialize_entry(option.name, &option.get(self))?;
        }
        for (name, switch) in SWITCHES {
            map.serialize_entry(name, if *switch(&mut copy) { "on" } else { "off" })?;
        }
        if self.depth.is_some() {
            map.serialize_entry("depth", &self.depth)?;
        }
        if self.rectify.is_some() {
            map.serialize_entry("rectify", &self.rectify)?;
        }
        map.end()
    }
}

/// A map as [`Params`] are written, of which all but `disp` may be missing, and `preset` may be there: what is missing is as
/// [`Params::from_options`] makes it. A value may be a number, or true and false for `on` and `off`, in formats that have such.
///
/// An unknown name and a value out of its range are errors with the text of [`Params::from_options`].
impl<'de> Deserialize<'de> for Params {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_map(Settings)
    }
}

struct Settings;

impl<'de> Visitor<'de> for Settings {
    type Value = Params;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a map from the names of options to their values")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Params, A::Error> {
        let (mut options, mut switches) = (Vec::<(String, Value)>::new(), Vec::<(Switch, bool)>::new());
        let (mut depth, mut rectify): (Option<Camera>, Option<Rectification>) = (None, None);
        let mut names = Vec::new();
        while let Some(name) = map.next_key::<String>()? {
            if names.contains(&name) {
                return Err(A::Error::custom(format!("{name} is given twice, but must be given once; leave one away")));
            }
            match (SWITCHES.iter().find(|(known, _)| *known == name), name.as_str()) {
                (Some(switch), _) => {
                    let Value(text) = map.next_value()?;
                    switches.push((*switch, is_on(switch.0, &text).map_err(A::Error::custom)?));
                }
                (None, "depth") => depth = map.next_value()?,
                (None, "rectify") => rectify = map.next_value()?,
                (None, known) if known == "preset" || find(known).is_some() => {
                    options.push((name.clone(), map.next_value()?));
                }
                // Of any kind: its name is the fault.
                (None, _) => {
                    map.next_value::<IgnoredAny>()?;
                    options.push((name.clone(), Value(String::new())));
                }
            }
            names.push(name);
        }
        if !names.iter().any(|name| name == "disp") {
            return Err(A::Error::missing_field("disp"));
        }
        let options = options.iter().map(|(name, Value(text))| (name.as_str(), text.as_str()));
        let mut params = Params::from_options(1, options).map_err(A::Error::custom)?;
        for ((_, switch), on) in switches {
            *switch(&mut params) = on;
        }
        (params.depth, params.rectify) = (depth, rectify);
        params.validate_options().map_err(A::Error::custom)?;
        Ok(params)
    }
}

fn is_on(name: &'static str, text: &str) -> Result<bool, Error> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err(Error::no_name(name, text, ["on", "off"])),
    }
}

/// The value of an option as text.
struct Value(String);

impl<'de> Deserialize<'de> for Value {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        // What does not describe itself has text alone.
        if from.is_human_readable() { from.deserialize_any(ValueOf) } else { from.deserialize_str(ValueOf) }
    }
}

struct ValueOf;

impl Visitor<'_> for ValueOf {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("text, a number, true or false")
    }

    fn visit_str<E>(self, text: &str) -> Result<Value, E> {
        Ok(Value(text.into()))
    }

    fn visit_bool<E>(self, on: bool) -> Result<Value, E> {
        Ok(Value(if on { "on" } else { "off" }.into()))
    }

    fn visit_i64<E>(self, number: i64) -> Result<Value, E> {
        Ok(Value(number.to_string()))
    }

    fn visit_u64<E>(self, number: u64) -> Result<Value, E> {
        Ok(Value(number.to_string()))
    }

    fn visit_f64<E>(self, number: f64) -> Result<Value, E> {
        Ok(Value(number.to_string()))
    }
}

/// [`Camera`] before its ranges are checked.
#[derive(Deserialize)]
#[serde(rename = "Camera", deny_unknown_fields)]
struct CameraFields {
    focal: f64,
    baseline: f64,
    #[serde(default)]
    doffs: f64,
    #[serde(default)]
    cx: f64,
    #[serde(default)]
    cy: f64,
}

/// A map of its fields, of which `doffs`, `cx` and `cy` are 0 if they are missing. A number out of its range is an error with the
/// text of [`Camera::validate`].
impl<'de> Deserialize<'de> for Camera {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let CameraFields { focal, baseline, doffs, cx, cy } = Deserialize::deserialize(from)?;
        let camera = Self { focal, baseline, doffs, cx, cy };
        camera.validate().map_err(D::Error::custom)?;
        Ok(camera)
    }
}

/// What a [`Rectification`] is made from.
#[derive(Serialize, Deserialize)]
#[serde(rename = "Rectification", deny_unknown_fields)]
struct RectificationFields {
    size: [u32; 2],
    rectified: [u32; 2],
    turned: bool,
    lenses: [Lens; 2],
}

/// A map of `size` and `rectified`, columns and rows, `turned`, and the two `lenses`: of the turned images, if they are.
impl Serialize for Rectification {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let (size, rectified, turned) = (self.size(), self.rectified_size(), self.is_turned());
        RectificationFields { size, rectified, turned, lenses: *self.lenses() }.serialize(to)
    }
}

/// A map as it is written. What is no rectification is an error with the text of [`Rectification::new`].
impl<'de> Deserialize<'de> for Rectification {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let RectificationFields { size, rectified, turned, lenses } = Deserialize::deserialize(from)?;
        Self::made(size, rectified, turned, lenses).map_err(D::Error::custom)
    }
}
