//! Parse: the command line as it was typed, with no meaning given to it yet.

use crate::calibration::{LensModel, Pair, Scale, Unit};
use crate::layout::Layout;
use crate::output::Format;
use clap::builder::{PossibleValue, StringValueParser, TypedValueParser};
use clap::{Arg, ArgMatches, Command, FromArgMatches, Parser, Subcommand, ValueEnum};
use gpu_stereo::{Params, Preset};
use std::ffi::OsStr;
use std::path::PathBuf;
use std::process::ExitCode;
use std::str::FromStr;

const USAGE: &str = "\
gpu-stereo <LEFT> <RIGHT> --disp <N> [OPTIONS]
       gpu-stereo sweep|compare <LEFT> <RIGHT> --disp <N> [OPTIONS]
       gpu-stereo video <LEFT> <RIGHT> -o <OUT> --disp <N> [OPTIONS]
       gpu-stereo batch <LIST>|<LEFT> <RIGHT> -o <DIR> --disp <N> [OPTIONS]
       gpu-stereo eval <ESTIMATE> <TRUTH> [OPTIONS]
       gpu-stereo bench <DATASET> --layout <LAYOUT> [OPTIONS]
       gpu-stereo --list-adapters";

const PRESET: &str = "preset";
const OUTPUT: &str = "Output";
const DEVICE: &str = "Device";
const TRUTH: &str = "Truth";

const EXAMPLES: &str = "\
Examples:
  gpu-stereo left.png right.png --disp 64
      writes disparity.png (16 bit, 256 a pixel, 0 invalid) and disparity_color.png
  gpu-stereo left.png right.png --disp 128 --paths 8 --uniqueness 15 -o out.pfm -o out.npy
      writes the same map in two formats
  gpu-stereo left.png right.png --disp 64 --check
      compares every stage on the adapter with the CPU reference, bit for bit
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
  gpu-stereo --list-adapters

Exit codes: 0 done, 1 a check found a mismatch or a frame or pair failed, 2 could not run.
Vulkan, Metal and Direct3D 12 are searched for adapters; WGPU_BACKEND=gl in the environment searches OpenGL.";

/// Dense disparity of a stereo pair, on any GPU.
///
/// LEFT and RIGHT are rectified images of one size (else see --rectify), 8 or 16 bits, gray or colour (an alpha channel is ignored): PNG,
/// JPEG, PNM, TIFF, BMP, WebP and others. A disparity d at (x, y) says that LEFT(x, y) shows what RIGHT(x - d, y) shows.
#[derive(Debug, Parser)]
#[command(name = "gpu-stereo", version, override_usage = USAGE, after_help = EXAMPLES, max_term_width = 100)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true, disable_help_subcommand = true)]
pub struct Args {
    /// Something else than a run
    #[command(subcommand)]
    pub verb: Option<Verb>,

    /// The left image
    #[arg(required_unless_present = "list_adapters")]
    pub left: Option<PathBuf>,

    /// The right image
    #[arg(required_unless_present = "list_adapters")]
    pub right: Option<PathBuf>,

    /// The settings by name
    #[command(flatten)]
    pub settings: Settings,

    /// Which pixels count
    #[command(flatten)]
    pub masks: MaskArgs,

    /// How the images are read
    #[command(flatten)]
    pub input: InputArgs,

    /// The cameras, and what is made with them
    #[command(flatten)]
    pub scene: Scene,

    /// The cameras in two numbers
    #[command(flatten)]
    pub optics: Optics,

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

    /// Write a picture of the map (PNG): turbo colours over the searched range, invalid black
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub color: Option<PathBuf>,

    /// Write where the map has a disparity (8-bit PNG): 255 where it has one, 0 where not
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub mask: Option<PathBuf>,

    /// Write how far each winner is ahead of its rivals (8-bit PNG): 1 to 255, 0 where there is no disparity
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub confidence: Option<PathBuf>,

    /// Score the map against this truth: 16-bit PNG of KITTI (256 a pixel), .pfm, .npy, .tif; other gray PNG or PGM with
    /// --gt-scale
    #[arg(long, value_name = "FILE", help_heading = TRUTH)]
    pub gt: Option<PathBuf>,

    /// What the truth is
    #[command(flatten)]
    pub truth: TruthOptions,

    /// Compare every stage with the CPU reference; on a mismatch exit with 1 and write no file
    #[arg(long, help_heading = OUTPUT)]
    pub check: bool,

    /// Print milliseconds a stage, the median over the frames; runs one warm-up first
    #[arg(long, help_heading = OUTPUT)]
    pub timings: bool,

    /// Run N frames on the same pair after one warm-up; without it and --timings the first frame is the only one
    #[arg(long, value_name = "N", allow_negative_numbers = true, help_heading = OUTPUT)]
    pub repeat: Option<Whole>,

    /// Print one JSON object instead of the summary and the tables
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,

    /// Print no summary
    #[arg(short, long, help_heading = OUTPUT)]
    pub quiet: bool,
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

/// The cameras of the pair, and what is made with them.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Depth")]
pub struct Scene {
    /// The calibration of the pair: Middlebury's calib.txt, KITTI's and DrivingStereo's calib files, OpenCV's YAML or XML with
    /// P1 and P2 or Q (of stereoRectify), ROS camera_info YAML (with --calib-right); the content tells which
    #[arg(long, value_name = "FILE", group = "cameras", conflicts_with_all = ["focal", "baseline", "cx", "cy", "doffs"])]
    pub calib: Option<PathBuf>,

    /// Rectify the pair first, with the lenses, rotations and projections of OpenCV's stereoCalibrate and stereoRectify
    /// (M1, D1, R1, P1, M2, D2, R2, P2, or R and T in place of R1 .. P2, in YAML or XML), or of ROS camera_info YAML (with
    /// --calib-right), Kalibr's camchain.yaml or ZED's .conf; this is the calibration of the depth, too
    #[arg(long, value_name = "FILE", group = "cameras", conflicts_with_all = ["focal", "baseline", "cx", "cy", "doffs"])]
    pub rectify: Option<PathBuf>,

    /// The right camera's file, where each camera has one (ROS); or the second file, where the lenses have one of their own
    /// (intrinsics.yml and extrinsics.yml of OpenCV's sample)
    #[arg(long, value_name = "FILE", requires = "cameras")]
    pub calib_right: Option<PathBuf>,

    /// The model of the lenses, where the file does not say and their numbers do not tell: k1, k2, p1, p2 of calibrateCamera,
    /// or k1, k2, k3, k4 of cv::fisheye
    #[arg(long, value_enum, value_name = "MODEL", default_value_t = LensModel::Auto, requires = "rectify")]
    pub lens: LensModel,

    /// The images' size by that of the calibrated ones, such as 0.5 or 2/3; 1: the calibration is right as it is
    #[arg(long, value_name = "S", requires = "cameras", allow_negative_numbers = true)]
    pub calib_scale: Option<Scale>,

    /// The unit of lengths in the calibration [default: mm in Middlebury's and ZED's files, else m]
    #[arg(long, value_enum, value_name = "UNIT", requires = "cameras")]
    pub calib_unit: Option<Unit>,

    /// The cameras of a KITTI calibration that took the pair [default: color, if it has P2]
    #[arg(long, value_enum, value_name = "PAIR", requires = "cameras")]
    pub calib_pair: Option<Pair>,

    /// Column of the left principal point [default: the middle]
    #[arg(long, value_name = "PX", requires = "focal", allow_negative_numbers = true)]
    pub cx: Option<f64>,

    /// Row of the principal points [default: the middle]
    #[arg(long, value_name = "PX", requires = "focal", allow_negative_numbers = true)]
    pub cy: Option<f64>,

    /// Column of the right principal point less that of the left one [default: 0]
    #[arg(long, value_name = "PX", requires = "focal", allow_negative_numbers = true)]
    pub doffs: Option<f64>,

    /// Write the depth: .png (16 bit, millimetres, 0 without a depth and from 65.5355 m on), .pfm (+inf without a depth),
    /// .npy, .tif (metres as 32-bit floats, NaN without a depth); may be given several times
    #[arg(long, value_name = "FILE")]
    pub depth: Vec<PathBuf>,

    /// Write coloured points, those that have a depth: .ply or .pcd, binary; metres to the right, down and forward of the
    /// left camera; may be given several times
    #[arg(long, value_name = "FILE")]
    pub points: Vec<PathBuf>,
}

/// How images are read.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "Input")]
pub struct InputArgs {
    /// Exchange LEFT and RIGHT
    #[arg(long)]
    pub swap: bool,

    /// The bits that samples of 16-bit images have, 8 to 16; auto: 8, 10, 12, 14 or 16, as the largest sample of the pair
    /// (of a video, of its first pair) needs. They are stretched to 16
    #[arg(long, value_name = "N|auto", default_value = "auto", allow_negative_numbers = true)]
    pub bits: Bits,
}

/// `--bits`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Bits {
    /// As the largest sample needs.
    #[default]
    Auto,
    /// So many.
    Given(u32),
    /// As many as the first pair of the sequence has.
    OfFirst(u32),
}

impl FromStr for Bits {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse() {
            _ if text == "auto" => Ok(Self::Auto),
            Ok(bits @ 8..=16) => Ok(Self::Given(bits)),
            _ => Err("8 to 16 or auto is needed, such as 10".into()),
        }
    }
}

/// Where to compute.
#[derive(Clone, Debug, clap::Args)]
pub struct DeviceArgs {
    /// auto: the best GPU, else a CPU adapter, else the CPU reference; gpu: any adapter; cpu: the reference
    #[arg(long, value_enum, default_value_t = Backend::Auto, help_heading = DEVICE)]
    pub backend: Backend,

    /// The adapter to use: its index or a part of its name, as --list-adapters tells them
    #[arg(long, value_name = "NAME-OR-INDEX", help_heading = DEVICE)]
    pub adapter: Option<String>,
}

/// What is not the run of one pair.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Maps for every combination of values on one sheet, with times
    #[command(after_help = SWEEP, max_term_width = 100)]
    Sweep(StudyArgs),
    /// Maps of several variants on one sheet, with times
    #[command(after_help = COMPARE, max_term_width = 100)]
    Compare(Compare),
    /// Score a map against a truth
    #[command(after_help = EVAL, max_term_width = 100)]
    Eval(EvalArgs),
    /// Score every scene of a data set, with a report and files to submit
    #[command(after_help = BENCH, max_term_width = 100)]
    Bench(BenchArgs),
    /// Maps of all frames of a video: two folders, two printf patterns or two globs
    #[command(after_help = VIDEO, max_term_width = 100, override_usage = VIDEO_USAGE)]
    Video(VideoArgs),
    /// Maps of all pairs of a data set, or a share of them: a list, two folders or two globs
    #[command(after_help = BATCH, max_term_width = 100, override_usage = BATCH_USAGE)]
    Batch(BatchArgs),
}

impl Verb {
    /// Where it computes, if it does.
    pub fn device(&self) -> Option<&DeviceArgs> {
        match self {
            Self::Sweep(study) | Self::Compare(Compare { study, .. }) => Some(&study.device),
            Self::Video(video) => Some(&video.device),
            Self::Batch(batch) => Some(&batch.device),
            Self::Bench(bench) => Some(&bench.device),
            Self::Eval(_) => None,
        }
    }
}

const SWEEP: &str = "\
Any setting takes several values, with commas between them. Two such options make rows and columns.

Example:
  gpu-stereo sweep left.png right.png --block 5,9,15,21 --disp 41,61,81 --method bm -o sweep.png";

const COMPARE: &str = "\
A variant is a preset, a method, a cost, an option that can be on, or OPTION=VALUE.
Several are joined by +, and override what all have in common.

Examples:
  gpu-stereo compare left.png right.png --disp 64 --variants sad,ssd,census
  gpu-stereo compare left.png right.png --disp 64 --variants bm+block=21 census+paths=8 dense";

const BENCH: &str = "\
The disparities of a scene are the data set's own: ndisp of calib.txt, 192 for KITTI and Virtual
KITTI, max_disp of a manifest, 128 where nothing tells; --disp N is for all. A variant is as in
compare. A scene that fails is told, and the others go on.

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

    /// How its files lie
    #[arg(long, value_enum)]
    pub layout: Layout,

    /// What to compute for each scene, with commas or spaces between them [default: the settings given]
    #[arg(long, num_args = 1.., value_delimiter = ',', value_name = "VARIANT")]
    pub variants: Vec<String>,

    /// Only scenes that have this in SET/NAME; may be given several times
    #[arg(long, value_name = "TEXT")]
    pub only: Vec<String>,

    /// What all variants have in common
    #[command(flatten)]
    pub settings: Settings,

    /// How the images are read
    #[command(flatten)]
    pub input: InputArgs,

    /// Where to compute
    #[command(flatten)]
    pub device: DeviceArgs,

    /// Run N frames for each map after one warm-up [default: 1 on an adapter; on the reference one, without warm-up]
    #[arg(long, value_name = "N", allow_negative_numbers = true, help_heading = OUTPUT)]
    pub repeat: Option<Whole>,

    /// Write report.md, its pictures and results.json into this folder
    #[arg(long, value_name = "FOLDER", help_heading = OUTPUT)]
    pub report: Option<PathBuf>,

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

const VIDEO_USAGE: &str = "gpu-stereo video <LEFT> <RIGHT> -o <OUT> --disp <N> [OPTIONS]";

const VIDEO: &str = "\
LEFT and RIGHT are each
  a folder: its images in natural order (frame2 before frame10);
  a printf pattern such as img_%06d.png: from the first number that exists to the first that does not; or
  a glob such as 'left/*.png', in quotes, in natural order.
All pairs have one size. What fails is told, the rest goes on, and the exit code is 1.
Without --resume, files that are there are replaced, as those of a single run are.

Examples:
  gpu-stereo video left right -o maps --disp 64
      maps/NAME.png for every left/NAME.png, 16 bits as in the KITTI benchmark
  gpu-stereo video image_2/%06d_10.png image_3/%06d_10.png -o maps --disp 128 --format npy,color --resume
      maps/000000_10.npy and maps/000000_10_color.png and so on, but not those that are there
  gpu-stereo video 'cam0/*.jpg' 'cam1/*.jpg' -o depth_%04d.pfm --disp 96
      depth_0000.pfm, depth_0001.pfm and so on
  gpu-stereo video left right -o both.mp4 --fps 25 --disp 64
      the left image beside the colour map, by the ffmpeg on the PATH

Exit codes: 0 done, 1 a frame failed, 2 could not run.";

/// The command line of `video`.
#[derive(Debug, clap::Args)]
pub struct VideoArgs {
    /// The frames of the left and of the right camera
    #[arg(required = true, num_args = 1.., value_names = ["LEFT", "RIGHT"])]
    pub sides: Vec<PathBuf>,

    /// The settings by name
    #[command(flatten)]
    pub settings: Settings,

    /// Which pixels count
    #[command(flatten)]
    pub masks: MaskArgs,

    /// How the images are read
    #[command(flatten)]
    pub input: InputArgs,

    /// Where to compute
    #[command(flatten)]
    pub device: DeviceArgs,

    /// Frames that are uploaded, computed and read back at a time, 1 to 16
    #[arg(long, value_name = "N", default_value = "3", allow_negative_numbers = true, help_heading = DEVICE)]
    pub in_flight: Whole,

    /// A folder, made if need be; a printf pattern such as map_%04d.png; or a video: .mp4, .mkv, .webm
    #[arg(short, long, value_name = "OUT", required = true, help_heading = OUTPUT)]
    pub output: PathBuf,

    /// What to write of each frame, with commas between them: png (16 bit as KITTI), pfm, npy, tif, color, mask,
    /// confidence [default: png, or as the pattern ends]
    #[arg(long, value_name = "FORMAT", value_delimiter = ',', hide_possible_values = true, help_heading = OUTPUT)]
    pub format: Vec<Format>,

    /// Frames a second of a video, above 0, at most 1000 [default: 10]
    #[arg(long, value_name = "FPS", allow_negative_numbers = true, help_heading = OUTPUT)]
    pub fps: Option<String>,

    /// Keep the files of an earlier run with the same settings and the same images, and compute only what is missing
    #[arg(long, help_heading = OUTPUT)]
    pub resume: bool,

    /// With --resume: try again what ended the processes that computed it
    #[arg(long, requires = "resume", help_heading = OUTPUT)]
    pub retry: bool,

    /// Do not wait until each file is on the disk; --resume then reads the maps before it trusts them
    #[arg(long, help_heading = OUTPUT)]
    pub no_sync: bool,

    /// Internal: compute the pairs of this journal one by one
    #[arg(long, hide = true, value_name = "FILE")]
    pub suspects: Option<PathBuf>,

    /// Print one JSON object instead of the summary
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,

    /// Print no summary and no progress
    #[arg(short, long, help_heading = OUTPUT)]
    pub quiet: bool,
}

const BATCH_USAGE: &str = "\
gpu-stereo batch <LIST> -o <DIR> --disp <N> [OPTIONS]
       gpu-stereo batch <LEFT> <RIGHT> -o <DIR> --disp <N> [OPTIONS]";

const BATCH: &str = "\
LIST has a pair a line, with paths relative to the list's folder:
  .csv: left,right or left,right,name; a first line with these words says the order; # begins a comment;
  .jsonl or .ndjson: {\"left\": \"l.png\", \"right\": \"r.png\", \"name\": \"scene/1\"}, the name if you like; or
  - for stdin, either of them.
LEFT and RIGHT are folders, printf patterns or globs in quotes, as for gpu-stereo video.

A map is called DIR/NAME.png and so on. Without a name it is that of the left image below the folder that all left
images are in. Pairs may differ in size and samples. What fails is told and added to DIR/failures.jsonl, a list, too; the
rest goes on, and the exit code is 1. Several processes may write into one folder.

Examples:
  gpu-stereo batch pairs.csv -o maps --disp 128
      a map of every pair of a list
  gpu-stereo batch 'data/*/image_2/*.png' 'data/*/image_3/*.png' -o maps --disp 128 --format npy,color -j 4
      maps/SCENE/image_2/FRAME.npy and FRAME_color.png, with 4 threads that read and 4 that write
  gpu-stereo batch pairs.csv -o maps --disp 128 --resume --shard 3/8
      what is missing of the third of eight shares
  parallel -j 2 gpu-stereo batch pairs.csv -o maps --disp 128 -q --shard {}/8 ::: {1..8}
      all shares, two at a time

Exit codes: 0 done, 1 a pair failed, 2 could not run.";

/// The command line of `batch`.
#[derive(Debug, clap::Args)]
pub struct BatchArgs {
    /// A list of pairs, or the images of the left and of the right camera
    #[arg(required = true, num_args = 1.., value_name = "LIST | LEFT RIGHT")]
    pub pairs: Vec<PathBuf>,

    /// The settings by name
    #[command(flatten)]
    pub settings: Settings,

    /// Which pixels count
    #[command(flatten)]
    pub masks: MaskArgs,

    /// How the images are read
    #[command(flatten)]
    pub input: InputArgs,

    /// Where to compute
    #[command(flatten)]
    pub device: DeviceArgs,

    /// Pairs that are uploaded, computed and read back at a time, 1 to 16
    #[arg(long, value_name = "N", default_value = "3", allow_negative_numbers = true, help_heading = DEVICE)]
    pub in_flight: Whole,

    /// Threads that read images, and as many that write maps, 1 to 64 [default: half of the cores, at most 8]
    #[arg(short = 'j', long, value_name = "N", allow_negative_numbers = true, help_heading = DEVICE)]
    pub threads: Option<Whole>,

    /// Only the pairs I, I + N, I + 2 N and so on of all, with I from 1 to N
    #[arg(long, value_name = "I/N", help_heading = DEVICE)]
    pub shard: Option<Shard>,

    /// A folder, made if need be
    #[arg(short, long, visible_alias = "out", value_name = "DIR", required = true, help_heading = OUTPUT)]
    pub output: PathBuf,

    /// What to write of each pair, with commas between them: png (16 bit as KITTI), pfm, npy, tif, color, mask,
    /// confidence [default: png]
    #[arg(long, value_name = "FORMAT", value_delimiter = ',', hide_possible_values = true, help_heading = OUTPUT)]
    pub format: Vec<Format>,

    /// Keep the files of an earlier run with the same settings and the same images, and compute only what is missing
    #[arg(long, help_heading = OUTPUT)]
    pub resume: bool,

    /// With --resume: try again what ended the processes that computed it
    #[arg(long, requires = "resume", help_heading = OUTPUT)]
    pub retry: bool,

    /// Do not wait until each file is on the disk; --resume then reads the maps before it trusts them
    #[arg(long, help_heading = OUTPUT)]
    pub no_sync: bool,

    /// Internal: compute the pairs of this journal one by one
    #[arg(long, hide = true, value_name = "FILE")]
    pub suspects: Option<PathBuf>,

    /// Print one JSON object instead of the summary
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,

    /// Print no summary and no progress
    #[arg(short, long, help_heading = OUTPUT)]
    pub quiet: bool,
}

/// A share of the pairs: `index` of `count`, from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which.
    pub index: usize,
    /// Of how many.
    pub count: usize,
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |digits: &str| digits.bytes().all(|b| b.is_ascii_digit()).then(|| digits.parse().ok()).flatten();
        match text.split_once('/').map(|(index, count)| (number(index), number(count))) {
            Some((Some(index), Some(count))) if (1..=count).contains(&index) => Ok(Self { index, count }),
            _ => Err("I/N is needed with I from 1 to N, such as 3/8; a number that counts from 0 needs 1 more".into()),
        }
    }
}

const EVAL: &str = "\
Maps are 16-bit PNG of KITTI (256 a pixel, 0 none), PFM, NumPy or TIFF (what is not finite is none),
or other gray PNG or PGM with a scale. docs/EVALUATION.md defines what is told.

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

    /// What the truth is
    #[command(flatten)]
    pub options: TruthOptions,

    /// What makes a disparity of a depth
    #[command(flatten)]
    pub optics: Optics,

    /// Print one JSON object instead of the table
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,
}

/// What makes a depth of a disparity, and a disparity of a depth.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Depth")]
pub struct Optics {
    /// Focal length in pixels, in place of a calibration
    #[arg(long, value_name = "PX", allow_negative_numbers = true)]
    pub focal: Option<f64>,

    /// Distance between the cameras in metres
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub baseline: Option<f64>,
}

impl Optics {
    /// Both, or nothing.
    pub fn both(&self) -> anyhow::Result<Option<[f64; 2]>> {
        for (name, value) in [("focal", self.focal), ("baseline", self.baseline)] {
            if let Some(value) = value.filter(|&value| !(value > 0.0 && value.is_finite())) {
                anyhow::bail!("--{name} is {value}, but must be a number above 0; give what the calibration says");
            }
        }
        match (self.focal, self.baseline) {
            (Some(focal), Some(baseline)) => Ok(Some([focal, baseline])),
            (None, None) => Ok(None),
            _ => anyhow::bail!("--focal PX and --baseline M are one without the other; give both"),
        }
    }
}

/// What a truth is, and the picture of the errors.
#[derive(Debug, clap::Args)]
pub struct TruthOptions {
    /// The truth's value that stands for 1 px [default: 256 in 16-bit PNG, 1 in floats]
    #[arg(long, value_name = "S", allow_negative_numbers = true, help_heading = TRUTH)]
    pub gt_scale: Option<Positive>,

    /// Score only where this 8-bit image is 255
    #[arg(long, value_name = "FILE", help_heading = TRUTH)]
    pub gt_mask: Option<PathBuf>,

    /// The truth is depth, a 16-bit PNG in cm with 65535 for far as in Virtual KITTI 2; needs --focal and --baseline
    #[arg(long, help_heading = TRUTH)]
    pub gt_depth: bool,

    /// Write a picture of the errors (PNG) in KITTI's colours, blue to 3 px or 5 %, red beyond
    #[arg(long, value_name = "FILE", help_heading = TRUTH)]
    pub error_map: Option<PathBuf>,
}

/// The command line of a study.
#[derive(Debug, clap::Args)]
pub struct StudyArgs {
    /// The left image
    pub left: PathBuf,

    /// The right image
    pub right: PathBuf,

    /// The settings by name
    #[command(flatten)]
    pub settings: Settings,

    /// Which pixels count
    #[command(flatten)]
    pub masks: MaskArgs,

    /// How the images are read
    #[command(flatten)]
    pub input: InputArgs,

    /// Where to compute
    #[command(flatten)]
    pub device: DeviceArgs,

    /// Write the sheet, .png or .jpg [default: sweep.png, compare.png]
    #[arg(short, long, value_name = "FILE", help_heading = OUTPUT)]
    pub output: Option<PathBuf>,

    /// Width of a map on the sheet, 16 to 4096 [default: as the sheet can be read]
    #[arg(long, value_name = "PX", allow_negative_numbers = true, help_heading = OUTPUT)]
    pub tile_width: Option<Whole>,

    /// Run N frames for each map after one warm-up [default: 5 on an adapter; on the reference one, without warm-up]
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
pub struct Compare {
    /// What to compare, with commas or spaces between them
    #[arg(long, required = true, num_args = 1.., value_delimiter = ',', value_name = "VARIANT")]
    pub variants: Vec<String>,

    /// What all have in common
    #[command(flatten)]
    pub study: StudyArgs,
}

/// The command line, or the exit code with which to stop.
pub fn parse() -> Result<Args, ExitCode> {
    Args::try_parse().map_err(|error| {
        if error.use_stderr() {
            let args: Vec<_> = std::env::args_os().skip(1).collect();
            crate::tell(&crate::tips::error_line(error, &args));
            ExitCode::from(2)
        } else {
            let _ = error.print(); // help or version, perhaps into a pipe that is closed
            ExitCode::SUCCESS
        }
    })
}

/// The options of [`Params::OPTIONS`] and `preset` that were given, as they were typed.
#[derive(Clone, Debug)]
pub struct Settings(Vec<(&'static str, String)>);

impl Settings {
    /// Name and value of each.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &str)> {
        self.0.iter().map(|(name, value)| (*name, value.as_str()))
    }
}

impl FromArgMatches for Settings {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let names = Params::OPTIONS.iter().map(|option| option.name).chain([PRESET]);
        let given = names.filter_map(|name| Some((name, matches.get_one::<String>(name)?.clone())));
        let mut given: Vec<_> = given.collect();
        given.sort_by_key(|(name, _)| matches.index_of(name)); // as they were typed
        Ok(Self(given))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl clap::Args for Settings {
    fn augment_args(command: Command) -> Command {
        let preset = Arg::new(PRESET)
            .long(PRESET)
            .value_name("PRESET")
            .value_parser(Words(Preset::NAMES))
            .help(format!("Settings to start from; other options override them [default: {}]", Preset::default()));
        // Both are known to be good.
        let defaults = ["sgm", "bm"].map(|method| Params::from_options(64, [("method", method)]).ok());
        let described = Params::OPTIONS.iter().map(|option| {
            let [sgm, bm] = defaults.each_ref().map(|params| params.as_ref().map(|params| option.get(params)));
            let default = match (option.name, sgm, bm) {
                ("disp", ..) => String::new(),
                (name, Some(sgm), Some(bm)) if sgm != bm && name != "method" => {
                    format!(" [default: sgm {sgm}, bm {bm}]")
                }
                (_, sgm, _) => format!(" [default: {}]", sgm.unwrap_or_default()),
            };
            Arg::new(option.name)
                .long(option.name)
                .help_heading(option.heading)
                .help(format!("{}{default}", option.help))
                .value_name(option.placeholder)
                .hide_possible_values(option.placeholder.contains('|'))
                .value_parser(Words(option.values))
                .allow_negative_numbers(true)
        });
        described.fold(command.arg(preset), Command::arg)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

/// Takes any text, since the library judges it, and tells the words that are allowed to the help.
#[derive(Clone, Copy)]
struct Words(&'static [(&'static str, &'static str)]);

impl TypedValueParser for Words {
    type Value = String;

    fn parse_ref(&self, command: &Command, argument: Option<&Arg>, value: &OsStr) -> Result<String, clap::Error> {
        StringValueParser::new().parse_ref(command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let words = self.0.iter().map(|(word, help)| PossibleValue::new(*word).help(*help));
        (!self.0.is_empty()).then(|| Box::new(words) as Box<_>)
    }
}

/// A whole number, and the text that stood for it. A number too large for an `i64` is the largest one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Whole {
    /// As it was typed.
    pub text: String,
    /// What it means.
    pub value: i64,
}

impl FromStr for Whole {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (negative, digits) = match text.strip_prefix('-') {
            Some(digits) => (true, digits),
            None => (false, text.strip_prefix('+').unwrap_or(text)),
        };
        if digits.is_empty() || !digits.bytes().all(|b| b.is_ascii_digit()) {
            return Err("a whole number is needed, such as 64".into());
        }
        let beyond = if negative { i64::MIN } else { i64::MAX };
        Ok(Self { text: text.into(), value: text.parse().unwrap_or(beyond) })
    }
}

/// A number above 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Positive(pub f64);

impl FromStr for Positive {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = text.parse().ok().filter(|number: &f64| *number > 0.0 && number.is_finite());
        number.map(Self).ok_or_else(|| "a number above 0 is needed, such as 16".into())
    }
}

/// `--backend`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    /// The best that there is
    Auto,
    /// Any adapter, a CPU adapter such as lavapipe included
    Gpu,
    /// The reference in plain Rust
    Cpu,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory as _;

    #[test]
    fn the_command_is_well_formed() {
        Args::command().debug_assert();
    }

    #[test]
    fn shards_count_from_1() {
        assert_eq!("3/8".parse(), Ok(Shard { index: 3, count: 8 }));
        assert_eq!("01/1".parse(), Ok(Shard { index: 1, count: 1 }));
        for text in ["0/8", "9/8", "1/0", "/8", "1/", "1", "+1/8", "1/8/2", "-1/8", "1/99999999999999999999", " 1/8"] {
            assert!(text.parse::<Shard>().is_err(), "{text:?}");
        }
    }

    #[test]
    fn whole_numbers_saturate_and_nothing_else_passes() {
        let value = |text: &str| text.parse::<Whole>().map(|whole| whole.value);
        assert_eq!(value("64"), Ok(64));
        assert_eq!(value("-5"), Ok(-5));
        assert_eq!(value("99999999999999999999999"), Ok(i64::MAX));
        assert_eq!(value("-99999999999999999999999"), Ok(i64::MIN));
        for text in ["", "-", "+", "nan", "1.5", "0x10", "1e3", " 1", "٣", "--1"] {
            assert!(value(text).is_err(), "{text:?}");
        }
    }
}
