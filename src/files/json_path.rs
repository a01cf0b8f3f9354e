//! Paths in JSON without loss: a string, or `{"hex": "6cff"}`, the bytes of a name that is not Unicode.

use serde::de::{self, MapAccess, Visitor};
use serde::ser::SerializeMap as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::ffi::{OsStr, OsString};
use std::fmt;
use std::path::PathBuf;

/// The key of the bytes.
const HEX: &str = "hex";

/// A path.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct JsonPath(pub PathBuf);

impl<P: Into<PathBuf>> From<P> for JsonPath {
    fn from(path: P) -> Self {
        Self(path.into())
    }
}

impl Serialize for JsonPath {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if let Some(text) = self.0.to_str() {
            return serializer.serialize_str(text);
        }
        let mut map = serializer.serialize_map(Some(1))?;
        map.serialize_entry(HEX, &units(self.0.as_os_str()))?;
        map.end()
    }
}

impl<'de> Deserialize<'de> for JsonPath {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Form)
    }
}

struct Form;

impl<'de> Visitor<'de> for Form {
    type Value = JsonPath;

    fn expecting(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str("a path")
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<JsonPath, E> {
        Ok(JsonPath(text.into()))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<JsonPath, A::Error> {
        let wrong = || de::Error::custom("a path that is not Unicode is an object such as {\"hex\": \"6cff2e706e67\"}");
        let (key, hex) = map.next_entry::<String, String>()?.ok_or_else(wrong)?;
        if key != HEX || map.next_key::<String>()?.is_some() {
            return Err(wrong());
        }
        name(&hex).map(|name| JsonPath(name.into())).ok_or_else(wrong)
    }
}

/// The bytes of a name, two hexadecimal digits each.
#[cfg(not(windows))]
fn units(name: &OsStr) -> String {
    name.as_encoded_bytes().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The 16-bit units of a name, four hexadecimal digits each.
#[cfg(windows)]
fn units(name: &OsStr) -> String {
    use std::os::windows::ffi::OsStrExt as _;
    name.encode_wide().map(|unit| format!("{unit:04x}")).collect()
}

#[cfg(unix)]
fn name(hex: &str) -> Option<OsString> {
    use std::os::unix::ffi::OsStringExt as _;
    Some(OsString::from_vec(parse(hex, 2)?.into_iter().map(|unit| unit as u8).collect()))
}

#[cfg(windows)]
fn name(hex: &str) -> Option<OsString> {
    use std::os::windows::ffi::OsStringExt as _;
    Some(OsString::from_wide(&parse(hex, 4)?))
}

#[cfg(not(any(unix, windows)))]
fn name(hex: &str) -> Option<OsString> {
    let bytes = parse(hex, 2)?.into_iter().map(|unit| unit as u8).collect();
    String::from_utf8(bytes).ok().map(Into::into)
}

fn parse(hex: &str, digits: usize) -> Option<Vec<u16>> {
    let is_hex = hex.bytes().all(|digit| digit.is_ascii_hexdigit()) && hex.len().is_multiple_of(digits);
    let unit = |at: usize| u16::from_str_radix(&hex[at..at + digits], 16).ok();
    is_hex.then(|| (0..hex.len()).step_by(digits).map(unit).collect()).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_text() {
        let name = JsonPath::from("a/ä \"b\"\n");
        let json = serde_json::to_string(&name).unwrap();
        assert_eq!(json, r#""a/ä \"b\"\n""#);
        assert_eq!(serde_json::from_str::<JsonPath>(&json).unwrap(), name);
        for wrong in
            ["1", "null", "{}", r#"{"hex": "f"}"#, r#"{"hex": "+f"}"#, r#"{"hex": "66", "a": "b"}"#, r#"{"x": "66"}"#]
        {
            assert!(serde_json::from_str::<JsonPath>(wrong).is_err(), "{wrong}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn bytes_are_bytes() {
        use std::os::unix::ffi::OsStrExt as _;
        let name = JsonPath::from(OsStr::from_bytes(b"a/\xff\x00\x80.png"));
        let json = serde_json::to_string(&name).unwrap();
        assert_eq!(json, r#"{"hex":"612fff00802e706e67"}"#);
        assert_eq!(serde_json::from_str::<JsonPath>(&json).unwrap(), name);
    }
}
