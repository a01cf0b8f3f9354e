//! `video`: the maps of all frames of two cameras.

mod bag;
mod film;
mod numbered;
mod range;
mod resolve;
mod source;
mod task;

use super::outcome::Outcome;
use crate::args::VideoArgs;
use anyhow::Result;

/// Matches all frames.
pub fn run(args: VideoArgs) -> Result<Outcome> {
    let video = resolve::resolve(args)?;
    let (json, quiet) = (video.json, video.quiet);
    let summary = video.run()?;
    summary.print(json, quiet)?;
    Ok(Outcome::failed_if(!summary.failures.is_empty()))
}
