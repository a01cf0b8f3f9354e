//! `eval`: a map beside the truth.

use super::outcome::Outcome;
use crate::args::EvalArgs;
use crate::engine::output_files;
use crate::terminal::{self, Evaluation, warnings};
use anyhow::{Result, bail};
use gpu_stereo::files::encoders::SheetFormat;
use gpu_stereo::files::maps::{self, Encoding, EncodingOptions, MapFile};
use gpu_stereo::files::outputs;
use gpu_stereo::files::outputs::Output;
use gpu_stereo::files::truth::TruthFile;
use serde::Serialize;
use std::path::PathBuf;

/// Two maps, ready to be compared.
struct Eval {
    estimate: PathBuf,
    encoding: Encoding,
    truth: TruthFile,
    error_map: Option<Output<SheetFormat>>,
    json: bool,
}

/// The scores; `--json` prints them as they are.
#[derive(Serialize)]
struct EvalReport {
    width: u32,
    height: u32,
    evaluation: Evaluation,
    warnings: Vec<String>,
    #[serde(serialize_with = "terminal::paths")]
    outputs: Vec<PathBuf>,
}

/// Scores a map.
pub fn run(args: EvalArgs) -> Result<Outcome> {
    let eval = resolve(args)?;
    let report = eval.run()?;
    match eval.json {
        true => terminal::print_json(&report)?,
        false => terminal::print(&report.evaluation.table())?,
    }
    Ok(Outcome::Done)
}

/// Checks what can be checked without reading the maps.
fn resolve(args: EvalArgs) -> Result<Eval> {
    let EvalArgs { estimate, truth, scale, invalid, options, optics, json } = args;
    let optics = optics.both()?;
    if optics.is_some() && !options.gt_depth {
        bail!("--focal and --baseline turn depths into disparities, but the truth is not a depth; add --gt-depth");
    }
    let truth = options.file(&truth, optics)?;
    let inputs: Vec<_> = truth.files().chain([estimate.as_path()]).collect();
    let error_map =
        options.error_map.as_ref().map(|path| output_files::resolve_error_map(path, &inputs)).transpose()?;
    let encoding = Encoding { scale: scale.map(|scale| scale.0), depth: None, invalid };
    Ok(Eval { encoding, truth, error_map, json, estimate })
}

impl Eval {
    /// Compares the two maps, and writes the picture of the errors.
    fn run(&self) -> Result<EvalReport> {
        let MapFile { map: estimate, doubts, .. } =
            maps::read(&self.estimate, self.encoding, EncodingOptions::ESTIMATE)?;
        let truth = self.truth.read((estimate.width(), estimate.height()), &self.estimate)?;
        doubts.iter().chain(&truth.doubts).for_each(|doubt| warnings::warn(doubt));
        let evaluation = Evaluation::from(&truth.score(&estimate)?);
        if self.error_map.is_some() {
            outputs::write_sheet(self.error_map.as_slice(), &truth.error_picture(&estimate)?)?;
        }
        let outputs = self.error_map.iter().map(|output| output.path.clone()).collect();
        let (width, height) = (estimate.width(), estimate.height());
        Ok(EvalReport { width, height, evaluation, warnings: warnings::all(), outputs })
    }
}
