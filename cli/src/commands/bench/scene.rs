//! A scene: its images and truths, and its results with a variant.

use super::log::{Kept, ToKeep};
use crate::args::{self, InputArgs};
use crate::commands::variants::{self, Variant};
use crate::engine::compute::{Cameras, EngineNames, FrameMs};
use crate::engine::diagnosis::{self, Evidence, Finding};
use crate::engine::images;
use crate::terminal::{Evaluation, Progress, percent, warnings};
use anyhow::{Result, ensure};
use gpu_stereo::evaluation::{FloatMap, Scores};
use gpu_stereo::files::datasets::Scene;
use gpu_stereo::files::images::ImagePair;
use gpu_stereo::files::truth::{Truth, TruthFile};
use gpu_stereo::{Camera, Image, Params, Rectification};
use serde::Serialize;

/// A scene as it was read.
pub struct Loaded {
    pub left: Image,
    pub right: Image,
    /// Why the images may be wrong, and their corners.
    pub doubts: Vec<String>,
    pub evidence: Evidence,
    pub disparities: u32,
    /// How the pair is rectified, and the cameras of its depth, if that is wanted.
    pub rectify: Option<Rectification>,
    pub camera: Option<Camera>,
    /// The truth with all its pixels, and with those that are not occluded.
    pub truth: Option<Truth>,
    pub noc: Option<Truth>,
}

/// Reads a scene; `depth`: whether the cameras of its depth are wanted, and whether they are needed. Where the options say no
/// cameras, those are taken that the data set has.
pub fn load(scene: &Scene, input: &InputArgs, cameras: &Cameras, [depth, needs_cameras]: [bool; 2]) -> Result<Loaded> {
    let disparities = scene.disparities()?;
    let ImagePair { left, right, mut doubts, .. } = images::read_pair(&scene.left, &scene.right, input)?;
    let size = (left.width(), left.height());
    let mut fitted = Params::sgm(1); // any: all variants have the cameras in common
    let own = if depth && !cameras.are_known() { scene.calibration(size.into())? } else { None };
    let cameras = &cameras.clone().or(own.as_ref());
    ensure!(
        !needs_cameras || cameras.are_known(),
        "a depth or points need the cameras, which the data set does not tell; give --calib FILE, or --focal PX and --baseline M"
    );
    cameras.fit(&mut fitted, size.into(), depth)?;
    let evidence = diagnosis::evidence(&left, &right, &fitted)?;
    let read = |truth: &TruthFile| cameras.truth(size.into(), |size| Ok(truth.read(size, &scene.left)?));
    let truth = scene.truth.as_ref().map(read).transpose()?;
    doubts.extend(truth.iter().flat_map(|truth| truth.doubts.clone()));
    let noc = scene.truth.as_ref().zip(scene.non_occluded.as_ref()).map(|(truth, non_occluded)| {
        let read = |size| -> Result<Truth> {
            let mask = Some(non_occluded.read(size)?);
            Ok(Truth { mask, doubts: Vec::new(), ..truth.read(size, &scene.left)? })
        };
        cameras.truth(size.into(), read)
    });
    let noc = noc.transpose()?;
    let Params { rectify, depth: camera, .. } = fitted;
    Ok(Loaded { left, right, doubts, evidence, disparities, rectify, camera, truth, noc })
}

impl Loaded {
    /// Reports why the scene's map is doubtful.
    pub fn warn(&self, scene: &Scene, variant: &Variant, params: &Params, progress: &Progress) {
        let warn = |of: &str, text: &str| warnings::warn_by(&format!("{of}: {text}"), |line| progress.message(line));
        let scene = scene.label();
        self.doubts.iter().for_each(|doubt| warn(&scene, doubt));
        match self.evidence.finding(&params.searched()) {
            Some(finding @ Finding::Range { .. }) => warn(&format!("{scene}, {}", variant.label), &finding.to_string()),
            Some(finding) => warn(&scene, &finding.to_string()), // of all variants
            None => {}
        }
    }
}

/// The settings of a variant for a scene of so many disparities; of a network the next larger multiple of 16.
pub fn settings(variant: &Variant, disparities: u32) -> Result<(Vec<(String, String)>, Params)> {
    let mut settings = variant.settings.clone();
    let network = &variant.params.network;
    let disparities = if network.is_some() { disparities.next_multiple_of(16) } else { disparities };
    if !settings.iter().any(|(name, _)| name == "disp") {
        settings.push(("disp".into(), disparities.to_string()));
    }
    let mut params = args::params(settings.iter().map(|(name, value)| (name.as_str(), value.as_str())))?;
    params.network = network.clone();
    params.features = variant.params.features.clone();
    Ok((settings, params))
}

/// A scene with a variant.
#[derive(Serialize)]
pub struct SceneReport {
    pub set: String,
    pub scene: String,
    pub variant: String,
    #[serde(serialize_with = "variants::settings")]
    pub settings: Vec<(String, String)>,
    pub width: u32,
    pub height: u32,
    pub min_disparity: i32,
    pub disparities: u32,
    pub valid: f64,
    pub frame_ms: FrameMs,
    /// Of all pixels with a truth.
    pub evaluation: Option<Evaluation>,
    /// Of those that are not occluded, where that is known.
    pub evaluation_noc: Option<Evaluation>,
    #[serde(skip)]
    pub scores: [Option<Scores>; 2],
    /// The numbers of scene and variant, from 1.
    #[serde(skip)]
    pub numbers: [usize; 2],
}

impl SceneReport {
    /// The results of a scene with a variant, not scored yet.
    pub fn new(
        scene: &Scene,
        variant: &Variant,
        params: &Params,
        settings: Vec<(String, String)>,
        frame_ms: FrameMs,
    ) -> Self {
        Self {
            set: scene.set.clone(),
            scene: scene.name.clone(),
            variant: variant.label.clone(),
            settings,
            width: 0,
            height: 0,
            min_disparity: params.min_disparity,
            disparities: params.disparities,
            valid: 0.0,
            frame_ms,
            evaluation: None,
            evaluation_noc: None,
            scores: [None, None],
            numbers: [0, 0],
        }
    }

    /// What was found before.
    pub fn of_kept(scene: &Scene, variant: &Variant, kept: &Kept) -> Result<Self> {
        let (settings, params) = settings(variant, scene.disparities()?)?;
        let [median, min] = kept.ms.map(f64::from);
        let report = Self::new(scene, variant, &params, settings, FrameMs { median, min });
        let (width, height) = kept.size;
        let (min_disparity, disparities) = kept.range.unwrap_or((report.min_disparity, report.disparities));
        let report = Self { width, height, min_disparity, disparities, valid: kept.valid.into(), ..report };
        Ok(report.with_scores(kept.scores.each_ref().map(|scores| scores.as_ref().map(Scores::from))))
    }

    fn with_scores(self, scores: [Option<Scores>; 2]) -> Self {
        let [evaluation, evaluation_noc] = scores.each_ref().map(|scores| scores.as_ref().map(Evaluation::from));
        Self { evaluation, evaluation_noc, scores, ..self }
    }

    /// The same with scores, where there is a truth.
    pub fn scored(self, loaded: &Loaded, estimate: &FloatMap) -> Result<Self> {
        let score = |truth: &Option<Truth>| truth.as_ref().map(|truth| truth.score(estimate)).transpose();
        Ok(self.with_scores([score(&loaded.truth)?, score(&loaded.noc)?]))
    }

    /// The results to keep.
    pub fn kept<'a>(&'a self, names: EngineNames, warnings: &[String]) -> ToKeep<'a> {
        ToKeep {
            warnings: warnings.to_vec(),
            names,
            size: (self.width, self.height),
            range: (self.min_disparity, self.disparities),
            valid: self.valid,
            ms: [self.frame_ms.median, self.frame_ms.min],
            scores: self.scores.each_ref().map(Option::as_ref),
        }
    }

    /// The results in a few words.
    pub fn in_words(&self) -> String {
        let scores = match &self.scores[0] {
            Some(scores) => {
                format!("D1-all {}, bad-2 of valid {}", percent(scores.d1_all()), percent(scores.bad_of_valid(2)))
            }
            None => format!("{:.1} % valid, no truth", 100.0 * self.valid),
        };
        format!("{scores}, {:.0} ms", self.frame_ms.median)
    }
}
