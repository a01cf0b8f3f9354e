//! The log of a bench: the results of each scene with each variant, so that an interrupted run can be resumed.

use crate::engine::compute::EngineNames;
use crate::engine::known::KnownFile;
use crate::engine::log::Log;
use anyhow::Result;
use gpu_stereo::evaluation::Scores;
use gpu_stereo::files::hash;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::path::Path;
use std::{fs, io};

/// The file's name.
const NAME: &str = "done.jsonl";

/// The results of a scene with a variant. Floats are kept to the bit.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Kept {
    /// The scene, the variant and all that decides about the result.
    key: [String; 3],
    /// Images, truths and calibrations.
    inputs: Vec<KnownFile>,
    /// Pictures and files to submit.
    outputs: Vec<KnownFile>,
    /// Why it is doubtful.
    pub warnings: Vec<String>,
    /// The adapter and its driver.
    pub names: EngineNames,
    /// Columns and rows.
    pub size: (u32, u32),
    /// The smallest disparity searched and their number; earlier logs do without.
    #[serde(default)]
    pub range: Option<(i32, u32)>,
    /// The share of valid pixels.
    pub valid: F64Bits,
    /// Median and smallest time of a frame in milliseconds.
    pub ms: [F64Bits; 2],
    /// Of all pixels with a truth, and of those that are not occluded.
    pub scores: [Option<KeptScores>; 2],
}

/// The bits of an `f64`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct F64Bits(u64);

impl From<f64> for F64Bits {
    fn from(number: f64) -> Self {
        Self(number.to_bits())
    }
}

impl From<F64Bits> for f64 {
    fn from(bits: F64Bits) -> Self {
        Self::from_bits(bits.0)
    }
}

/// [`Scores`].
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct KeptScores {
    counts: [u64; 4],
    bad: [u64; 4],
    sums: [F64Bits; 2],
    quantiles: Option<[F64Bits; 4]>,
}

impl From<&Scores> for KeptScores {
    fn from(scores: &Scores) -> Self {
        Self {
            counts: [scores.pixels, scores.valid, scores.d1_est, scores.d1_all],
            bad: scores.bad,
            sums: [scores.error_sum.into(), scores.squared_sum.into()],
            quantiles: scores.quantiles.map(|errors| errors.map(Into::into)),
        }
    }
}

impl From<&KeptScores> for Scores {
    fn from(kept: &KeptScores) -> Self {
        let [pixels, valid, d1_est, d1_all] = kept.counts;
        let [error_sum, squared_sum] = kept.sums.map(Into::into);
        let mut scores = Self::default();
        (scores.pixels, scores.valid, scores.bad) = (pixels, valid, kept.bad);
        (scores.d1_est, scores.d1_all) = (d1_est, d1_all);
        (scores.error_sum, scores.squared_sum) = (error_sum, squared_sum);
        scores.quantiles = kept.quantiles.map(|errors| errors.map(Into::into));
        scores
    }
}

/// The log of a report's folder, or none.
pub struct BenchLog {
    log: Option<Log>,
    there: HashMap<[String; 3], Kept>,
}

impl BenchLog {
    /// Opens the log of a report. Without `resume`, an old one is removed.
    pub fn open(report: Option<&Path>, resume: bool) -> Result<Self> {
        let log = report.map(|folder| Log { path: folder.join(NAME) });
        let mut there = HashMap::new();
        if let Some(log) = &log {
            log.ensure_own()?;
            if resume {
                there = log.read::<Kept>()?.into_iter().map(|kept| (kept.key.clone(), kept)).collect();
            } else if let Err(error) = fs::remove_file(&log.path)
                && error.kind() != io::ErrorKind::NotFound
            {
                return Err(error.into());
            }
        }
        Ok(Self { log, there })
    }

    /// Earlier results with the same settings and files, if everything that was written still exists.
    pub fn find(&self, scene: &str, variant: &str, settings: &str) -> Option<&Kept> {
        let kept = self.there.get(&[scene.into(), variant.into(), hash(settings.as_bytes())])?;
        let inputs = kept.inputs.iter().all(|input| input.facts.are_of_input(&input.path.0));
        let outputs = || kept.outputs.iter().all(|output| output.facts.are_of_output(&output.path.0));
        (inputs && outputs()).then_some(kept)
    }

    /// The facts of a scene's files before they are read; nothing without a log.
    pub fn inputs<'a>(&self, files: impl Iterator<Item = &'a Path>) -> Vec<KnownFile> {
        if self.log.is_some() { files.filter_map(KnownFile::read).collect() } else { Vec::new() }
    }

    /// Logs results, once all their files are written.
    pub fn keep(
        &self,
        [scene, variant, key]: [&str; 3],
        inputs: &[KnownFile],
        outputs: Vec<KnownFile>,
        found: ToKeep<'_>,
    ) -> Result<()> {
        let Some(log) = &self.log else { return Ok(()) };
        let ToKeep { warnings, names, size, range, valid, ms, scores } = found;
        let kept = Kept {
            key: [scene.into(), variant.into(), hash(key.as_bytes())],
            inputs: inputs.to_vec(),
            outputs,
            warnings,
            names,
            size,
            range: Some(range),
            valid: valid.into(),
            ms: ms.map(Into::into),
            scores: scores.map(|scores| scores.map(Into::into)),
        };
        log.append(&[kept], true)
    }
}

/// The results to keep.
pub struct ToKeep<'a> {
    /// Why it is doubtful.
    pub warnings: Vec<String>,
    /// The adapter and its driver.
    pub names: EngineNames,
    /// Columns and rows.
    pub size: (u32, u32),
    /// The smallest disparity searched and their number.
    pub range: (i32, u32),
    /// The share of valid pixels.
    pub valid: f64,
    /// Median and smallest time of a frame in milliseconds.
    pub ms: [f64; 2],
    /// Of all pixels with a truth, and of those that are not occluded.
    pub scores: [Option<&'a Scores>; 2],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scores_are_kept_to_the_bit() {
        let mut scores = Scores::default();
        (scores.pixels, scores.valid, scores.bad) = (7, 6, [5, 4, 3, 2]);
        (scores.d1_est, scores.d1_all, scores.error_sum, scores.squared_sum) = (1, 2, 0.1 + 0.2, 1.0 / 3.0);
        scores.quantiles = Some([0.1, 0.7, f64::MAX, 1e-300]);
        let text = serde_json::to_string(&KeptScores::from(&scores)).unwrap();
        let again = Scores::from(&serde_json::from_str::<KeptScores>(&text).unwrap());
        assert_eq!(format!("{again:?}"), format!("{scores:?}"));
    }
}
