//! `--gt-scale`, `--gt-mask` and so on: what a truth is, and the picture of the errors.

use super::headings::TRUTH;
use super::numbers::Positive;
use anyhow::{Result, bail};
use gpu_stereo::files::maps::Encoding;
use gpu_stereo::files::truth::TruthFile;
use std::path::{Path, PathBuf};

/// What a truth is, and the picture of the errors.
#[derive(Debug, clap::Args)]
pub struct TruthArgs {
    /// The truth's value that stands for 1 px [default: 256 in 16-bit PNG, 1 in floats]
    #[arg(long, value_name = "S", allow_negative_numbers = true, help_heading = TRUTH)]
    pub gt_scale: Option<Positive>,

    /// A value of the truth that means unknown, besides those that usually do: what is not finite in floats, 0 in whole numbers;
    /// such as 0 or -1
    #[arg(long, value_name = "V", allow_negative_numbers = true, help_heading = TRUTH)]
    pub gt_invalid: Option<f64>,

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

impl TruthArgs {
    /// The truth at `path`.
    pub fn file(&self, path: &Path, optics: Option<[f64; 2]>) -> Result<TruthFile> {
        let depth = match (self.gt_depth, optics) {
            (true, Some([focal, baseline])) => Some(focal * baseline),
            (true, None) => bail!(
                "--gt-depth needs --focal PX and --baseline M, which turn depths into disparities; Virtual KITTI 2 has 725.0087 and \
                 0.532725"
            ),
            (false, _) => None,
        };
        let encoding = Encoding { scale: self.gt_scale.map(|scale| scale.0), depth, invalid: self.gt_invalid };
        Ok(TruthFile { path: path.into(), mask: self.gt_mask.clone(), encoding })
    }

    /// Refuses these options where there is no truth.
    pub fn ensure_unused(&self) -> Result<()> {
        let given = [
            (self.gt_scale.is_some(), "gt-scale"),
            (self.gt_invalid.is_some(), "gt-invalid"),
            (self.gt_mask.is_some(), "gt-mask"),
            (self.gt_depth, "gt-depth"),
            (self.error_map.is_some(), "error-map"),
        ];
        match given.iter().find(|(given, _)| *given) {
            Some((_, name)) => bail!("--{name} needs a truth; add --gt FILE"),
            None => Ok(()),
        }
    }
}
