//! The command line of `eval`.

use super::cameras::Optics;
use super::headings::OUTPUT;
use super::numbers::Positive;
use super::truth::TruthArgs;
use std::path::PathBuf;

/// The end of `--help`.
pub const HELP: &str = "\
Maps are 16-bit PNG of KITTI (256 a pixel, 0 none), PFM, NumPy or TIFF (what is not finite is none),
or other gray PNG or PGM with a scale. docs/EVALUATION.md defines the figures.

Examples:
  gpu-stereo eval disparity.png disp_occ_0/000000_10.png --error-map errors.png
  gpu-stereo eval disparity.pfm disp0GT.pfm --gt-mask mask0nocc.png --json
  gpu-stereo eval disparity.png disp2.png --gt-scale 4
  gpu-stereo eval disparity.png depth_00000.png --gt-depth --focal 725.0087 --baseline 0.532725";

/// The command line of `eval`.
#[derive(Debug, clap::Args)]
pub struct EvalArgs {
    /// The map to score
    pub estimate: PathBuf,

    /// The true disparities
    pub truth: PathBuf,

    /// The estimate's value that stands for 1 px [default: 256 in 16-bit PNG, 1 in floats]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub scale: Option<Positive>,

    /// A value of the estimate that means that there is no disparity, as --gt-invalid
    #[arg(long, value_name = "V", allow_negative_numbers = true)]
    pub invalid: Option<f64>,

    /// What the truth is
    #[command(flatten)]
    pub options: TruthArgs,

    /// What makes a disparity of a depth
    #[command(flatten)]
    pub optics: Optics,

    /// Print one JSON object instead of the table
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,
}
