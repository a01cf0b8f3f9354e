//! The command line of `video`.

use super::bulk::BulkArgs;
use super::cameras::CameraArgs;
use super::device::DeviceArgs;
use super::formats::{FormatArgs, LookArgs};
use super::headings::{DEVICE, OUTPUT};
use super::input::{InputArgs, MaskArgs};
use super::numbers::Whole;
use super::settings::Settings;
use super::weights::NetworkArgs;
use gpu_stereo::files::frames::RawFrames;
use std::path::PathBuf;

/// The usage.
pub const USAGE: &str = "\
gpu-stereo video <LEFT> <RIGHT> -o <OUT> --disp <N> [OPTIONS]
       gpu-stereo video <BOTH> --split <HOW> -o <OUT> --disp <N> [OPTIONS]";

/// The end of `--help`.
pub const HELP: &str = "\
LEFT and RIGHT are each
  a folder: its images in natural order (frame2 before frame10);
  a printf pattern such as img_%06d.png: from the first number that exists to the first that does not;
  a glob such as 'left/*.png', in quotes, in natural order; or
  a video, decoded by the ffmpeg on the PATH.
A record of ROS 2 (.mcap) alone has two topics, --left and --right. One of the others alone has both views in each frame: say by --split where. - alone is stdin: Y4M, PAM, or --raw-frames.
All pairs have one size, and with --disp auto the range that the first frames need. What fails is reported, the rest goes on, and the exit code is 1.
Without --resume, existing files are replaced, as by a single run.

Examples:
  gpu-stereo video left right -o maps --disp 64
      maps/NAME.png for every left/NAME.png, 16 bits as in the KITTI benchmark
  gpu-stereo video image_2/%06d_10.png image_3/%06d_10.png -o maps --disp 128 --format npy,color --resume
      maps/000000_10.npy and maps/000000_10_color.png and so on, except those that exist
  gpu-stereo video 'cam0/*.jpg' 'cam1/*.jpg' -o depth_%04d.pfm --disp 96
      depth_0000.pfm, depth_0001.pfm and so on
  gpu-stereo video left right -o both.mp4 --fps 25 --disp 64
      the left image beside the colour map, by the ffmpeg on the PATH
  gpu-stereo video left.mp4 right.mp4 -o maps/%06d.pfm --disp 64
      a map of every pair of frames of two videos
  ffmpeg -f v4l2 -i /dev/video0 -f yuv4mpegpipe -pix_fmt yuv420p - | gpu-stereo video - --split sbs -o maps --disp 64
      a camera that shows both views side by side, until Ctrl-C
  gpu-stereo video drive.mcap --left /stereo/left/image_rect --right /stereo/right/image_rect -o maps.mcap --disp 128
      DisparityImage, depths and PointCloud2 of every pair of a ROS 2 record

Exit codes: 0 done, 1 a frame failed, 2 could not run.";

/// The command line of `video`.
#[derive(Debug, clap::Args)]
pub struct VideoArgs {
    /// The frames of the left and of the right camera; or of both, with --split
    #[arg(required = true, num_args = 1.., value_names = ["LEFT", "RIGHT"])]
    pub sides: Vec<PathBuf>,

    /// The left images' topic in a record, an .mcap file of ROS 2
    #[arg(long, value_name = "TOPIC", help_heading = "Input")]
    pub left: Option<String>,

    /// The right images' topic
    #[arg(long, value_name = "TOPIC", help_heading = "Input")]
    pub right: Option<String>,

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

    /// The frames on stdin are pixels without a header, of this size and in ffmpeg's gray, gray16le, rgb24, bgr24, rgba, bgra,
    /// yuv420p, nv12, yuyv422 or uyvy422, such as 1280x480:yuyv422
    #[arg(long, value_name = "WxH:PIXELS", help_heading = "Input")]
    pub raw_frames: Option<RawFrames>,

    /// The cameras
    #[command(flatten)]
    pub cameras: CameraArgs,

    /// Where to compute
    #[command(flatten)]
    pub device: DeviceArgs,

    /// Frames that are uploaded, computed and read back at a time, 1 to 16
    #[arg(long, value_name = "N", default_value = "3", allow_negative_numbers = true, help_heading = DEVICE)]
    pub in_flight: Whole,

    /// A folder, created if missing; a printf pattern such as map_%04d.png; a video: .mp4, .mkv, .webm; or, from a record, .mcap:
    /// disparities, and depths and points where the cameras are known
    #[arg(short, long, value_name = "OUT", required = true, help_heading = OUTPUT)]
    pub output: PathBuf,

    /// What is written
    #[command(flatten)]
    pub formats: FormatArgs,

    /// How maps are drawn
    #[command(flatten)]
    pub look: LookArgs,

    /// Frames a second of the video that is written, above 0, at most 1000 [default: as the video that is read, else 10]
    #[arg(long, value_name = "FPS", allow_negative_numbers = true, help_heading = OUTPUT)]
    pub fps: Option<String>,

    /// How the run resumes, writes and reports
    #[command(flatten)]
    pub bulk: BulkArgs,
}
