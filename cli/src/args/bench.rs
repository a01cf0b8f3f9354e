//! The command line of `bench`.

use super::cameras::CameraArgs;
use super::choices;
use super::device::DeviceArgs;
use super::formats::{LookArgs, MapsArgs};
use super::headings::OUTPUT;
use super::input::InputArgs;
use super::numbers::Whole;
use super::settings::Settings;
use super::weights::NetworkArgs;
use gpu_stereo::files::datasets::DataSet;
use std::path::PathBuf;

/// The end of `--help`.
pub const HELP: &str = "\
The disparities of a scene are the data set's own: ndisp of calib.txt, 192 for KITTI and Virtual
KITTI, max_disp of a manifest, 128 where it has none; --disp N is for all, --disp auto what each scene needs. A variant is as in
compare. A scene that fails is reported, and the others go on.

Examples:
  gpu-stereo bench kitti_2015 --layout kitti2015 --report report
  gpu-stereo bench MiddEval3 --layout middlebury --only trainingQ --variants balanced,dense --submission upload
  gpu-stereo bench data --layout manifest --variants classic balanced \"census+paths=8\" --json

Exit codes: 0 done, 1 a scene failed, 2 could not run.";

/// The command line of `bench`.
#[derive(Debug, clap::Args)]
pub struct BenchArgs {
    /// The data set's folder, or a manifest
    pub dataset: PathBuf,

    /// The layout of its files
    #[arg(long, value_parser = choices::layout())]
    pub layout: DataSet,

    /// What to compute for each scene, with commas or spaces between them [default: the settings given]
    #[arg(long, num_args = 1.., value_delimiter = ',', value_name = "VARIANT")]
    pub variants: Vec<String>,

    /// Only scenes that have this in SET/NAME; may be given several times
    #[arg(long, value_name = "TEXT")]
    pub only: Vec<String>,

    /// What all variants have in common
    #[command(flatten)]
    pub settings: Settings,

    /// The network of --method psmnet
    #[command(flatten)]
    pub network: NetworkArgs,

    /// How the images are read
    #[command(flatten)]
    pub input: InputArgs,

    /// The cameras
    #[command(flatten)]
    pub cameras: CameraArgs,

    /// Where to compute
    #[command(flatten)]
    pub device: DeviceArgs,

    /// Run N frames for each map after one warm-up [default: 1 on an adapter; on the CPU one, without warm-up]
    #[arg(long, value_name = "N", allow_negative_numbers = true, help_heading = OUTPUT)]
    pub repeat: Option<Whole>,

    /// Write report.md, its pictures and results.json into this folder
    #[arg(long, value_name = "FOLDER", help_heading = OUTPUT)]
    pub report: Option<PathBuf>,

    /// Where the maps are written, too
    #[command(flatten)]
    pub maps: MapsArgs,

    /// How maps are drawn
    #[command(flatten)]
    pub look: LookArgs,

    /// Write the files that the benchmark takes into this folder: kitti SET/disp_0/*.png (2012: SET/*.png), middlebury
    /// SET/NAME/disp0METHOD.pfm (with holes disp0METHOD_s.pfm) and timeMETHOD.txt, eth3d low_res_two_view/NAME.pfm, .txt
    #[arg(long, value_name = "FOLDER", help_heading = OUTPUT)]
    pub submission: Option<PathBuf>,

    /// Do not wait until each file is on the disk; --resume then reads them before it trusts them
    #[arg(long, help_heading = OUTPUT)]
    pub no_sync: bool,

    /// Keep what an earlier run with the same settings found in the folder of --report, and compute only what is missing
    #[arg(long, help_heading = OUTPUT)]
    pub resume: bool,

    /// The method's name in the files to submit
    #[arg(long, value_name = "METHOD", default_value = "gpu-stereo", help_heading = OUTPUT)]
    pub method_name: String,

    /// Print one JSON object instead of the tables
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,

    /// Print no table and no progress
    #[arg(short, long, help_heading = OUTPUT)]
    pub quiet: bool,
}
