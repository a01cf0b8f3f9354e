//! The command line of `weights`, and `--weights` of the others.

use super::headings::OUTPUT;
use std::path::PathBuf;

/// The end of `--help`.
pub const HELP: &str = "\
FILE is .safetensors or what torch.save writes (.tar, .pth, .pt); its content tells. Nothing in it is executed. docs/NETWORKS.md
says where to get weights, and how each tensor is used.

Examples:
  gpu-stereo weights pretrained_model_KITTI2015.tar
      the architecture, every tensor, and what is wrong with them
  gpu-stereo weights pretrained_model_KITTI2015.tar --convert kitti.safetensors
      the same weights in a file that any program can read safely

Exit codes: 0 weights of a network, 1 they are none, 2 could not run.";

/// The command line of `weights`.
#[derive(Debug, clap::Args)]
pub struct WeightsArgs {
    /// The file of weights
    pub file: PathBuf,

    /// Write them as .safetensors, 32-bit floats, with names without "module." and without counters of batches
    #[arg(long, value_name = "OUT.safetensors", help_heading = OUTPUT)]
    pub convert: Option<PathBuf>,

    /// Print one JSON object instead of the summary and the table
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,
}

/// The network of `--method psmnet`, or of costs by features.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct NetworkArgs {
    /// psmnet: the weights of the network, which --method psmnet needs: .safetensors, or what torch.save writes, such as the
    /// published .tar; docs/NETWORKS.md says where to get them, gpu-stereo weights FILE what is in them. learned, learned-census: another
    /// network of features than that of the library, see docs/LEARNED.md
    #[arg(long, value_name = "FILE", help_heading = "Aggregation")]
    pub weights: Option<PathBuf>,
}
