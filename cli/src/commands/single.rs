//! A run of one pair: resolve -> run -> report.

mod report;
mod resolve;
mod run;
mod shaders;

use super::outcome::Outcome;
use crate::args::SingleArgs;
use anyhow::Result;

/// Matches one pair.
pub fn run(args: SingleArgs) -> Result<Outcome> {
    let job = resolve::resolve(args)?;
    let report = run::run(&job)?;
    report.print(&job).map_err(|error| match report.outputs.is_empty() {
        true => error,
        false => error.context("the files were written, but not the report"),
    })?;
    Ok(Outcome::failed_if(!report.check_passed()))
}
