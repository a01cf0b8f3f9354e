//! The command line of a run of one pair.

use super::cameras::CameraArgs;
use super::device::DeviceArgs;
use super::formats::LookArgs;
use super::headings::{DEVICE, OUTPUT, TRUTH};
use super::input::{InputArgs, MaskArgs};
use super::numbers::Whole;
use super::settings::Settings;
use super::truth::TruthArgs;
use super::weights::NetworkArgs;
use std::path::PathBuf;

/// The end of `--help`.
pub const HELP: &str = "\
Examples:
  gpu-stereo left.png right.png --disp 64
      writes disparity.png (16 bit, 256 a pixel, 0 invalid) and disparity_color.png
  gpu-stereo left.png right.png --disp 128 --paths 8 --uniqueness 15 -o out.pfm -o out.npy
      writes the same map in two formats
  gpu-stereo left.png right.png --disp 64 --check
      compares every stage with the CPU reference, bit for bit
  gpu-stereo left.png right.png --disp 64 --timings --repeat 20
      milliseconds a stage, median of 20 frames after one warm-up
  gpu-stereo left.png right.png --disp 64 --calib calib.txt --depth depth.png --points scene.ply
      depth in millimetres, and coloured points
  gpu-stereo raw_left.png raw_right.png --disp 64 --rectify stereo.yml --depth depth.tif
      rectifies the pair first
  gpu-stereo sweep left.png right.png --block 5,9,15,21 --disp 41,61,81 -o sweep.png
      one sheet of colour maps, a row for each block and a column for each range, with times
  gpu-stereo left.png right.png --disp 64 --gt truth.pfm --error-map errors.png
      how far the map is off, and where
  gpu-stereo video left right -o maps --disp 64
      a map of every pair of two folders
  gpu-stereo batch pairs.csv -o maps --disp 64 --resume --shard 2/8
      the second of eight shares of a list
  gpu-stereo left.png right.png --disp 192 --method psmnet --weights psmnet.safetensors
      by a network
  gpu-stereo both.png --split sbs --disp 64
      both views in one picture, side by side
  gpu-stereo --list-adapters

Exit codes: 0 done, 1 a check found a mismatch or a frame or pair failed, 2 could not run.
Vulkan, Metal and Direct3D 12 are searched for adapters; WGPU_BACKEND=gl in the environment searches OpenGL.";

/// A run of one pair.
#[derive(Debug, clap::Args)]
pub struct SingleArgs {
    /// The left image, or one file that holds both views: MPO, JPS, or any image with --split
    #[arg(required_unless_present = "list_adapters")]
    pub left: Option<PathBuf>,

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

    /// List the adapters, best first, and stop
    #[arg(long, help_heading = DEVICE)]
    pub list_adapters: bool,

    /// Write the map: .png 16 bit (256 a pixel, 0 invalid), .pfm (+inf invalid), .npy, .tif (32-bit float, NaN
    /// invalid); may be given several times [default: disparity.png, disparity_color.png]
    #[arg(short, long, value_name = "FILE", help_heading = OUTPUT)]
    pub output: Vec<PathBuf>,

    /// Write a picture of the map (PNG): its colours over the searched range, invalid black
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub color: Option<PathBuf>,

    /// How it is drawn
    #[command(flatten)]
    pub look: LookArgs,

    /// Write where the map has a disparity (8-bit PNG): 255 where it has one, 0 where not
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub mask: Option<PathBuf>,

    /// Write how far each winner is ahead of its rivals (8-bit PNG): 1 to 255, 0 where there is no disparity
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub confidence: Option<PathBuf>,

    /// Write the images as they are matched (PNG), rectified by --rectify; a name with commas is split at the middle one
    #[arg(long, value_name = "LEFT,RIGHT", help_heading = OUTPUT)]
    pub rectified: Option<String>,

    /// Write the right view's map: at a pixel of RIGHT its disparity, in whole pixels, before any filter; the formats of --output;
    /// may be given several times
    #[arg(long = "right", value_name = "FILE", help_heading = OUTPUT)]
    pub right_map: Vec<PathBuf>,

    /// Write the depth: .png (16 bit, millimetres, 0 without a depth and from 65.5355 m on), .pfm (+inf without a depth),
    /// .npy, .tif (metres as 32-bit floats, NaN without a depth); may be given several times
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub depth: Vec<PathBuf>,

    /// Write coloured points, those that have a depth: .ply or .pcd, binary; metres to the right, down and forward of the
    /// left camera; may be given several times
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub points: Vec<PathBuf>,

    /// Score the map against this truth: 16-bit PNG of KITTI (256 a pixel), .pfm, .npy, .tif; other gray PNG or PGM with
    /// --gt-scale
    #[arg(long, value_name = "FILE", help_heading = TRUTH)]
    pub gt: Option<PathBuf>,

    /// What the truth is
    #[command(flatten)]
    pub truth: TruthArgs,

    /// Compare every stage with the CPU reference; on a mismatch exit with 1 and write no file
    #[arg(long, help_heading = OUTPUT)]
    pub check: bool,

    /// Print milliseconds a stage, the median over the frames, and the energy of the winners: data, smoothness and sum, of
    /// any method but psmnet, which has no costs; runs one warm-up first
    #[arg(long, help_heading = OUTPUT)]
    pub timings: bool,

    /// Run N frames on the same pair after one warm-up; without it and --timings the first frame is the only one
    #[arg(long, value_name = "N", allow_negative_numbers = true, help_heading = OUTPUT)]
    pub repeat: Option<Whole>,

    /// Write the WGSL of every kernel that the run compiles, NAME.wgsl each, into a new or empty folder
    #[arg(long, value_name = "DIR", help_heading = OUTPUT)]
    pub dump_shaders: Option<PathBuf>,

    /// Print one JSON object instead of the summary and the tables, with the energy, too
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,

    /// Print no summary
    #[arg(short, long, help_heading = OUTPUT)]
    pub quiet: bool,
}
