//! Record: what the maps of a folder were made with, in a file beside them, so that no folder holds maps of two settings.

use crate::output::Output;
use anyhow::{Context as _, Result, bail, ensure};
use gpu_stereo::Params;
use serde_json::{Map, Value};
use std::fs::{self, File, OpenOptions};
use std::io::{ErrorKind, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

/// The file's name.
const NAME: &str = "gpu-stereo.json";

/// The record of a folder.
#[derive(Debug)]
pub struct Record {
    path: PathBuf,
    made_with: Map<String, Value>,
}

impl Record {
    /// The record that maps with `params` of what `sources` names have in `folder`.
    pub fn new(folder: &Path, params: &Params, sources: &[(&str, &Path)]) -> Self {
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
        let differing: Vec<_> = differing.collect();
        if !differing.is_empty() {
            bail!("--resume would mix maps: {} ({path:?}); run as before, or without it", differing.join(", "));
        }
        Ok(())
    }

    /// Says that the folder's maps are made with this from now on. Maps of `outputs` that were made with anything else go,
    /// or an interrupted run would leave both kinds.
    ///
    /// Other processes may do so at once: the first one locks out the rest.
    pub fn begin<'a>(&self, mut outputs: impl Iterator<Item = &'a Output>) -> Result<()> {
        let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&self.path)?;
        let mut lock = fd_lock::RwLock::new(file);
        let mut file = lock.write().context("it cannot be locked")?;
        if self.is_in(&mut file)? {
            return Ok(());
        }
        // Empty, it vouches for nothing, should the process end here.
        file.set_len(0)?;
        outputs.try_for_each(|output| match fs::remove_file(&output.path) {
            Err(error) if error.kind() != ErrorKind::NotFound && !output.path.is_dir() => Err(error),
            _ => Ok(()),
        })?;
        file.seek(SeekFrom::Start(0))?;
        file.write_all((serde_json::to_string_pretty(&self.made_with)? + "\n").as_bytes())?;
        Ok(())
    }

    fn is_in(&self, file: &mut File) -> Result<bool> {
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes)?;
        Ok(serde_json::from_slice::<Map<String, Value>>(&bytes).is_ok_and(|there| there == self.made_with))
    }
}
