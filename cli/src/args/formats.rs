//! `--format` and `--maps`: the files of each map, for verbs that write many.

use super::choices;
use super::headings::OUTPUT;
use anyhow::{Result, ensure};
use gpu_stereo::Colors;
use gpu_stereo::files::encoders::{Format, Look};
use std::path::PathBuf;

/// What is written of each pair.
#[derive(Clone, Debug, clap::Args)]
pub struct FormatArgs {
    /// What to write of each pair, with commas between them. The map: png (16 bit as KITTI), pfm, npy, tif. Pictures: color,
    /// mask, confidence; rectified-left, rectified-right. right: the right view's map. With cameras depth (PNG in millimetres) and points (PLY). Endings follow
    /// a dash: right-pfm, depth-npy, points-pcd and so on [default: png]
    #[arg(long, value_name = "FORMAT", value_delimiter = ',', value_parser = choices::format(), hide_possible_values = true, help_heading = OUTPUT)]
    pub format: Vec<Format>,
}

/// A folder of maps beside what the verb writes otherwise.
#[derive(Clone, Debug, clap::Args)]
pub struct MapsArgs {
    /// Write every map into this folder, created if missing, as --format says
    #[arg(long, value_name = "FOLDER", help_heading = OUTPUT)]
    pub maps: Option<PathBuf>,

    /// What is written of each
    #[command(flatten)]
    pub formats: FormatArgs,
}

impl MapsArgs {
    /// Refuses formats without a folder.
    pub fn ensure_folder(&self) -> Result<()> {
        ensure!(
            self.maps.is_some() || self.formats.format.is_empty(),
            "--format says what the folder of maps has, but none is given; add --maps FOLDER"
        );
        Ok(())
    }
}

/// How maps are drawn as pictures.
#[derive(Clone, Debug, clap::Args)]
pub struct LookArgs {
    /// The colours of maps, of small disparities to large ones; black is no disparity, and no other colour is near it
    #[arg(long, value_name = "COLORS", value_parser = choices::colors(), default_value = "turbo", help_heading = OUTPUT)]
    pub colors: Colors,

    /// Draw a bar beside each picture of a map: what its colours stand for, in metres where the cameras are known, else in px
    #[arg(long, help_heading = OUTPUT)]
    pub scale_bar: bool,
}

impl LookArgs {
    /// What they say.
    pub fn look(&self) -> Look {
        Look { colors: self.colors, scale_bar: self.scale_bar }
    }

    /// The formats, with the look of pictures.
    pub fn dressed(&self, formats: &[Format]) -> Vec<Format> {
        let dress = |&format: &Format| if let Format::Color(_) = format { Format::Color(self.look()) } else { format };
        formats.iter().map(dress).collect()
    }
}
