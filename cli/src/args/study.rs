//! The command lines of `sweep` and `compare`.

use super::cameras::CameraArgs;
use super::device::DeviceArgs;
use super::formats::{LookArgs, MapsArgs};
use super::headings::OUTPUT;
use super::input::{InputArgs, MaskArgs};
use super::numbers::Whole;
use super::settings::Settings;
use super::weights::NetworkArgs;
use std::path::PathBuf;

/// The end of `--help`.
pub const SWEEP_HELP: &str = "\
Any setting takes several values, with commas between them. Two such options make rows and columns.

Example:
  gpu-stereo sweep left.png right.png --block 5,9,15,21 --disp 41,61,81 --method bm -o sweep.png";

/// The end of `--help`.
pub const COMPARE_HELP: &str = "\
A variant is a preset, a method, a cost, an option that can be on, or OPTION=VALUE.
Several are joined by +, and override what all have in common.

Examples:
  gpu-stereo compare left.png right.png --disp 64 --variants sad,ssd,census
  gpu-stereo compare left.png right.png --disp 64 --variants bm+block=21 census+paths=8 dense";

/// The command line of a study.
#[derive(Debug, clap::Args)]
pub struct StudyArgs {
    /// The left image, or one file that holds both views
    pub left: PathBuf,

    /// The right image
    pub right: Option<PathBuf>,

    /// The settings by name
    #[command(flatten)]
    pub settings: Settings,

    /// The network of --method psmnet
    #[command(flatten)]
    pub network: NetworkArgs,

    /// Which pixels count
    #[command(flatten)]
    pub masks: MaskArgs,

    /// How the images are read
    #[command(flatten)]
    pub input: InputArgs,

    /// The cameras
    #[command(flatten)]
    pub cameras: CameraArgs,

    /// Where to compute
    #[command(flatten)]
    pub device: DeviceArgs,

    /// Write the sheet, .png or .jpg [default: sweep.png, compare.png]
    #[arg(short, long, value_name = "FILE", help_heading = OUTPUT)]
    pub output: Option<PathBuf>,

    /// Where the maps are written, too
    #[command(flatten)]
    pub maps: MapsArgs,

    /// How maps are drawn
    #[command(flatten)]
    pub look: LookArgs,

    /// Width of a map on the sheet, 16 to 4096 [default: so that the sheet is legible]
    #[arg(long, value_name = "PX", allow_negative_numbers = true, help_heading = OUTPUT)]
    pub tile_width: Option<Whole>,

    /// Run N frames for each map after one warm-up [default: 5; one, without
    /// warm-up, of what takes long on the CPU: bp, psmnet, --backend reference]
    #[arg(long, value_name = "N", allow_negative_numbers = true, help_heading = OUTPUT)]
    pub repeat: Option<Whole>,

    /// Print one JSON object instead of the table
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,

    /// Print no table and no progress
    #[arg(short, long, help_heading = OUTPUT)]
    pub quiet: bool,
}

/// The command line of `compare`.
#[derive(Debug, clap::Args)]
pub struct CompareArgs {
    /// What to compare, with commas or spaces between them
    #[arg(long, required = true, num_args = 1.., value_delimiter = ',', value_name = "VARIANT")]
    pub variants: Vec<String>,

    /// What all have in common
    #[command(flatten)]
    pub study: StudyArgs,
}
