//! The record: the settings that the maps of a folder were made with, in a file beside them, so that no folder mixes maps of
//! different settings.
//!
//! Its lock guards the whole folder, for videos and batches alike.

use crate::args::InputArgs;
use crate::engine::{disk, log};
use anyhow::Result;
use gpu_stereo::files::images::{Bits, Split};
use gpu_stereo::files::lists::absolute;
use gpu_stereo::files::weights::fingerprint;
use gpu_stereo::files::{JsonPath, hash};
use gpu_stereo::{Masks, Params};
use serde_json::{Map, Value};
use std::fs::OpenOptions;
use std::io::{Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

/// The file's name.
pub const NAME: &str = "gpu-stereo.json";

/// The maps that a folder has, by its record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Contents {
    /// Maps of the same settings.
    Same,
    /// No maps.
    Nothing,
    /// Maps of other settings; what differs, in words.
    Other(String),
    /// Maps of another verb.
    OtherVerb(&'static str),
}

/// The record of a folder.
#[derive(Debug)]
pub struct Record {
    /// Where it is.
    pub path: PathBuf,
    made_with: Map<String, Value>,
}

impl Record {
    /// The record that the maps in `folder` are made with `params` of images read as `input` says, and with what `more` names. A
    /// video has `sources`, two names with a path each.
    pub fn new(
        folder: &Path,
        params: &Params,
        more: &[(&str, String)],
        input: &InputArgs,
        sources: &[(&str, &Path)],
    ) -> Self {
        let mut made_with = Map::new();
        made_with.insert("version".into(), env!("CARGO_PKG_VERSION").into());
        for (name, path) in sources {
            made_with.insert((*name).into(), serde_json::to_value(JsonPath(absolute(path))).unwrap_or_default());
        }
        // Options of the device change no bit.
        for option in Params::OPTIONS.iter().filter(|option| option.heading != "Device") {
            made_with.insert(option.name.into(), option.get(params).into());
        }
        if let Some(masks) = &params.masks {
            made_with.insert("mask-in".into(), digest(masks).into());
        }
        if let Some(network) = &params.network {
            made_with.insert("weights".into(), fingerprint(network).into());
        }
        if let Some(network) = params.features.as_ref().filter(|_| params.takes_features()) {
            made_with.insert("weights".into(), network.fingerprint().into());
        }
        made_with.extend(more.iter().map(|(name, value)| ((*name).into(), value.as_str().into())));
        // Defaults are not recorded.
        if input.swap {
            made_with.insert("swap".into(), true.into());
        }
        if let Some(split) = input.split.filter(|split| *split != Split::Auto) {
            made_with.insert("split".into(), format!("{split:?}").into());
        }
        if let Bits::Given(bits) = input.bits {
            made_with.insert("bits".into(), bits.into());
        }
        Self { path: folder.join(NAME), made_with }
    }

    /// The fingerprint of the settings, for the entries of maps.
    pub fn fingerprint(&self) -> String {
        hash(Value::from(self.made_with.clone()).to_string().as_bytes())
    }

    /// The settings that differ from those `there`, in words; empty if none does.
    fn differing(&self, there: &Map<String, Value>) -> String {
        let told = |value: Option<&Value>| match value {
            Some(Value::String(text)) => text.clone(),
            Some(other) => other.to_string(),
            None => "not known".into(),
        };
        let others = there.keys().filter(|name| !self.made_with.contains_key(*name));
        let names = self.made_with.keys().chain(others);
        let differing = names
            .filter(|name| there.get(*name) != self.made_with.get(*name))
            .map(|name| format!("{name} {} there and {} now", told(there.get(name)), told(self.made_with.get(name))));
        differing.collect::<Vec<_>>().join(", ")
    }

    /// What the folder's maps were made with.
    pub fn find(&self) -> Result<Contents> {
        let read = || -> Result<Vec<u8>> {
            let mut bytes = Vec::new();
            disk::open_own(&self.path, OpenOptions::new().read(true))?.read_to_end(&mut bytes)?;
            Ok(bytes)
        };
        match read() {
            Ok(bytes) => Ok(self.contents(&bytes)),
            Err(error) if log::is_missing(&error) => Ok(Contents::Nothing),
            Err(error) => Err(error),
        }
    }

    /// A truncated record was never finished, so no map was made with it.
    fn contents(&self, bytes: &[u8]) -> Contents {
        let Ok(there) = serde_json::from_slice(bytes) else { return Contents::Nothing };
        let is_video = |made_with: &Map<String, Value>| made_with.contains_key("left");
        match (is_video(&there), is_video(&self.made_with)) {
            (true, false) => return Contents::OtherVerb("video"),
            (false, true) => return Contents::OtherVerb("batch"),
            _ => {}
        }
        match self.differing(&there) {
            none if none.is_empty() => Contents::Same,
            differing => Contents::Other(differing),
        }
    }

    /// Writes the record, and syncs it before any map is written. `decide` is given what was there, and removes it or refuses; the
    /// lock is held meanwhile.
    pub fn begin(&self, decide: impl FnOnce(&Contents) -> Result<()>) -> Result<()> {
        let file = disk::open_own(&self.path, OpenOptions::new().read(true).write(true).create(true).truncate(false))?;
        disk::locked(&self.path, file, |file| {
            let mut bytes = Vec::new();
            file.read_to_end(&mut bytes)?;
            let found = self.contents(&bytes);
            if matches!(found, Contents::Other(_) | Contents::OtherVerb(_)) {
                decide(&found)?;
                // Emptied first, so that it is void if the process ends here.
                file.set_len(0)?;
                disk::sync(file)?;
            } else {
                decide(&found)?;
            }
            if found != Contents::Same {
                file.set_len(0)?;
                file.seek(SeekFrom::Start(0))?;
                file.write_all((serde_json::to_string_pretty(&self.made_with)? + "\n").as_bytes())?;
                disk::sync(file)?;
                disk::sync_folder(self.path.parent().unwrap_or(Path::new("")))?;
            }
            Ok(())
        })
        .map_err(|error: anyhow::Error| disk::unwritten(error, format_args!("{:?}", self.path)))
    }
}

/// A digest of masks: the size, and FNV-1a of the bytes of both sides.
fn digest(masks: &Masks) -> String {
    let byte = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
    let side = |hash, side| masks.side(side).map_or(byte(hash, &1), |mask| mask.iter().fold(hash, byte));
    let [width, height] = masks.size();
    format!("{width}x{height} {:016x}", side(side(0xcbf2_9ce4_8422_2325, 0), 1))
}
