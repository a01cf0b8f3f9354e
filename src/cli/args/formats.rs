//! `--format` and `--maps`: the files of each map, for verbs that write many.

use super::choices;
use super::headings::OUTPUT;
use anyhow::{Result, ensure};
use gpu_stereo::files::encoders::Format;
use std::path::PathBuf;

/// What is written of each pair.
#[derive(Clone, Debug, clap::Args)]
pub struct FormatArgs {
    /// What to write of each pair, with commas between them. The map: png (16 bit as KITTI), pfm, npy, tif. Pictures: color,
    /// mask, confidence. right: the right view's map. With cameras depth (PNG in millimetres) and points (PLY). Endings follow
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
