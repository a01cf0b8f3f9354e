//! Parse: the command line as it was typed, with no meaning given to it yet.

use clap::{Parser, ValueEnum};
use std::path::PathBuf;
use std::process::ExitCode;
use std::str::FromStr;

const USAGE: &str = "gpu-stereo <LEFT> <RIGHT> --disp <N> [OPTIONS]\n       gpu-stereo --list-adapters";

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
  gpu-stereo --list-adapters

Exit codes: 0 done, 1 a check found a mismatch, 2 could not run.
Vulkan, Metal and Direct3D 12 are searched for adapters; WGPU_BACKEND=gl in the environment searches OpenGL.";

/// Dense disparity of a rectified stereo pair, on any GPU.
///
/// LEFT and RIGHT are rectified images of one size, 8 or 16 bits, gray or colour (an alpha channel is ignored): PNG,
/// JPEG, PNM, TIFF, BMP, WebP and others. A disparity d at (x, y) says that LEFT(x, y) shows what RIGHT(x - d, y) shows.
#[derive(Debug, Parser)]
#[command(name = "gpu-stereo", version, override_usage = USAGE, after_help = EXAMPLES, max_term_width = 100)]
pub struct Args {
    /// The left image
    #[arg(required_unless_present = "list_adapters")]
    pub left: Option<PathBuf>,

    /// The right image
    #[arg(required_unless_present = "list_adapters")]
    pub right: Option<PathBuf>,

    /// Number of disparities to search, in pixels
    #[arg(long, value_name = "N", required_unless_present = "list_adapters", allow_negative_numbers = true)]
    pub disp: Option<Whole>,

    /// Smallest disparity to search, may be negative [default: 0]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub min_disp: Option<Whole>,

    /// How the disparity is found; each method has its own defaults
    #[arg(long, value_enum, default_value_t = Method::Sgm)]
    pub method: Method,

    /// Directions along which sgm aggregates [default: 4]
    #[arg(long, value_enum, value_name = "3|4|8")]
    pub paths: Option<Paths>,

    /// Side of the square block, odd [default: sgm 5, bm 15]
    #[arg(long, value_name = "B", allow_negative_numbers = true)]
    pub block: Option<Whole>,

    /// The image on which costs are computed [default: xsobel]
    #[arg(long, value_enum)]
    pub prefilter: Option<Prefilter>,

    /// Clip of the prefilter [default: 31]
    #[arg(long, value_name = "C", allow_negative_numbers = true)]
    pub prefilter_cap: Option<Whole>,

    /// sgm: penalty of a disparity step of 1 [default: 16]
    #[arg(long, value_name = "P1", allow_negative_numbers = true)]
    pub p1: Option<Whole>,

    /// sgm: penalty of a larger step, at least P1 [default: 96]
    #[arg(long, value_name = "P2", allow_negative_numbers = true)]
    pub p2: Option<Whole>,

    /// The winner must cost this many per cent less than all others; off is 0 [default: sgm 10, bm 15]
    #[arg(long, value_name = "PCT|off", allow_negative_numbers = true)]
    pub uniqueness: Option<WholeOrOff>,

    /// Largest difference in pixels between the left and the right view [default: 1]
    #[arg(long, value_name = "PX|off", allow_negative_numbers = true)]
    pub lr_check: Option<WholeOrOff>,

    /// Median filter of 3x3 pixels at the end [default: 3]
    #[arg(long, value_enum, value_name = "3|off")]
    pub median: Option<Median>,

    /// Refine to 1/16 pixel [default: on]
    #[arg(long, value_enum, value_name = "on|off")]
    pub subpixel: Option<OnOff>,

    /// Compile the kernels with checks of every index and loop: slower, the same result [default: off]
    #[arg(long, value_enum, value_name = "on|off")]
    pub shader_checks: Option<OnOff>,

    /// How the kernels are laid out; the same result. lines: a path an invocation, for CPU adapters; lanes: a path for
    /// several, for GPUs; auto: as the adapter is
    #[arg(long, value_enum, default_value_t = Schedule::Auto)]
    pub schedule: Schedule,

    /// auto: the best GPU, else a CPU adapter, else the CPU reference; gpu: any adapter; cpu: the reference
    #[arg(long, value_enum, default_value_t = Backend::Auto)]
    pub backend: Backend,

    /// The adapter to use: its index or a part of its name, as --list-adapters tells them
    #[arg(long, value_name = "NAME-OR-INDEX")]
    pub adapter: Option<String>,

    /// List the adapters, best first, and stop
    #[arg(long)]
    pub list_adapters: bool,

    /// Write the map: .png 16 bit (256 a pixel, 0 invalid), .pfm (+inf invalid), .npy, .tif (32-bit float, NaN
    /// invalid); may be given several times [default: disparity.png, disparity_color.png]
    #[arg(short, long, value_name = "FILE")]
    pub output: Vec<PathBuf>,

    /// Write a picture of the map (PNG): turbo colours over the searched range, invalid black
    #[arg(long, value_name = "FILE")]
    pub color: Option<PathBuf>,

    /// Compare every stage with the CPU reference; on a mismatch exit with 1 and write no file
    #[arg(long)]
    pub check: bool,

    /// Print milliseconds a stage, the median over the frames; runs one warm-up first
    #[arg(long)]
    pub timings: bool,

    /// Run N frames on the same pair after one warm-up; without it and --timings the first frame is the only one
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub repeat: Option<Whole>,

    /// Print one JSON object instead of the summary and the tables
    #[arg(long)]
    pub json: bool,

    /// Print no summary
    #[arg(short, long)]
    pub quiet: bool,
}

/// The command line, or the exit code with which to stop.
pub fn parse() -> Result<Args, ExitCode> {
    Args::try_parse().map_err(|error| {
        if error.use_stderr() {
            crate::tell(&one_line_error(&error.render().to_string()));
            ExitCode::from(2)
        } else {
            let _ = error.print(); // help or version, perhaps into a pipe that is closed
            ExitCode::SUCCESS
        }
    })
}

/// Clap's error without its usage, in one line.
fn one_line_error(text: &str) -> String {
    let is_advice = |line: &str| line.starts_with("Usage:") || line.starts_with("For more information");
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let told: Vec<_> = lines.take_while(|line| !is_advice(line)).collect();
    format!("{}; see gpu-stereo --help", told.join(" "))
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

/// A whole number or the word `off`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum WholeOrOff {
    /// The word.
    Off,
    /// The number.
    Whole(Whole),
}

impl FromStr for WholeOrOff {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "off" {
            return Ok(Self::Off);
        }
        text.parse().map(Self::Whole).map_err(|_| "a whole number or off is needed".into())
    }
}

/// `--method`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// Semi-global matching
    Sgm,
    /// Block matching
    Bm,
}

/// `--paths`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Paths {
    /// Horizontal and downwards
    #[value(name = "3")]
    Three,
    /// Horizontal and vertical
    #[value(name = "4")]
    Four,
    /// Diagonal, too
    #[value(name = "8")]
    Eight,
}

/// `--prefilter`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Prefilter {
    /// Horizontal derivative, clipped
    Xsobel,
    /// Gradient magnitude, clipped
    Sobel,
    /// The gray image
    None,
}

/// `--median`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Median {
    /// 3x3 pixels
    #[value(name = "3")]
    Three,
    /// No filter
    Off,
}

/// A switch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum OnOff {
    /// With it
    On,
    /// Without it
    Off,
}

/// `--schedule`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Schedule {
    /// As the adapter is
    Auto,
    /// A path an invocation
    Lines,
    /// A path for neighbouring invocations
    Lanes,
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
