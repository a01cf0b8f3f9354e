//! A file of weights as a whole.

use super::values::{Element, Given, shown};
use super::{safetensors, torch};
use crate::files::contents::{self, MAX_BYTES};
use crate::files::error::{Context as _, Result, bail, ensure};
use crate::files::facts::Facts;
use crate::network::{Network, Tensors};
use std::collections::BTreeMap;
use std::fmt;
use std::hash::Hasher as _;
use std::path::Path;
use twox_hash::XxHash3_64;

/// The format of a file of weights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum WeightsFormat {
    /// .safetensors.
    SafeTensors,
    /// What `torch.save` has written since PyTorch 1.6: an archive.
    Archive,
    /// What it wrote before: pickles and storages.
    Legacy,
}

impl fmt::Display for WeightsFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::SafeTensors => "safetensors",
            Self::Archive => "PyTorch archive",
            Self::Legacy => "PyTorch before 1.6",
        })
    }
}

/// The tensors of a file.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Weights {
    /// How they are stored.
    pub format: WeightsFormat,
    /// All by their names, as they stand in the file.
    pub tensors: Tensors,
    /// The type that the numbers of each have in the file.
    pub elements: BTreeMap<String, Element>,
}

impl Weights {
    /// Reads a file.
    ///
    /// # Errors
    /// If it cannot be read, is of no format that is known, or damaged; if a pickle asks for more than tensors; or if a name is
    /// there twice, with and without `module.` before it.
    pub fn read(path: &Path) -> Result<Self> {
        Self::read_with_facts(path).map(|(weights, _)| weights)
    }

    /// As [`Self::read`], with the facts that show later whether the file has changed.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_with_facts(path: &Path) -> Result<(Self, Facts)> {
        let length = std::fs::metadata(path).map_or(0, |kind| kind.len());
        ensure!(
            length <= MAX_BYTES,
            "{path:?} has {length} bytes, but at most {MAX_BYTES} are read; give weights of PSMNet, which have 21 MB"
        );
        let (bytes, facts) = contents::read_file_with_facts(path, "weights of PSMNet")?;
        Ok((Self::parse(path, &bytes)?, facts))
    }

    /// As [`Self::read`], from a file's bytes.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn parse(path: &Path, bytes: &[u8]) -> Result<Self> {
        let in_file = || format!("{path:?} cannot be read as weights");
        let (format, all) = match bytes {
            // First, since the length of a header may look like the beginning of a pickle.
            _ if safetensors::is_one(bytes) => (WeightsFormat::SafeTensors, safetensors::parse(bytes)),
            [b'P', b'K', 3 | 5 | 6, ..] => (WeightsFormat::Archive, torch::archive(bytes)),
            [0x80, 2..=5, ..] => (WeightsFormat::Legacy, torch::legacy(bytes)),
            _ => bail!(
                "{path:?} {}, but weights are .safetensors or what torch.save writes; convert it, or download it again",
                looks(bytes)
            ),
        };
        let mut weights = Self { format, tensors: Tensors::new(), elements: BTreeMap::new() };
        let mut known = std::collections::BTreeSet::new();
        for Given { name, element, tensor } in all.with_context(in_file)? {
            let short = name.strip_prefix("module.").unwrap_or(&name);
            ensure!(
                known.insert(short.to_owned()),
                "{path:?} has the tensor {} twice, perhaps once with \"module.\" before it; save one of them",
                shown(short)
            );
            weights.elements.insert(name.clone(), element);
            weights.tensors.insert(name, tensor);
        }
        Ok(weights)
    }

    /// The network that they are the weights of.
    ///
    /// # Errors
    /// If they are of none, or one is missing, unknown or misshapen.
    pub fn network(self) -> Result<Network> {
        Ok(Network::new(self.tensors)?)
    }
}

/// What a file seems to be, for the error that it is none of weights.
fn looks(bytes: &[u8]) -> &'static str {
    match bytes {
        [0x1f, 0x8b, ..] => "is compressed (gzip)",
        [0x89, b'H', b'D', b'F', ..] => "is HDF5",
        [b'<', ..] => "is a page of the web",
        _ if bytes.get(257..262) == Some(b"ustar") => "is an archive of files (tar)",
        _ => "is in no known format",
    }
}

/// A hash of all weights that inference reads: equal for equal networks, whatever file they were read from.
pub fn fingerprint(network: &Network) -> String {
    let convolutions = network.operations().iter().filter_map(|operation| network.convolution(&operation.name));
    let numbers = convolutions.flat_map(|convolution| convolution.weights.data().iter().chain(&convolution.bias));
    hashed(&network.architecture().to_string(), numbers.map(|number| number.to_le_bytes()))
}

/// A hash of a name and numbers.
pub(super) fn hashed(name: &str, numbers: impl Iterator<Item = [u8; 4]>) -> String {
    let mut hasher = XxHash3_64::default();
    hasher.write(name.as_bytes());
    numbers.for_each(|number| hasher.write(&number));
    format!("{:016x}", hasher.finish())
}

impl Network {
    /// From a file of weights: .safetensors, or what `torch.save` writes, such as the published .tar. Nothing in it is
    /// executed.
    ///
    /// # Errors
    /// If the file cannot be read, or its tensors are not those of a network; the error names the first few.
    pub fn load(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        Weights::read(path)?.network().with_context(|| format!("{path:?}"))
    }
}
