//! `--calib`, `--rectify`, `--focal` and so on: the cameras of the pair.

use super::headings::OUTPUT;
use super::{choices, numbers};
use gpu_stereo::files::calibration::{KittiPair, LensModel, Reading, Scale, Unit};
use std::path::PathBuf;

/// The cameras of the pair.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Cameras")]
pub struct CameraArgs {
    /// The calibration of the pair: Middlebury's calib.txt, KITTI's and DrivingStereo's calib files, OpenCV's YAML or XML with
    /// P1 and P2 or Q (of stereoRectify), also JSON and .npz, ROS camera_info YAML (with --calib-right), FoundationStereo's K.txt;
    /// recognised by their content
    #[arg(long, value_name = "FILE", group = "cameras", conflicts_with_all = ["focal", "baseline", "cx", "cy", "doffs"])]
    pub calib: Option<PathBuf>,

    /// Rectify the pair first, with the lenses, rotations and projections of OpenCV's stereoCalibrate and stereoRectify
    /// (M1, D1, R1, P1, M2, D2, R2, P2, or R and T in place of R1 .. P2, in YAML, XML, JSON or .npz), or of ROS camera_info YAML
    /// or EuRoC's sensor.yaml (with --calib-right), Kalibr's camchain.yaml, Basalt's calibration.json or ZED's .conf; this is the
    /// calibration of the depth, too. gpu-stereo calib FILE prints what is understood
    #[arg(long, value_name = "FILE", group = "cameras", conflicts_with_all = ["focal", "baseline", "cx", "cy", "doffs"])]
    pub rectify: Option<PathBuf>,

    /// The right camera's file, where each camera has one (ROS, EuRoC); or the second file, where the lenses have one of their own
    /// (intrinsics.yml and extrinsics.yml of OpenCV's sample)
    #[arg(long, value_name = "FILE", requires = "cameras")]
    pub calib_right: Option<PathBuf>,

    /// How the calibration is read, and how it rectifies
    #[command(flatten)]
    pub reading: ReadingArgs,

    /// Match only a part of the images, of the rectified ones with --rectify: the column and the row of its upper left pixel, its
    /// columns and rows. All outputs are of the part. Where the partner lies outside the part, there is no disparity
    #[arg(long, value_name = "X,Y,W,H", value_parser = numbers::part, allow_negative_numbers = true, help_heading = "Input")]
    pub crop: Option<[u32; 4]>,

    /// What is farther away than so many metres has no depth and is no point
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub max_depth: Option<f64>,

    /// The cameras in two numbers
    #[command(flatten)]
    pub optics: Optics,

    /// Column of the left principal point [default: the middle]
    #[arg(long, value_name = "PX", requires = "focal", allow_negative_numbers = true)]
    pub cx: Option<f64>,

    /// Row of the principal points [default: the middle]
    #[arg(long, value_name = "PX", requires = "focal", allow_negative_numbers = true)]
    pub cy: Option<f64>,

    /// Column of the right principal point minus that of the left one [default: 0]
    #[arg(long, value_name = "PX", requires = "focal", allow_negative_numbers = true)]
    pub doffs: Option<f64>,
}

/// How a calibration is read, and how it rectifies.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Cameras")]
pub struct ReadingArgs {
    /// The model of the lenses, where neither the file nor its numbers tell: k1, k2, p1, p2 of calibrateCamera,
    /// or k1, k2, k3, k4 of cv::fisheye
    #[arg(long, value_parser = choices::lens(), value_name = "MODEL", default_value = "auto", requires = "rectify")]
    pub lens: LensModel,

    /// The size of the images divided by that of the calibrated ones, such as 0.5 or 2/3; 1: the calibration fits as it is
    #[arg(long, value_name = "S", requires = "cameras", allow_negative_numbers = true)]
    pub calib_scale: Option<Scale>,

    /// The unit of lengths in the calibration [default: mm in Middlebury's and ZED's files, else m]
    #[arg(long, value_parser = choices::unit(), value_name = "UNIT", requires = "cameras")]
    pub calib_unit: Option<Unit>,

    /// The cameras of a KITTI calibration that took the pair [default: color, if it has P2]
    #[arg(long, value_parser = choices::pair(), value_name = "PAIR", requires = "cameras")]
    pub calib_pair: Option<KittiPair>,

    /// The numbers of the left camera and of the right one, where a calibration has more than two: Kalibr, Basalt (0 is the
    /// first one), KITTI (P0 to P3)
    #[arg(long, value_name = "LEFT,RIGHT", value_parser = numbers::two, requires = "cameras", conflicts_with = "calib_pair")]
    pub calib_cams: Option<[u32; 2]>,

    /// How much the rectified images show, as OpenCV's alpha, from 0 (no pixel without content) to 1 (all of the given images)
    /// [default: the focal length stays; of fisheyes 0]
    #[arg(long, value_name = "A", requires = "rectify", allow_negative_numbers = true)]
    pub alpha: Option<f64>,

    /// Columns and rows of the rectified images [default: those of the given ones]
    #[arg(long, value_name = "WxH", value_parser = numbers::size, requires = "rectify")]
    pub rectified_size: Option<[u32; 2]>,

    /// The cameras lie one above the other: LEFT is of the upper one. The pair is matched turned by 90 degrees; all outputs lie
    /// as the images do, and a disparity d at (x, y) says that LEFT(x, y) shows what RIGHT(x, y - d) shows
    #[arg(long)]
    pub vertical: bool,
}

impl ReadingArgs {
    /// The same for the library. `lenses`: whether the pair is to be rectified.
    pub fn reading(&self, lenses: bool) -> Reading {
        Reading {
            unit: self.calib_unit,
            pair: self.calib_pair,
            cameras: self.calib_cams,
            lens: self.lens,
            scale: self.calib_scale,
            lenses,
            alpha: self.alpha,
            vertical: self.vertical,
            rectified_size: self.rectified_size,
        }
    }
}

/// The command line of `calib`. Its file stands where the options of [`ReadingArgs`] require one.
#[derive(Debug, clap::Args)]
pub struct CalibArgs {
    /// The calibration
    #[arg(id = "rectify", value_name = "FILE", group = "cameras")]
    pub file: PathBuf,

    /// The right camera's file, where each camera has one; or the second file of OpenCV's sample
    pub right: Option<PathBuf>,

    /// How it is read
    #[command(flatten)]
    pub reading: ReadingArgs,

    /// Columns and rows of the images [default: those in the file]
    #[arg(long, value_name = "WxH", value_parser = numbers::size)]
    pub size: Option<[u32; 2]>,

    /// Draw which part of the rectified images each camera sees (.png)
    #[arg(short, long, value_name = "FILE", help_heading = OUTPUT)]
    pub output: Option<PathBuf>,

    /// Print one JSON object instead of the table
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,
}

/// The end of `calib --help`.
pub const HELP: &str = "\
Examples:
  gpu-stereo calib stereo.yml -o fields.png
      what is understood: kind, lenses, baseline, rotation, the rectified cameras; and a picture of both fields of view
  gpu-stereo calib SN1234.conf --size 1280x720 --json
  gpu-stereo calib cam0/sensor.yaml cam1/sensor.yaml --alpha 0

Exit codes: 0 read, 2 could not be read.";

/// What converts disparities to depths and back.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Cameras")]
pub struct Optics {
    /// Focal length in pixels, in place of a calibration
    #[arg(long, value_name = "PX", allow_negative_numbers = true)]
    pub focal: Option<f64>,

    /// Distance between the cameras in metres
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub baseline: Option<f64>,
}

impl Optics {
    /// Both values, or none.
    pub fn both(&self) -> anyhow::Result<Option<[f64; 2]>> {
        for (name, value) in [("focal", self.focal), ("baseline", self.baseline)] {
            if let Some(value) = value.filter(|&value| !(value > 0.0 && value.is_finite())) {
                anyhow::bail!("--{name} is {value}, but must be a number above 0; give what the calibration says");
            }
        }
        match (self.focal, self.baseline) {
            (Some(focal), Some(baseline)) => Ok(Some([focal, baseline])),
            (None, None) => Ok(None),
            _ => anyhow::bail!("only one of --focal PX and --baseline M is given; give both"),
        }
    }
}
