//! Record: what the maps of a folder were made with, in a file beside them, so that no folder holds maps of two settings.

use crate::args::{Bits, InputArgs};
use crate::output::Output;
use anyhow::{Context as _, Result, bail, ensure};
use gpu_stereo::{Masks, Params};
use serde_json::{Map, Value};
use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::{ErrorKind, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

/// The file's name.
const NAME: &str = "gpu-stereo.json";

/// Where it lists the names of the files that go when others are made in the folder.
const FILES: &str = "files";

/// A file's bytes while nobody writes it.
pub fn read_shared(path: &Path) -> std::io::Result<Vec<u8>> {
    let lock = fd_lock::RwLock::new(File::open(path)?);
    let file = lock.read()?;
    let mut bytes = Vec::new();
    (&*file).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// What a folder has a record of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Found {
    /// Maps that were made with the same.
    Same,
    /// No maps.
    Nothing,
}

/// The record of a folder.
#[derive(Debug)]
pub struct Record {
    path: PathBuf,
    made_with: Map<String, Value>,
}

impl Record {
    /// The record that maps with `params` of what `sources` names, read as `input` says, have in `folder`.
    pub fn new(folder: &Path, params: &Params, input: &InputArgs, sources: &[(&str, &Path)]) -> Self {
        let mut made_with = Map::new();
        made_with.insert("version".into(), env!("CARGO_PKG_VERSION").into());
        for (name, path) in sources {
            let path = std::path::absolute(path).unwrap_or_else(|_| path.into());
            made_with.insert((*name).into(), path.to_string_lossy().into());
        }
        // Those of the device change no bit.
        for option in Params::OPTIONS.iter().filter(|option| option.heading != "Device") {
            made_with.insert(option.name.into(), option.get(params).into());
        }
        if let Some(masks) = &params.masks {
            made_with.insert("mask-in".into(), digest(masks).into());
        }
        // As they usually are, they are not named.
        if input.swap {
            made_with.insert("swap".into(), true.into());
        }
        if let Bits::Given(bits) = input.bits {
            made_with.insert("bits".into(), bits.into());
        }
        Self { path: folder.join(NAME), made_with }
    }

    /// The maps that `exist` were made with the same. `exist`: whether there are any.
    pub fn ensure_same(&self, exist: bool) -> Result<()> {
        let path = &self.path;
        let text = match fs::read_to_string(path) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => {
                ensure!(
                    !exist,
                    "--resume would keep maps of unknown settings, since there is no {path:?}; run without it"
                );
                return Ok(());
            }
            Err(error) => return Err(error).with_context(|| format!("{path:?} cannot be read; run without --resume")),
        };
        let there: Map<String, Value> = serde_json::from_str(&text).with_context(|| {
            format!("{path:?} is damaged, so the settings of the maps are unknown; run without --resume")
        })?;
        let differing = self.differing(&there);
        if !differing.is_empty() {
            bail!("--resume would mix maps: {differing} ({path:?}); run as before, or without it");
        }
        Ok(())
    }

    /// The settings that are not as they are `there`, in words; empty if there are none.
    fn differing(&self, there: &Map<String, Value>) -> String {
        let told = |value: Option<&Value>| match value {
            Some(Value::String(text)) => text.clone(),
            Some(other) => other.to_string(),
            None => "not known".into(),
        };
        let others = there.keys().filter(|name| !self.made_with.contains_key(*name) && *name != FILES);
        let names = self.made_with.keys().chain(others);
        let differing = names
            .filter(|name| there.get(*name) != self.made_with.get(*name))
            .map(|name| format!("{name} {} there and {} now", told(there.get(name)), told(self.made_with.get(name))));
        differing.collect::<Vec<_>>().join(", ")
    }

    /// The maps of the folder, if there is a record of any, were made with the same.
    pub fn ensure_no_other(&self) -> Result<Found> {
        match read_shared(&self.path) {
            Ok(bytes) => self.found(&bytes),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(Found::Nothing),
            Err(error) => Err(error).with_context(|| format!("{:?} cannot be read; check its permissions", self.path)),
        }
    }

    /// One that is cut short was never finished, and no map was made with it.
    fn found(&self, bytes: &[u8]) -> Result<Found> {
        let Ok(there) = serde_json::from_slice(bytes) else { return Ok(Found::Nothing) };
        let differing = self.differing(&there);
        ensure!(
            differing.is_empty(),
            "the output folder has maps that were made otherwise: {differing} ({:?}); run as before, or give another \
             folder",
            self.path
        );
        Ok(Found::Same)
    }

    /// Says that the folder's maps are made with this from now on, `outputs` among them. Maps that were made with anything
    /// else go, those that the record lists and those of `outputs`: or an interrupted run would leave both kinds.
    ///
    /// Other processes may do so at once: the first one locks out the rest.
    pub fn begin<'a>(&self, outputs: impl Iterator<Item = &'a Output>) -> Result<()> {
        let name = |output: &Output| output.path.file_name().map(|name| name.to_string_lossy().into_owned());
        let names: BTreeSet<String> = outputs.filter_map(name).collect();
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let remove = |name: &String| {
            let path = folder.join(name);
            match fs::remove_file(&path) {
                Err(error) if error.kind() != ErrorKind::NotFound && !path.is_dir() => Err(error),
                _ => Ok(()),
            }
        };
        let found = |bytes: &[u8]| Ok(self.found(bytes).unwrap_or(Found::Nothing));
        self.write(found, |listed| listed.union(&names).try_for_each(remove), &names)
    }

    /// As [`Record::begin`], but maps that were made with anything else are an error, and none are listed. `first`: what to do
    /// if there are none.
    pub fn join(&self, first: impl FnOnce() -> std::io::Result<()>) -> Result<()> {
        self.write(|bytes| self.found(bytes), |_| first(), &BTreeSet::new())
    }

    fn write(
        &self,
        found: impl Fn(&[u8]) -> Result<Found>,
        before: impl FnOnce(&BTreeSet<String>) -> std::io::Result<()>,
        names: &BTreeSet<String>,
    ) -> Result<()> {
        let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&self.path);
        let mut lock = fd_lock::RwLock::new(file.with_context(|| format!("{:?} cannot be written", self.path))?);
        let mut file = lock.write().with_context(|| format!("{:?} cannot be locked", self.path))?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes)?;
        let mut listed = listed(&bytes);
        let same = found(&bytes)? == Found::Same;
        if same && names.is_subset(&listed) {
            return Ok(());
        }
        // Empty, it vouches for nothing, should the process end here.
        file.set_len(0)?;
        if !same {
            before(&listed)?;
            listed.clear();
        }
        listed.extend(names.iter().cloned());
        let mut record = self.made_with.clone();
        if !listed.is_empty() {
            record.insert(FILES.into(), listed.into_iter().collect());
        }
        file.seek(SeekFrom::Start(0))?;
        file.write_all((serde_json::to_string_pretty(&record)? + "\n").as_bytes())?;
        Ok(())
    }
}

/// Stands for masks: the size, and FNV-1a of the bytes of both sides.
fn digest(masks: &Masks) -> String {
    let byte = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
    let side = |hash, side| masks.side(side).map_or(byte(hash, &1), |mask| mask.iter().fold(hash, byte));
    let [width, height] = masks.size();
    format!("{width}x{height} {:016x}", side(side(0xcbf2_9ce4_8422_2325, 0), 1))
}

/// The files that a record lists: plain names, or somebody else wrote it.
fn listed(record: &[u8]) -> BTreeSet<String> {
    let record: Map<String, Value> = serde_json::from_slice(record).unwrap_or_default();
    let names = record.get(FILES).and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str);
    let plain = |name: &&str| Path::new(name).file_name().is_some_and(|last| last == *name);
    names.filter(plain).map(Into::into).collect()
}
