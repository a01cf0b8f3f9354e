//! Report: the summary, the tables and the JSON on stdout.

use super::resolve::Job;
use crate::commands::energy::EnergyReport;
use crate::commands::summary;
use crate::engine::compute::{EngineNames, FrameMs};
use crate::terminal::{self, Evaluation, message, name, rounded, table};
use anyhow::Result;
use gpu_stereo::{Camera, StageCheck, StageTime};
use serde::{Serialize, Serializer};
use std::fmt::Write as _;
use std::path::PathBuf;

/// The results of a run; `--json` prints them as they are.
#[derive(Serialize)]
pub struct Report {
    /// The adapter and its driver.
    #[serde(flatten)]
    pub names: EngineNames,
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Bits that the images' samples have.
    pub bits: u32,
    /// The same in words, where the files have more.
    #[serde(skip)]
    pub samples: Option<String>,
    /// How the images were turned, as their files say.
    pub turned: Option<String>,
    /// Smallest disparity searched.
    pub min_disparity: i32,
    /// Disparities searched.
    pub disparities: u32,
    /// The cameras of the rectified pair, where they are known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<Cameras>,
    /// Share of pixels that have a disparity, 0 to 1.
    pub valid: f64,
    /// Upload, kernels and readback.
    pub frame_ms: FrameMs,
    /// The first frame with the creation of device and pipelines.
    #[serde(serialize_with = "terminal::to_microseconds")]
    pub first_frame_ms: f64,
    /// Median time of each stage; none where the adapter has no timestamps.
    #[serde(serialize_with = "stages")]
    pub stages: Vec<StageTime>,
    /// What the winners cost; none of a network, which has no costs.
    pub energy: Option<EnergyReport>,
    /// The most device memory in use, 0 for the reference.
    pub peak_device_bytes: u64,
    /// The scores, if a truth was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub evaluation: Option<Evaluation>,
    /// The comparison with the reference, when asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub check: Option<Vec<Check>>,
    /// Why the map is doubtful.
    pub warnings: Vec<String>,
    /// The files that were written.
    #[serde(serialize_with = "terminal::paths")]
    pub outputs: Vec<PathBuf>,
}

/// The cameras of the rectified pair.
#[derive(Debug, Serialize)]
pub struct Cameras {
    focal_px: f64,
    baseline_m: f64,
    doffs_px: f64,
    cx_px: f64,
    cy_px: f64,
}

impl From<Camera> for Cameras {
    fn from(camera: Camera) -> Self {
        let Camera { focal, baseline, doffs, cx, cy, .. } = camera;
        Self { focal_px: focal, baseline_m: baseline, doffs_px: doffs, cx_px: cx, cy_px: cy }
    }
}

/// A stage compared with the reference.
#[derive(Debug, Serialize)]
pub struct Check {
    stage: String,
    elements: u64,
    mismatches: u64,
    first: Option<First>,
}

/// The first element that differs.
#[derive(Debug, Serialize)]
struct First {
    x: u32,
    y: u32,
    d: Option<u32>,
    expected: i64,
    got: i64,
}

impl From<StageCheck> for Check {
    fn from(check: StageCheck) -> Self {
        let first = check.first.map(|m| First { x: m.x, y: m.y, d: m.d, expected: m.expected, got: m.got });
        Self { stage: check.stage, elements: check.elements, mismatches: check.mismatches, first }
    }
}

fn stages<S: Serializer>(stages: &[StageTime], serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Stage<'a> {
        name: &'a str,
        ms: f64,
    }
    serializer.collect_seq(stages.iter().map(|stage| Stage { name: &stage.name, ms: rounded(stage.ms) }))
}

/// A number with six significant digits, as many as a calibration has.
fn digits(value: f64) -> f64 {
    let scale = 10f64.powi(5 - value.abs().log10().floor() as i32);
    if scale.is_finite() && scale > 0.0 { (value * scale).round() / scale } else { value }
}

impl Report {
    /// Whether no comparison found a mismatch.
    pub fn check_passed(&self) -> bool {
        self.check.iter().flatten().all(|stage| stage.mismatches == 0)
    }

    /// Prints what the job asked for.
    pub fn print(&self, job: &Job) -> Result<()> {
        if job.json {
            return terminal::print_json(self);
        }
        let mut text = String::new();
        if !job.quiet {
            text += &self.summary()?;
        }
        if job.timings {
            if self.stages.is_empty() {
                message("note: the adapter has no timestamp queries; only the total is known");
            }
            text += &self.timings_table();
            if let Some(energy) = &self.energy {
                writeln!(text, "energy   {}", energy.words())?;
            }
        }
        if let Some(evaluation) = &self.evaluation {
            text += &evaluation.table();
        }
        if let Some(check) = &self.check {
            text += &check_table(check);
        }
        if !self.check_passed() {
            message("check failed: the result differs from the CPU reference; no file was written");
        }
        terminal::print(&text)
    }

    fn summary(&self) -> Result<String> {
        let mut text = String::new();
        text += &summary::adapter_line(&self.names);
        writeln!(text, "size     {} x {}", self.width, self.height)?;
        for (what, told) in [("samples", &self.samples), ("turned", &self.turned)] {
            if let Some(told) = told {
                writeln!(text, "{what:<9}{told}")?;
            }
        }
        text += &summary::range_line(self.min_disparity, self.disparities);
        if let Some(Cameras { focal_px, baseline_m, .. }) = &self.camera {
            writeln!(text, "cameras  focal length {} px, baseline {} m", digits(*focal_px), digits(*baseline_m))?;
        }
        writeln!(text, "valid    {:.1} %", 100.0 * self.valid)?;
        writeln!(text, "frame    {:.1} ms (first {:.1} ms)", self.frame_ms.median, self.first_frame_ms)?;
        let outputs: Vec<_> = self.outputs.iter().map(|path| name(path).to_string()).collect();
        writeln!(text, "written  {}", if outputs.is_empty() { "nothing".into() } else { outputs.join(", ") })?;
        Ok(text)
    }

    fn timings_table(&self) -> String {
        let total = self.frame_ms.median;
        let row = |name: &str, ms: f64| {
            let share = if total > 0.0 { 100.0 * ms / total } else { 0.0 };
            [name.to_owned(), format!("{ms:.3}"), format!("{share:.1} %")]
        };
        let mut rows: Vec<_> = self.stages.iter().map(|stage| row(&stage.name, stage.ms)).collect();
        if !self.stages.is_empty() {
            // The medians of parts can add up to more than the median of the whole.
            let known: f64 = self.stages.iter().map(|stage| stage.ms).sum();
            rows.push(row("transfers and host", (total - known).max(0.0)));
        }
        rows.push(row("total", total));
        table(["stage", "ms", "share"], rows, 1..3)
    }
}

fn check_table(check: &[Check]) -> String {
    let first = |first: &Option<First>| match first {
        None => "-".into(),
        Some(First { x, y, d, expected, got }) => {
            let d = d.map(|d| format!(", d {d}")).unwrap_or_default();
            format!("x {x}, y {y}{d}: expected {expected}, got {got}")
        }
    };
    let row = |check: &Check| {
        [check.stage.clone(), check.elements.to_string(), check.mismatches.to_string(), first(&check.first)]
    };
    table(["stage", "elements", "mismatches", "first mismatch"], check.iter().map(row), 1..3)
}
