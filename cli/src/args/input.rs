//! `--swap`, `--split`, `--bits` and `--mask-in`: how images are read, and which of their pixels count.

use super::choices;
use gpu_stereo::files::images::{Bits, Split};
use std::path::PathBuf;

/// How images are read.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "Input")]
pub struct InputArgs {
    /// Exchange LEFT and RIGHT
    #[arg(long)]
    pub swap: bool,

    /// One picture shows both views, and is given alone: where they lie in it
    #[arg(long, value_name = "HOW", value_parser = choices::split())]
    pub split: Option<Split>,

    /// The bits that samples of 16-bit images have, 8 to 16; auto: 8, 10, 12, 14 or 16, as the largest sample of the pair
    /// (of a video, of its first pair) needs. They are stretched to 16
    #[arg(long, value_name = "N|auto", default_value = "auto", allow_negative_numbers = true)]
    pub bits: Bits,
}

impl InputArgs {
    /// The same for many pairs: files that are given alone say where their views are, if no option does.
    pub fn of_many(&self) -> Self {
        Self { split: self.split.or(Some(Split::Auto)), ..self.clone() }
    }
}

/// Which pixels count.
#[derive(Debug, clap::Args)]
pub struct MaskArgs {
    /// Which pixels of the given images have content: images of their size, 0 where there is none (alpha is ignored). Pixels
    /// without content have no disparity, nor have those that lead to one. LEFT alone, or ,RIGHT alone, masks one side; a name
    /// with commas is taken as one name if such a file is there
    #[arg(long, value_name = "LEFT[,RIGHT]")]
    pub mask_in: Option<PathBuf>,
}
