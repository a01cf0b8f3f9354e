//! Numbered files: a map of each frame, named by the frame's number.

use crate::engine::output_files;
use crate::engine::pairs::Pattern;
use crate::engine::pipeline::{MatchedPair, Refused, Work};
use gpu_stereo::files::encoders::Format;
use gpu_stereo::files::outputs::Output;
use std::path::PathBuf;

/// The files of each frame.
pub struct Numbered {
    naming: Naming,
    /// The number of the first frame.
    first: u64,
}

/// How the files are called.
pub enum Naming {
    /// One file a frame.
    Pattern(Pattern, Format),
    /// Several files in a folder, whose names begin with six digits.
    Folder(PathBuf, Vec<Format>),
}

impl Numbered {
    /// Files that are called so, the first of them with this number.
    pub fn new(naming: Naming, first: u64) -> Self {
        Self { naming, first }
    }

    /// The files of a frame.
    pub fn outputs(&self, place: usize) -> Vec<Output> {
        let number = self.first + place as u64;
        match &self.naming {
            Naming::Pattern(pattern, format) => vec![Output::at(pattern.path(number), *format)],
            Naming::Folder(folder, formats) => output_files::of_name(folder, format!("{number:06}").as_ref(), formats),
        }
    }
}

impl Work for Numbered {
    fn write(&self, pair: &MatchedPair) -> Result<(), Refused> {
        let written = output_files::write(&self.outputs(pair.place), &pair.matched, pair.images(), &pair.params);
        written.map(drop).map_err(Refused::of)
    }
}
