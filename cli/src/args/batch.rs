//! The command line of `batch`.

use super::bulk::BulkArgs;
use super::cameras::CameraArgs;
use super::device::DeviceArgs;
use super::formats::{FormatArgs, LookArgs};
use super::headings::{DEVICE, OUTPUT};
use super::input::{InputArgs, MaskArgs};
use super::numbers::Whole;
use super::settings::Settings;
use super::weights::NetworkArgs;
use std::path::PathBuf;
use std::str::FromStr;

/// The usage.
pub const USAGE: &str = "\
gpu-stereo batch <LIST> -o <DIR> --disp <N> [OPTIONS]
       gpu-stereo batch <LEFT> <RIGHT> -o <DIR> --disp <N> [OPTIONS]";

/// The end of `--help`.
pub const HELP: &str = "\
LIST has a pair a line, with paths relative to the list's folder:
  .csv: left,right or left,right,name; a first line with these words says the order; # begins a comment;
  .jsonl or .ndjson: {\"left\": \"l.png\", \"right\": \"r.png\", \"name\": \"scene/1\"}, the name is optional; or
  - for stdin, either of them.
LEFT and RIGHT are folders, printf patterns or globs in quotes, as for gpu-stereo video.

A map is called DIR/NAME.png and so on. Without a name it is that of the left image below the folder that all left
images are in. Pairs may differ in size and samples, and with --disp auto in their range. What fails is reported and added
to DIR/failures.jsonl, also a list; the rest goes on, and the exit code is 1. Several processes may write into one folder.

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

    /// Pairs that are uploaded, computed and read back at a time, 1 to 16
    #[arg(long, value_name = "N", default_value = "3", allow_negative_numbers = true, help_heading = DEVICE)]
    pub in_flight: Whole,

    /// Threads that read images, and as many that write maps, 1 to 64 [default: half of the cores, at most 8]
    #[arg(short = 'j', long, value_name = "N", allow_negative_numbers = true, help_heading = DEVICE)]
    pub threads: Option<Whole>,

    /// Only the pairs I, I + N, I + 2 N and so on of all, with I from 1 to N
    #[arg(long, value_name = "I/N", help_heading = DEVICE)]
    pub shard: Option<Shard>,

    /// A folder, created if missing
    #[arg(short, long, visible_alias = "out", value_name = "DIR", required = true, help_heading = OUTPUT)]
    pub output: PathBuf,

    /// What is written
    #[command(flatten)]
    pub formats: FormatArgs,

    /// How maps are drawn
    #[command(flatten)]
    pub look: LookArgs,

    /// How the run resumes, writes and reports
    #[command(flatten)]
    pub bulk: BulkArgs,
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
            _ => Err("I/N is needed with I from 1 to N, such as 3/8; add 1 to a number that counts from 0".into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_count_from_1() {
        assert_eq!("3/8".parse(), Ok(Shard { index: 3, count: 8 }));
        assert_eq!("01/1".parse(), Ok(Shard { index: 1, count: 1 }));
        for text in ["0/8", "9/8", "1/0", "/8", "1/", "1", "+1/8", "1/8/2", "-1/8", "1/99999999999999999999", " 1/8"] {
            assert!(text.parse::<Shard>().is_err(), "{text:?}");
        }
    }
}
