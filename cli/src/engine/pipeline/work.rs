//! What the pipeline takes and returns: the setup, the source and the sink of pairs, and the results.

use crate::args::{DeviceArgs, InputArgs};
use crate::engine::compute::{EngineNames, ParamsBySize};
use crate::engine::pair::Pair;
use crate::engine::{disk, images};
use crate::terminal::{one_line, warnings};
use anyhow::{Result, bail};
use gpu_stereo::files::JsonPath;
use gpu_stereo::files::images::ImagePair;
use gpu_stereo::{Error, Image, Matched, Params};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// How to match the pairs.
#[derive(Clone, Copy)]
pub struct Setup<'a> {
    /// Where to compute.
    pub device: &'a DeviceArgs,
    /// The settings.
    pub params: &'a ParamsBySize,
    /// How the images are read.
    pub input: &'a InputArgs,
    /// One of so many pairs is diagnosed.
    pub diagnosed: usize,
    /// Whether the right images are kept for what is written.
    pub keeps_right: bool,
    /// Pairs on the device at a time.
    pub in_flight: usize,
    /// Threads that read.
    pub readers: usize,
    /// Threads that write; with one, the maps come in order.
    pub writers: usize,
    /// Whether pairs may differ in size and samples; else all must be as the first one.
    pub mixed: bool,
    /// The kind that all must have, if it is known beforehand.
    pub kind: Option<&'a PairKind>,
    /// Whether each pair is written before the next one is read.
    pub alone: bool,
    /// What the progress counts.
    pub unit: &'static str,
    /// Whether the range of all pairs is that of the first ones, which may not hold what the others show.
    pub of_first: bool,
    /// Show no progress.
    pub quiet: bool,
}

/// The pairs to match, in their order.
#[derive(Clone, Copy)]
pub enum Sequence<'a> {
    /// Files, which several threads may read.
    Files(&'a [Pair]),
    /// A stream of this name: one thread reads pair after pair until it ends.
    Stream(&'a Path),
}

impl Sequence<'_> {
    /// How many pairs there are, if that is known.
    pub fn len(&self) -> Option<usize> {
        if let Self::Files(pairs) = self { Some(pairs.len()) } else { None }
    }

    /// The files of a pair; of a stream its name with the number of the pair. None behind the last one.
    pub fn pair(&self, place: usize) -> Option<Cow<'_, Pair>> {
        match self {
            Self::Files(pairs) => pairs.get(place).map(Cow::Borrowed),
            Self::Stream(name) => {
                let mut numbered = name.as_os_str().to_owned();
                numbered.push(format!("#{place}"));
                Some(Cow::Owned(Pair::in_one(numbered.as_ref())))
            }
        }
    }

    /// The name of a pair.
    pub fn name(&self, place: usize) -> PathBuf {
        self.pair(place).map(|pair| pair.left.clone()).unwrap_or_default()
    }
}

/// A pair's left image and its map.
pub struct MatchedPair {
    /// Which pair it is.
    pub place: usize,
    /// The left image.
    pub left: Image,
    /// The right image, if it is kept.
    pub right: Option<Image>,
    /// The map.
    pub matched: Matched,
    /// The settings that it was computed with.
    pub params: Arc<Params>,
}

impl MatchedPair {
    /// The images, as far as they are kept.
    pub fn images(&self) -> (&Image, Option<&Image>) {
        (&self.left, self.right.as_ref())
    }
}

/// The size and the format of a pair, in words.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PairKind(String);

impl PairKind {
    /// The kind of an image.
    pub fn of(image: &Image) -> Self {
        Self(format!("{}x{} in {:?}", image.width(), image.height(), image.format()))
    }

    /// Refuses an image of another kind.
    pub fn ensure(&self, image: &Image) -> Result<()> {
        let (Self(first), it) = (self, Self::of(image));
        if it != *self {
            let it = it.0;
            bail!(Error::Image(format!(
                "it is {it}, but the first frame is {first}; give frames of one size and format"
            )));
        }
        Ok(())
    }
}

/// Why a pair could not be read or written.
pub enum Refused {
    /// The others are not affected.
    Pair(anyhow::Error),
    /// None of the others could be, either.
    All(anyhow::Error),
    /// There is none: the stream has ended.
    End,
}

impl Refused {
    /// A failure to write: some, such as a full disk, affect all that follow.
    pub fn of(error: anyhow::Error) -> Self {
        if disk::is_lasting(&error) { Self::All(error) } else { Self::Pair(error) }
    }
}

/// Where pairs come from, and where their maps go.
pub trait Work: Sync {
    /// Reads a pair.
    fn read(&self, _place: usize, pair: &Pair, options: &InputArgs) -> Result<ImagePair, Refused> {
        images::read_pair(&pair.left, &pair.right, options).map_err(Refused::Pair)
    }

    /// Writes a map.
    fn write(&self, pair: &MatchedPair) -> Result<(), Refused>;

    /// Records that a pair failed, and why.
    fn failed(&self, _place: usize, _error: &str) -> Result<()> {
        Ok(())
    }
}

/// The results of all pairs.
#[derive(Debug, Default)]
pub struct Ran {
    /// The adapter and its driver, if there was anything to compute.
    pub names: Option<EngineNames>,
    /// Columns and rows.
    pub size: Option<(u32, u32)>,
    /// Bytes in use on the device.
    pub device_bytes: u64,
    /// Pairs whose maps were written.
    pub done: usize,
    /// Pairs that failed.
    pub failed: Vec<FailedPair>,
    /// Pairs whose map is doubtful, with why: the first ones of a stream, which may be endless.
    pub doubtful: Vec<(usize, String)>,
    /// How many pairs have a doubtful map.
    pub doubtful_pairs: usize,
    /// From the start to the last map written.
    pub seconds: f64,
    /// The error that ended the run early.
    pub stopped: Option<anyhow::Error>,
}

impl Ran {
    /// All that is doubtful, as `--json` lists it.
    pub fn warnings(&self) -> Vec<String> {
        let of_pairs = self.doubtful.iter().map(|(_, text)| one_line(text));
        warnings::all().into_iter().chain(of_pairs).collect()
    }
}

/// A pair that failed.
#[derive(Debug, Serialize)]
pub struct FailedPair {
    /// Which pair it is.
    #[serde(skip)]
    pub place: usize,
    /// The left image's path.
    pub frame: JsonPath,
    /// Why.
    pub error: String,
}
