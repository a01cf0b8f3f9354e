//! Evaluate: a map beside the truth, in `eval` and with `--gt`.

use crate::args::{EvalArgs, TruthOptions};
use crate::maps::{self, Encoding};
use crate::output::{self, Output, SheetFormat};
use crate::{report, terminal, warnings};
use anyhow::{Context as _, Result, bail, ensure};
use gpu_stereo::evaluation::{self, FloatMap, Scores};
use image::{Rgb, RgbImage};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Where the truth of a pair is.
#[derive(Clone, Debug)]
pub struct TruthFile {
    /// The map.
    pub path: PathBuf,
    /// Which pixels count.
    pub mask: Option<PathBuf>,
    /// What the map's values mean.
    pub encoding: Encoding,
}

/// The truth, read.
pub struct Truth {
    /// The map.
    pub map: FloatMap,
    /// Which pixels count.
    pub mask: Option<Vec<bool>>,
}

impl TruthFile {
    /// What the options say; they need a truth.
    pub fn resolve(path: Option<&Path>, options: &TruthOptions, optics: Option<[f64; 2]>) -> Result<Option<Self>> {
        let TruthOptions { gt_scale, gt_mask, gt_depth, error_map } = options;
        let Some(path) = path else {
            let given = [
                (gt_scale.is_some(), "gt-scale"),
                (gt_mask.is_some(), "gt-mask"),
                (*gt_depth, "gt-depth"),
                (error_map.is_some(), "error-map"),
            ];
            return match given.iter().find(|(given, _)| *given) {
                Some((_, name)) => bail!("--{name} is about a truth, but none is given; add --gt FILE"),
                None => Ok(None),
            };
        };
        let depth = match (gt_depth, optics) {
            (true, Some([focal, baseline])) => Some(focal * baseline),
            (true, None) => bail!(
                "--gt-depth needs --focal PX and --baseline M, which make depths disparities; Virtual KITTI 2 has 725.0087 and \
                 0.532725"
            ),
            (false, _) => None,
        };
        let encoding = Encoding { scale: gt_scale.map(|scale| scale.0), depth };
        Ok(Some(Self { path: path.into(), mask: gt_mask.clone(), encoding }))
    }

    /// The files that are read.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        [Some(&self.path), self.mask.as_ref()].into_iter().flatten().map(PathBuf::as_path)
    }

    /// Reads the truth of a map of `size`, which `of` has.
    pub fn read(&self, size: (u32, u32), of: &Path) -> Result<Truth> {
        let map = maps::read(&self.path, self.encoding, "--gt-scale")?;
        let truth = (map.width(), map.height());
        ensure!(
            truth == size,
            "{:?} is {}x{}, but {of:?} is {}x{}; give the truth of this size",
            self.path,
            truth.0,
            truth.1,
            size.0,
            size.1
        );
        let mask = self.mask.as_ref().map(|path| maps::read_mask(path, size)).transpose()?;
        Ok(Truth { map, mask })
    }
}

impl Truth {
    /// What the estimate is worth.
    pub fn score(&self, estimate: &FloatMap) -> Result<Scores> {
        Ok(evaluation::evaluate(estimate, &self.map, self.mask.as_deref())?)
    }

    /// The errors in KITTI's colours.
    pub fn error_picture(&self, estimate: &FloatMap) -> Result<RgbImage> {
        let mut pixels = evaluation::error_picture(estimate, &self.map, self.mask.as_deref())?.into_iter();
        let (width, height) = (estimate.width(), estimate.height());
        Ok(RgbImage::from_fn(width, height, |_, _| Rgb(pixels.next().unwrap_or_default())))
    }
}

/// Scores as `--json` tells them: shares from 0 to 1, errors in px, null where no pixel is valid.
#[derive(Clone, Debug, Serialize)]
pub struct Evaluation {
    pixels: u64,
    pub density: f64,
    bad_0_5: f64,
    pub bad_1: f64,
    pub bad_2: f64,
    bad_4: f64,
    bad_0_5_of_valid: Option<f64>,
    bad_1_of_valid: Option<f64>,
    pub bad_2_of_valid: Option<f64>,
    bad_4_of_valid: Option<f64>,
    pub average_error: Option<f64>,
    rms_error: Option<f64>,
    a50: Option<f64>,
    a90: Option<f64>,
    pub a95: Option<f64>,
    a99: Option<f64>,
    pub d1_est: Option<f64>,
    pub d1_all: f64,
}

impl From<&Scores> for Evaluation {
    fn from(scores: &Scores) -> Self {
        let [bad_0_5, bad_1, bad_2, bad_4] = [0, 1, 2, 3].map(|i| scores.bad(i));
        let [bad_0_5_of_valid, bad_1_of_valid, bad_2_of_valid, bad_4_of_valid] =
            [0, 1, 2, 3].map(|i| scores.bad_of_valid(i));
        let [a50, a90, a95, a99] = [0, 1, 2, 3].map(|i| scores.quantiles.map(|errors| errors[i]));
        Self {
            pixels: scores.pixels,
            density: scores.density(),
            bad_0_5,
            bad_1,
            bad_2,
            bad_4,
            bad_0_5_of_valid,
            bad_1_of_valid,
            bad_2_of_valid,
            bad_4_of_valid,
            average_error: scores.average(),
            rms_error: scores.rms(),
            a50,
            a90,
            a95,
            a99,
            d1_est: scores.d1_est(),
            d1_all: scores.d1_all(),
        }
    }
}

/// A share in per cent, or a dash.
pub fn percent(share: impl Into<Option<f64>>) -> String {
    share.into().map_or("-".into(), |share| format!("{:.2} %", 100.0 * share))
}

/// An error in px, or a dash.
pub fn pixels(error: Option<f64>) -> String {
    error.map_or("-".into(), |error| format!("{error:.3} px"))
}

impl Evaluation {
    /// The mean of each figure over several maps, of those where it is known, and the sum of their pixels.
    pub fn mean(of: &[Self]) -> Self {
        let mean = |figure: fn(&Self) -> Option<f64>| {
            let known: Vec<_> = of.iter().filter_map(figure).collect();
            (!known.is_empty()).then(|| known.iter().sum::<f64>() / known.len() as f64)
        };
        let share = |figure: fn(&Self) -> f64| of.iter().map(figure).sum::<f64>() / of.len() as f64;
        Self {
            pixels: of.iter().map(|e| e.pixels).sum(),
            density: share(|e| e.density),
            bad_0_5: share(|e| e.bad_0_5),
            bad_1: share(|e| e.bad_1),
            bad_2: share(|e| e.bad_2),
            bad_4: share(|e| e.bad_4),
            bad_0_5_of_valid: mean(|e| e.bad_0_5_of_valid),
            bad_1_of_valid: mean(|e| e.bad_1_of_valid),
            bad_2_of_valid: mean(|e| e.bad_2_of_valid),
            bad_4_of_valid: mean(|e| e.bad_4_of_valid),
            average_error: mean(|e| e.average_error),
            rms_error: mean(|e| e.rms_error),
            a50: mean(|e| e.a50),
            a90: mean(|e| e.a90),
            a95: mean(|e| e.a95),
            a99: mean(|e| e.a99),
            d1_est: mean(|e| e.d1_est),
            d1_all: share(|e| e.d1_all),
        }
    }

    /// The table on stdout.
    pub fn table(&self) -> String {
        let both = |name: &str, all: f64, valid: Option<f64>| [name.to_owned(), percent(all), percent(valid)];
        let of_valid = |name: &str, error: Option<f64>| [name.to_owned(), String::new(), pixels(error)];
        let rows = [
            ["density".into(), percent(self.density), String::new()],
            both("bad-0.5", self.bad_0_5, self.bad_0_5_of_valid),
            both("bad-1", self.bad_1, self.bad_1_of_valid),
            both("bad-2", self.bad_2, self.bad_2_of_valid),
            both("bad-4", self.bad_4, self.bad_4_of_valid),
            both("D1", self.d1_all, self.d1_est),
            of_valid("average error", self.average_error),
            of_valid("RMS error", self.rms_error),
            of_valid("A50", self.a50),
            of_valid("A90", self.a90),
            of_valid("A95", self.a95),
            of_valid("A99", self.a99),
        ];
        let all = format!("of {} pixels", self.pixels);
        report::table(["", &all, "of those valid"], rows, 1..3)
    }
}

/// `eval`, ready to start.
pub struct Eval {
    estimate: PathBuf,
    scale: Option<f64>,
    truth: TruthFile,
    error_map: Vec<Output<SheetFormat>>,
    json: bool,
}

/// What `eval` found; `--json` prints it as it is.
#[derive(Serialize)]
struct Found {
    width: u32,
    height: u32,
    evaluation: Evaluation,
    warnings: Vec<String>,
    #[serde(serialize_with = "report::paths")]
    outputs: Vec<PathBuf>,
}

/// Checks what can be checked without reading the maps.
pub fn resolve(args: EvalArgs) -> Result<Eval> {
    let EvalArgs { estimate, truth, scale, options, optics, json } = args;
    let optics = optics.both()?;
    if optics.is_some() && !options.gt_depth {
        bail!("--focal and --baseline make depths disparities, but the truth is none; add --gt-depth");
    }
    let file =
        TruthFile::resolve(Some(&truth), &options, optics)?.context("a truth is needed; see gpu-stereo eval --help")?;
    let inputs: Vec<_> = file.files().chain([estimate.as_path()]).collect();
    let error_map = match &options.error_map {
        Some(path) => vec![output::resolve_error_map(path, &inputs)?],
        None => Vec::new(),
    };
    Ok(Eval { scale: scale.map(|scale| scale.0), truth: file, error_map, json, estimate })
}

impl Eval {
    /// Compares the two maps and prints the scores.
    pub fn run(&self) -> Result<()> {
        let estimate = maps::read(&self.estimate, Encoding { scale: self.scale, depth: None }, "--scale")?;
        let truth = self.truth.read((estimate.width(), estimate.height()), &self.estimate)?;
        let evaluation = Evaluation::from(&truth.score(&estimate)?);
        if !self.error_map.is_empty() {
            output::write_sheet(&self.error_map, &truth.error_picture(&estimate)?)?;
        }
        if !self.json {
            return terminal::print(&evaluation.table());
        }
        let outputs = self.error_map.iter().map(|output| output.path.clone()).collect();
        let (width, height) = (estimate.width(), estimate.height());
        let found = Found { width, height, evaluation, warnings: warnings::all(), outputs };
        terminal::print_json(&found)
    }
}
