//! `bench`: every scene of a data set with every variant: scores, a report with pictures, files to submit.

mod files;
mod log;
mod report;
mod resolve;
mod run;
mod scene;
mod submission;
mod tables;

use super::outcome::Outcome;
use crate::args::BenchArgs;
use crate::terminal;
use anyhow::Result;
use tables::{scene_table, set_table};

/// Scores a data set.
pub fn run(args: BenchArgs) -> Result<Outcome> {
    let bench = resolve::resolve(args)?;
    let found = run::run(&bench)?;
    if let Some(folder) = &bench.report {
        report::write_report(folder, &found)?;
    }
    if bench.json {
        terminal::print_json(&found)?;
    } else if !bench.quiet {
        let tables = [scene_table(&found.scenes), set_table(&found.sets)];
        let tables: Vec<_> = tables.into_iter().filter(|table| !table.is_empty()).collect();
        terminal::print(&tables.join("\n"))?;
    }
    Ok(Outcome::failed_if(!found.failures.is_empty()))
}
