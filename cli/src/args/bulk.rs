//! What `batch` and `video` share: the options of verbs that write the maps of many pairs.

use super::headings::OUTPUT;
use std::path::PathBuf;

/// How a run over many pairs resumes, writes and reports.
#[derive(Debug, clap::Args)]
pub struct BulkArgs {
    /// Keep the files of an earlier run with the same settings and the same images, and compute only what is missing
    #[arg(long, help_heading = OUTPUT)]
    pub resume: bool,

    /// With --resume: try again the pairs that ended the processes that computed them
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
