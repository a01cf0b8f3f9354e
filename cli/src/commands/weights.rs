//! `weights`: what is in a file of weights, and the same as .safetensors.

use super::outcome::Outcome;
use crate::args::WeightsArgs;
use crate::engine::output_files;
use crate::terminal::{self, message, name, table};
use anyhow::{Result, ensure};
use gpu_stereo::Architecture;
use gpu_stereo::files::outputs;
use gpu_stereo::files::weights::{self, Weights};
use gpu_stereo::network::{Tensor, Tensors};
use serde::Serialize;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// What is in a file; `--json` prints it as it is.
#[derive(Serialize)]
struct WeightsReport {
    file: String,
    format: String,
    architecture: Option<String>,
    /// The values that were trained: without the statistics of batch normalisation.
    parameters: usize,
    tensors: Vec<Row>,
    problems: Vec<String>,
    #[serde(serialize_with = "terminal::paths")]
    outputs: Vec<PathBuf>,
}

/// A tensor.
#[derive(Serialize)]
struct Row {
    name: String,
    #[serde(rename = "type")]
    element: String,
    shape: Vec<usize>,
}

/// Prints what is in the file, and converts it.
pub fn run(args: WeightsArgs) -> Result<Outcome> {
    let WeightsArgs { file, convert, json } = args;
    let output = convert.as_deref().map(|path| output_files::resolve_weights(path, &file)).transpose()?;
    let weights = Weights::read(&file)?;
    let architecture = Architecture::of(weights.tensors.keys().map(String::as_str));
    let mut report = report(&file, &weights, architecture);
    match (&output, architecture.filter(|_| report.problems.is_empty())) {
        (Some(output), Some(architecture)) => {
            outputs::write_bytes(output, &weights::encode(&plain(&weights.tensors, architecture)?)?)?;
            report.outputs.push(output.path.clone());
        }
        (Some(_), None) => message("these are not the weights of a network; nothing was converted"),
        (None, _) => {}
    }
    if json {
        terminal::print_json(&report)?;
    } else {
        terminal::print(&report.text()?)?;
    }
    Ok(Outcome::failed_if(!report.problems.is_empty()))
}

fn report(file: &Path, weights: &Weights, architecture: Option<Architecture>) -> WeightsReport {
    let row = |(name, tensor): (&String, &Tensor)| Row {
        name: name.clone(),
        element: weights.elements.get(name).map(ToString::to_string).unwrap_or_default(),
        shape: tensor.shape().to_vec(),
    };
    let trained = |name: &str| {
        let last = name.rsplit('.').next().unwrap_or_default();
        !["running_mean", "running_var", "num_batches_tracked"].contains(&last)
    };
    let trained = weights.tensors.iter().filter(|(name, _)| trained(name));
    let problems = match architecture {
        Some(architecture) => architecture.problems(&weights.tensors).iter().map(ToString::to_string).collect(),
        None => vec!["the names are of no network that is known (PSMNet: stackhourglass, basic)".into()],
    };
    WeightsReport {
        file: file.to_string_lossy().into(),
        format: weights.format.to_string(),
        architecture: architecture.map(|architecture| architecture.to_string()),
        parameters: trained.map(|(_, tensor)| tensor.data().len()).sum(),
        tensors: weights.tensors.iter().map(row).collect(),
        problems,
        outputs: Vec::new(),
    }
}

/// The tensors that the network reads, by the names without `module.`.
fn plain(tensors: &Tensors, architecture: Architecture) -> Result<Tensors> {
    let wanted = architecture.tensors();
    let short = |name: &str| name.strip_prefix("module.").unwrap_or(name).to_owned();
    let plain: Tensors = tensors.iter().map(|(name, tensor)| (short(name), tensor.clone())).collect();
    let plain: Tensors = plain.into_iter().filter(|(name, _)| wanted.contains_key(name)).collect();
    ensure!(plain.len() == wanted.len(), "tensors are missing; give a whole file");
    Ok(plain)
}

impl WeightsReport {
    fn text(&self) -> Result<String> {
        const NONE: &str = "none that is known";
        let mut text = String::new();
        writeln!(text, "file          {}", name(&self.file))?;
        writeln!(text, "format        {}", self.format)?;
        writeln!(text, "architecture  {}", self.architecture.as_ref().map_or(NONE.into(), |a| format!("PSMNet {a}")))?;
        writeln!(text, "parameters    {}", self.parameters)?;
        writeln!(text, "tensors       {}", self.tensors.len())?;
        if let Some(output) = self.outputs.first() {
            writeln!(text, "written       {}", name(output))?;
        }
        let row = |row: &Row| {
            let shape: Vec<_> = row.shape.iter().map(ToString::to_string).collect();
            [row.name.clone(), row.element.clone(), shape.join(" x ")]
        };
        text += &table(["tensor", "type", "shape"], self.tensors.iter().map(row), 2..3);
        for problem in &self.problems {
            writeln!(text, "problem: {}", terminal::plain(problem))?;
        }
        Ok(text)
    }
}
