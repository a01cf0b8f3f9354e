//! Bench: every scene of a data set with every variant: scores, a report with pictures, files to submit.

use crate::args::{Backend, BenchArgs, DeviceArgs, InputArgs};
use crate::bench_log::{self, BenchLog, Kept, Known};
use crate::diagnosis::{self, Evidence, Finding};
use crate::evaluate::{Evaluation, Truth, percent, pixels};
use crate::layout::{Layout, Scene};
use crate::output::{self, Format};
use crate::progress::Progress;
use crate::report::{self, FrameMs};
use crate::resolve;
use crate::run::Engine;
use crate::study::{self, Variant};
use crate::terminal::{self, name, one_line, plain};
use crate::views::{self, Views};
use crate::{adapter, disk, environment, list, places, warnings};
use anyhow::{Result, bail, ensure};
use gpu_stereo::evaluation::{FloatMap, Scores};
use gpu_stereo::{DisparityMap, Image, Params};
use image::RgbImage;
use image::imageops::{self, FilterType};
use serde::Serialize;
use std::collections::BTreeSet;
use std::fmt::{self, Display, Formatter, Write as _};
use std::path::{Path, PathBuf};

/// Pictures of the report are at most so wide.
const PICTURE: u32 = 480;

/// What is in its folder.
const REPORT: &str = "report.md";
const RESULTS: &str = "results.json";
const PICTURES: &str = "pictures";

/// A run over a data set, ready to start.
pub struct Bench {
    layout: Layout,
    scenes: Vec<Scene>,
    variants: Vec<Variant>,
    input: InputArgs,
    device: DeviceArgs,
    repeat: Option<u32>,
    report: Option<PathBuf>,
    submission: Option<Submission>,
    resume: bool,
    json: bool,
    quiet: bool,
}

/// Where files to submit go.
struct Submission {
    folder: PathBuf,
    method: String,
}

/// Finds the scenes and checks what can be checked without computing.
pub fn resolve(args: BenchArgs) -> Result<Bench> {
    let common: Vec<_> = args.settings.iter().collect();
    let variants = if args.variants.is_empty() {
        let settings = common.iter().map(|(name, value)| (String::from(*name), String::from(*value))).collect();
        let label = match study::told(common.iter().copied()) {
            text if text.is_empty() => "default".into(),
            text => text,
        };
        vec![Variant { label, settings, params: resolve::params(common.iter().copied())? }]
    } else {
        study::named(&args.variants, &common)?
    };
    for (i, variant) in variants.iter().enumerate() {
        if let Some(other) = variants[..i].iter().find(|other| other.params == variant.params) {
            bail!(
                "--variants has {:?} and {:?}, which are the same settings; name them once",
                other.label,
                variant.label
            );
        }
    }
    resolve::tell_unused(
        &variants
            .iter()
            .map(|v| (v.settings.iter().map(|(name, _)| name.as_str()).collect(), &v.params))
            .collect::<Vec<_>>(),
    );
    resolve::ensure_adapter(&args.device)?;
    let repeat = args.repeat.as_ref().map(resolve::repeat).transpose()?;
    let mut scenes = args.layout.scenes(&args.dataset)?;
    let mut labels = BTreeSet::new();
    if let Some(label) = scenes.iter().map(Scene::label).find(|label| !labels.insert(label.clone())) {
        bail!("the data set has the scene {:?} twice; each SET/NAME may be there once", name(&label));
    }
    let found = scenes.len();
    scenes.retain(|scene| args.only.is_empty() || args.only.iter().any(|part| scene.label().contains(part)));
    ensure!(
        !scenes.is_empty(),
        "--only is {:?}, but none of the {found} scenes has it in SET/NAME, such as {}; give a part of one",
        args.only.join(" "),
        name(&args.layout.scenes(&args.dataset)?.first().map(Scene::label).unwrap_or_default())
    );
    let submission = args.submission.map(|folder| {
        ensure!(
            !matches!(args.layout, Layout::Vkitti2 | Layout::Manifest),
            "--submission is {folder:?}, but nothing is submitted for this --layout; drop it, or take kitti2012, kitti2015, \
             middlebury or eth3d"
        );
        let method = args.method_name.clone();
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
        ensure!(
            !method.is_empty() && method.chars().all(is_plain),
            "--method-name is {method:?}, but letters, digits, - _ and . are allowed; it becomes a part of file names"
        );
        Ok(Submission { folder, method })
    });
    let submission = submission.transpose()?;
    for folder in [args.report.as_ref(), submission.as_ref().map(|s| &s.folder)].into_iter().flatten() {
        output::ensure_folder(folder)?;
    }
    ensure!(
        !args.resume || args.report.is_some(),
        "--resume needs the folder where the earlier run kept what it found; add --report FOLDER"
    );
    if args.no_sync {
        disk::leave_to_the_system();
    }
    let bench = Bench {
        layout: args.layout,
        scenes,
        variants,
        input: args.input,
        device: args.device,
        repeat,
        report: args.report,
        submission,
        resume: args.resume,
        json: args.json,
        quiet: args.quiet,
    };
    bench.ensure_outputs()?;
    Ok(bench)
}

/// What was found; `--json` prints it as it is.
#[derive(Serialize)]
struct Found {
    adapter: String,
    backend: String,
    driver: String,
    scenes: Vec<SceneFound>,
    sets: Vec<SetFound>,
    failures: Vec<Failure>,
    warnings: Vec<String>,
}

/// A scene with a variant.
#[derive(Serialize)]
struct SceneFound {
    set: String,
    scene: String,
    variant: String,
    #[serde(serialize_with = "study::settings")]
    settings: Vec<(String, String)>,
    width: u32,
    height: u32,
    min_disparity: i32,
    disparities: u32,
    valid: f64,
    frame_ms: FrameMs,
    /// Of all pixels with a truth.
    evaluation: Option<Evaluation>,
    /// Of those that are not occluded, where that is known.
    evaluation_noc: Option<Evaluation>,
    #[serde(skip)]
    scores: [Option<Scores>; 2],
    /// The numbers of scene and variant, from 1.
    #[serde(skip)]
    numbers: [usize; 2],
}

/// A result that could not be written.
#[derive(Debug)]
struct Unwritten(anyhow::Error);

impl Display for Unwritten {
    fn fmt(&self, to: &mut Formatter<'_>) -> fmt::Result {
        write!(to, "{:#}", self.0)
    }
}

impl std::error::Error for Unwritten {}

/// A set with a variant: the mean of its scenes, and all their pixels together.
#[derive(Serialize)]
struct SetFound {
    set: String,
    variant: String,
    region: &'static str,
    scenes: usize,
    mean: Evaluation,
    pooled: Evaluation,
    frame_ms: f64,
}

#[derive(Serialize)]
struct Failure {
    scene: String,
    variant: Option<String>,
    error: String,
}

const REGIONS: [&str; 2] = ["all", "noc"];

/// A scene as it was read.
struct Loaded {
    left: Image,
    right: Image,
    /// Why the images may be wrong, and what their corners tell.
    doubts: Vec<String>,
    evidence: Evidence,
    disparities: u32,
    /// The truth with all its pixels, and with those that are not occluded.
    truth: Option<Truth>,
    noc: Option<Truth>,
}

impl Bench {
    /// Every file can be written and can hold what it is to hold, and none is one of the data set's.
    fn ensure_outputs(&self) -> Result<()> {
        let mut outputs = Vec::new();
        if let Some(folder) = &self.report {
            for name in [REPORT, RESULTS] {
                output::writable_place(&folder.join(name))?;
                outputs.push(folder.join(name));
            }
            output::make_folder(&folder.join(PICTURES), &folder.join(PICTURES))?;
        }
        if let Some(submission) = &self.submission {
            let mut folders = BTreeSet::new();
            for variant in &self.variants {
                ensure!(
                    folders.insert(submission.folder_of(self, variant)),
                    "--variants has {:?} and another whose folder would have the same name; run them one by one",
                    variant.label
                );
                for scene in &self.scenes {
                    let files = [false, true].map(|sparse| submission.files(self, scene, variant, sparse));
                    if files[0].format == Format::Kitti {
                        let (_, params) = settings(variant, scene.disparities()?)?;
                        output::ensure_range(Format::Kitti, &files[0].map, &params)?;
                    }
                    outputs.extend(files.into_iter().flat_map(|files| [Some(files.map), files.time]).flatten());
                }
            }
        }
        let inputs = self.scenes.iter().flat_map(Scene::files);
        places::ensure_apart(outputs.iter().map(PathBuf::as_path), inputs)
    }

    /// Computes, scores and writes everything. Whether no scene failed.
    pub fn run(&self) -> Result<bool> {
        if self.device.backend != Backend::Cpu {
            let names: Vec<_> = adapter::ranked()?.iter().map(|adapter| adapter.get_info().name).collect();
            if let Some(wanted) = &self.device.adapter {
                adapter::choose(&names, wanted)?;
            }
            ensure!(
                self.device.backend != Backend::Gpu || !names.is_empty(),
                "--backend is gpu, but there is no adapter{}; install a Vulkan driver, or take auto or cpu",
                environment::why_none()
            );
        }
        let progress = Progress::new(self.scenes.len() * self.variants.len(), self.quiet);
        let (mut engine, mut names) = (None, None);
        let mut found = Found {
            adapter: String::new(),
            backend: String::new(),
            driver: String::new(),
            scenes: vec![],
            sets: vec![],
            failures: vec![],
            warnings: vec![],
        };
        let log = BenchLog::open(self.report.as_deref(), self.resume)?;
        for (number, scene) in (1..).zip(&self.scenes) {
            let label = scene.label();
            progress.begin(&label);
            let mut fail = |variant: Option<&Variant>, error: anyhow::Error| {
                let (scene, variant) = (label.clone(), variant.map(|variant| variant.label.clone()));
                let error = one_line(&format!("{error:#}"));
                let of = variant.iter().map(|variant| format!(", {variant}")).collect::<String>();
                progress.tell(&format!("failed: {}{}: {error}", name(&scene), plain(&of)));
                found.failures.push(Failure { scene, variant, error });
            };
            let warned = warnings::all().len();
            let key = |place: usize| self.key(number, place, scene);
            let kept = |place: usize| log.find(&label, &self.variants[place].label, &key(place));
            let kept: Vec<_> = (0..self.variants.len()).map(kept).collect();
            let inputs = if kept.iter().all(Option::is_some) { Vec::new() } else { log.inputs(scene.files()) };
            let loaded = if kept.iter().all(Option::is_some) { None } else { Some(load(scene, &self.input)) };
            let loaded = match loaded.transpose() {
                Ok(loaded) => loaded,
                Err(error) => {
                    fail(None, error);
                    self.variants.iter().for_each(|_| progress.done(&name(&label).to_string()));
                    continue;
                }
            };
            let mut is_first = true;
            for (place, variant) in self.variants.iter().enumerate() {
                let told = format!("{}, {}", name(&label), plain(&variant.label));
                let done = match (kept[place], &loaded) {
                    (Some(kept), _) => {
                        names.get_or_insert_with(|| kept.names.clone());
                        kept.warnings.iter().for_each(|line| warnings::warn_by(line, |line| progress.tell(line)));
                        self.kept(scene, variant, kept)
                    }
                    (None, Some(loaded)) => {
                        let result = self.compute(&mut engine, scene, loaded, variant);
                        if let Some(engine) = &engine {
                            names.get_or_insert_with(|| engine.names());
                        }
                        if let Ok((params, ..)) = &result {
                            loaded.warn(scene, variant, params, &progress);
                        }
                        result.and_then(|(params, map, mut result)| {
                            result.numbers = [number, place + 1];
                            result.score(loaded, &(&map).into())?;
                            let written = self.write(&result, scene, variant, loaded, &map, &params, is_first);
                            let outputs = written.map_err(Unwritten)?;
                            let names = names.clone().unwrap_or_default();
                            let keep = [label.as_str(), &variant.label, &key(place)];
                            log.keep(keep, &inputs, outputs, result.kept(names, &warnings::all()[warned..]))
                                .map_err(Unwritten)?;
                            Ok(result)
                        })
                    }
                    (None, None) => continue, // all were kept
                };
                match done {
                    Ok(mut result) => {
                        result.numbers = [number, place + 1];
                        is_first = false;
                        progress.done(&format!("{told}: {}", result.told()));
                        found.scenes.push(result);
                    }
                    Err(error) => {
                        if error.downcast_ref().is_some_and(|Unwritten(error)| disk::is_lasting(error)) {
                            drop(progress);
                            let (maps, all) = (found.scenes.len(), self.scenes.len() * self.variants.len());
                            let advice = if self.report.is_some() { ": --resume computes the rest" } else { "" };
                            bail!("{error:#}; {maps} of {all} maps were scored{advice}");
                        }
                        fail(Some(variant), error);
                        progress.done(&told);
                    }
                }
            }
        }
        drop(progress);
        (found.adapter, found.backend, found.driver) = names.unwrap_or_default();
        found.sets = sets(&found.scenes);
        found.warnings = warnings::all();
        if let Some(folder) = &self.report {
            write_report(folder, &found)?;
        }
        if self.json {
            terminal::print_json(&found)?;
        } else if !self.quiet {
            let set_table = set_table(&found.sets);
            terminal::print(&format!("{}{}{set_table}", scene_table(&found.scenes), separator(&set_table)))?;
        }
        Ok(found.failures.is_empty())
    }

    /// All that decides about the result of a scene with a variant and about the files that are made of it, but the contents
    /// of the scene's files.
    fn key(&self, number: usize, place: usize, scene: &Scene) -> String {
        let variant = &self.variants[place];
        let submission = self.submission.as_ref().map(|to| (list::absolute(&to.folder), &to.method));
        let files: Vec<_> = scene.files().map(list::absolute).collect();
        let (version, several) = (env!("CARGO_PKG_VERSION"), self.variants.len() > 1);
        let of_run = (
            version,
            self.layout,
            self.repeat,
            self.device.backend,
            &self.device.adapter,
            submission,
            several,
            &self.input,
        );
        format!("{of_run:?} {number} {place} {:?} {:?} {scene:?} {files:?}", variant.settings, variant.params)
    }

    /// What was found before.
    fn kept(&self, scene: &Scene, variant: &Variant, kept: &Kept) -> Result<SceneFound> {
        let (settings, params) = settings(variant, scene.disparities()?)?;
        let scores = kept.scores.each_ref().map(|scores| scores.as_ref().map(Scores::from));
        let [evaluation, evaluation_noc] = scores.each_ref().map(|scores| scores.as_ref().map(Evaluation::from));
        let [median, min] = kept.ms.map(f64::from);
        Ok(SceneFound {
            set: scene.set.clone(),
            scene: scene.name.clone(),
            variant: variant.label.clone(),
            settings,
            width: kept.size.0,
            height: kept.size.1,
            min_disparity: params.min_disparity,
            disparities: params.disparities,
            valid: kept.valid.into(),
            frame_ms: FrameMs { median, min },
            evaluation,
            evaluation_noc,
            scores,
            numbers: [0, 0],
        })
    }

    /// Writes the files of a scene with a variant.
    #[allow(clippy::too_many_arguments)]
    fn write(
        &self,
        found: &SceneFound,
        scene: &Scene,
        variant: &Variant,
        loaded: &Loaded,
        map: &DisparityMap,
        params: &Params,
        is_first: bool,
    ) -> Result<Vec<Known>> {
        let mut written = Vec::new();
        if let Some(submission) = &self.submission {
            written.extend(submission.write(self, scene, variant, map, found, params)?);
        }
        if let Some(report) = &self.report {
            written.extend(write_pictures(report, found, loaded, map, output::searched(params), is_first)?);
        }
        Ok(written)
    }

    /// The map of a scene.
    fn compute(
        &self,
        engine: &mut Option<Engine>,
        scene: &Scene,
        loaded: &Loaded,
        variant: &Variant,
    ) -> Result<(Params, DisparityMap, SceneFound)> {
        let (settings, params) = settings(variant, loaded.disparities)?;
        let ready = match engine.take() {
            None => Engine::open(&self.device, false, &loaded.left, &params)?,
            Some(engine) => engine.again(&loaded.left, &params)?,
        };
        let ready = engine.insert(ready);
        // On an adapter the first frame compiles.
        let repeat = self.repeat.or_else(|| (ready.device_bytes() > 0).then_some(1));
        let frames = match ready.frames(&loaded.left, &loaded.right, &params, false, repeat) {
            Ok(frames) => frames,
            Err(error) => {
                *engine = None; // the device may be lost
                return Err(error.into());
            }
        };
        let map = frames.matched.map;
        let result = SceneFound {
            set: scene.set.clone(),
            scene: scene.name.clone(),
            variant: variant.label.clone(),
            settings,
            width: map.width,
            height: map.height,
            min_disparity: params.min_disparity,
            disparities: params.disparities,
            valid: map.valid_fraction(),
            frame_ms: frames.times,
            evaluation: None,
            evaluation_noc: None,
            scores: [None, None],
            numbers: [0, 0],
        };
        Ok((params, map, result))
    }
}

/// The settings of a variant for a scene of so many disparities.
fn settings(variant: &Variant, disparities: u32) -> Result<(Vec<(String, String)>, Params)> {
    let mut settings = variant.settings.clone();
    if !settings.iter().any(|(name, _)| name == "disp") {
        settings.push(("disp".into(), disparities.to_string()));
    }
    let params = resolve::params(settings.iter().map(|(name, value)| (name.as_str(), value.as_str())))?;
    Ok((settings, params))
}

impl Loaded {
    /// Says why the scene's map is doubtful.
    fn warn(&self, scene: &Scene, variant: &Variant, params: &Params, progress: &Progress) {
        let warn = |of: &str, text: &str| warnings::warn_by(&format!("{of}: {text}"), |line| progress.tell(line));
        let scene = scene.label();
        self.doubts.iter().for_each(|doubt| warn(&scene, doubt));
        match self.evidence.finding(&params.searched()) {
            Some(finding @ Finding::Range { .. }) => warn(&format!("{scene}, {}", variant.label), &finding.to_string()),
            Some(finding) => warn(&scene, &finding.to_string()), // of all variants
            None => {}
        }
    }
}

fn load(scene: &Scene, options: &InputArgs) -> Result<Loaded> {
    let disparities = scene.disparities()?;
    let Views { left, right, doubts, .. } = views::read_pair(&scene.left, &scene.right, options)?;
    let evidence = diagnosis::evidence(&left, &right, &Params::sgm(1))?; // no variant rectifies
    let size = (left.width(), left.height());
    let truth = scene.truth.as_ref().map(|truth| truth.read(size, &scene.left)).transpose()?;
    let noc = match (&truth, &scene.non_occluded) {
        (Some(truth), Some(non_occluded)) => {
            Some(Truth { map: truth.map.clone(), mask: Some(non_occluded.read(size)?) })
        }
        _ => None,
    };
    Ok(Loaded { left, right, doubts, evidence, disparities, truth, noc })
}

impl SceneFound {
    fn score(&mut self, loaded: &Loaded, estimate: &FloatMap) -> Result<()> {
        let score = |truth: &Option<Truth>| truth.as_ref().map(|truth| truth.score(estimate)).transpose();
        self.scores = [score(&loaded.truth)?, score(&loaded.noc)?];
        [self.evaluation, self.evaluation_noc] = self.scores.each_ref().map(|s| s.as_ref().map(Evaluation::from));
        Ok(())
    }

    /// What is kept of it.
    fn kept<'a>(&'a self, names: (String, String, String), warnings: &[String]) -> bench_log::Found<'a> {
        bench_log::Found {
            warnings: warnings.to_vec(),
            names,
            size: (self.width, self.height),
            valid: self.valid,
            ms: [self.frame_ms.median, self.frame_ms.min],
            scores: self.scores.each_ref().map(Option::as_ref),
        }
    }

    /// The outcome in a few words.
    fn told(&self) -> String {
        let scores = match &self.scores[0] {
            Some(scores) => {
                format!("D1-all {}, bad-2 of valid {}", percent(scores.d1_all()), percent(scores.bad_of_valid(2)))
            }
            None => format!("{:.1} % valid, no truth", 100.0 * self.valid),
        };
        format!("{scores}, {:.0} ms", self.frame_ms.median)
    }
}

/// Every set with every variant, in the order in which they came.
fn sets(scenes: &[SceneFound]) -> Vec<SetFound> {
    let mut keys: Vec<(&str, &str)> = Vec::new();
    for scene in scenes {
        let key = (scene.set.as_str(), scene.variant.as_str());
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    let mut sets = Vec::new();
    for (set, variant) in keys {
        for (region, name) in REGIONS.into_iter().enumerate() {
            let of_set = scenes.iter().filter(|scene| (scene.set.as_str(), scene.variant.as_str()) == (set, variant));
            let scored: Vec<_> = of_set.filter_map(|scene| Some((scene, scene.scores[region].as_ref()?))).collect();
            if scored.is_empty() {
                continue;
            }
            let mut pooled = Scores::default();
            scored.iter().for_each(|(_, scores)| pooled.add(scores));
            let each: Vec<_> = scored.iter().map(|(_, scores)| Evaluation::from(*scores)).collect();
            let ms = scored.iter().map(|(scene, _)| scene.frame_ms.median).sum::<f64>();
            sets.push(SetFound {
                set: set.into(),
                variant: variant.into(),
                region: name,
                scenes: scored.len(),
                mean: Evaluation::mean(&each),
                pooled: Evaluation::from(&pooled),
                frame_ms: ms / scored.len() as f64,
            });
        }
    }
    sets
}

/// Columns of an evaluation.
const COLUMNS: [&str; 8] = ["density", "bad-1", "bad-2", "bad-2 of valid", "average", "A95", "D1-est", "D1-all"];

fn columns(e: &Evaluation) -> [String; 8] {
    [
        percent(e.density),
        percent(e.bad_1),
        percent(e.bad_2),
        percent(e.bad_2_of_valid),
        pixels(e.average_error),
        pixels(e.a95),
        percent(e.d1_est),
        percent(e.d1_all),
    ]
}

fn scene_table(scenes: &[SceneFound]) -> String {
    let [a, b, c, d, e, f, g, h] = COLUMNS;
    let header = ["scene", "variant", "region", "disp", a, b, c, d, e, f, g, h, "ms"];
    let mut rows = Vec::new();
    for scene in scenes {
        let name = format!("{}/{}", scene.set, scene.scene);
        let row = |region: &str, cells: [String; 8]| {
            let [a, b, c, d, e, f, g, h] = cells;
            let (disp, ms) = (scene.disparities.to_string(), format!("{:.1}", scene.frame_ms.median));
            [name.clone(), scene.variant.clone(), region.into(), disp, a, b, c, d, e, f, g, h, ms]
        };
        let evaluations = [&scene.evaluation, &scene.evaluation_noc];
        let scored = REGIONS.iter().zip(evaluations).filter_map(|(region, e)| Some(row(region, columns(e.as_ref()?))));
        let before = rows.len();
        rows.extend(scored);
        if rows.len() == before {
            rows.push(row("no truth", [(); 8].map(|()| "-".into())));
        }
    }
    report::table(header, rows, 3..13)
}

fn set_table(sets: &[SetFound]) -> String {
    if sets.is_empty() {
        return String::new();
    }
    let [a, b, c, d, e, f, g, h] = COLUMNS;
    let header = ["set", "variant", "region", "scenes", a, b, c, d, e, f, g, h, "D1-all pooled", "ms"];
    let rows = sets.iter().map(|set| {
        let [a, b, c, d, e, f, g, h] = columns(&set.mean);
        let (scenes, pooled, ms) = (set.scenes.to_string(), percent(set.pooled.d1_all), format!("{:.1}", set.frame_ms));
        [set.set.clone(), set.variant.clone(), set.region.into(), scenes, a, b, c, d, e, f, g, h, pooled, ms]
    });
    report::table(header, rows, 3..14)
}

/// An empty line before what follows.
fn separator(next: &str) -> &'static str {
    if next.is_empty() { "" } else { "\n" }
}

/// What is submitted of a scene.
struct Files {
    map: PathBuf,
    format: Format,
    time: Option<PathBuf>,
}

impl Submission {
    /// The folder of a variant, one of its own if there are several.
    fn folder_of(&self, bench: &Bench, variant: &Variant) -> PathBuf {
        match bench.variants.len() {
            1 => self.folder.clone(),
            _ => self.folder.join(file_name(&variant.label)),
        }
    }

    /// The files of a scene as the benchmark wants them; `sparse`: whether its map has holes.
    fn files(&self, bench: &Bench, scene: &Scene, variant: &Variant, sparse: bool) -> Files {
        let folder = self.folder_of(bench, variant);
        let (set, method) = (folder.join(&scene.set), &self.method);
        let kitti = |map| Files { map, format: Format::Kitti, time: None };
        let with_time = |map, time| Files { map, format: Format::Pfm, time: Some(time) };
        match bench.layout {
            Layout::Kitti2015 => kitti(set.join("disp_0").join(format!("{}.png", scene.name))),
            Layout::Kitti2012 => kitti(set.join(format!("{}.png", scene.name))),
            Layout::Middlebury => {
                // A map with holes has a name of its own.
                let suffix = if sparse { "_s" } else { "" };
                let folder = set.join(&scene.name);
                with_time(folder.join(format!("disp0{method}{suffix}.pfm")), folder.join(format!("time{method}.txt")))
            }
            // For the other layouts it was refused.
            Layout::Eth3d | Layout::Vkitti2 | Layout::Manifest => {
                let folder = folder.join("low_res_two_view");
                with_time(folder.join(format!("{}.pfm", scene.name)), folder.join(format!("{}.txt", scene.name)))
            }
        }
    }

    /// Writes them.
    fn write(
        &self,
        bench: &Bench,
        scene: &Scene,
        variant: &Variant,
        map: &DisparityMap,
        found: &SceneFound,
        params: &Params,
    ) -> Result<Vec<Known>> {
        let files = self.files(bench, scene, variant, map.data.contains(&DisparityMap::INVALID));
        let mut written = vec![put(&files.map, &output::encode(files.format, map, None, None, params)?)?];
        let Some(time) = files.time else { return Ok(written) };
        let seconds = found.frame_ms.median / 1e3;
        let text = match bench.layout {
            Layout::Eth3d => format!("runtime {seconds:.6}\n"),
            _ => format!("{seconds:.6}\n"),
        };
        written.push(put(&time, text.as_bytes())?);
        Ok(written)
    }
}

/// A label as a part of a file's name.
fn file_name(label: &str) -> String {
    label.chars().map(|c| if c.is_ascii_alphanumeric() || "-_".contains(c) { c } else { '_' }).collect()
}

/// Writes a file that belongs to a result.
fn put(path: &Path, bytes: &[u8]) -> Result<Known> {
    Ok(Known::new(path, output::write_in_folder(path, bytes)?))
}

/// The name of a picture of the report.
fn picture_name(found: &SceneFound, kind: &str) -> String {
    let of = file_name(&format!("{}_{}", found.set, found.scene));
    format!("{:04}_{of}_{kind}.png", found.numbers[0])
}

/// Writes the pictures of a scene with a variant, with the first variant those of the scene, too.
fn write_pictures(
    report: &Path,
    found: &SceneFound,
    loaded: &Loaded,
    estimate: &DisparityMap,
    range: (i32, i32),
    is_first: bool,
) -> Result<Vec<Known>> {
    let folder = report.join(PICTURES);
    let put =
        |kind: &str, picture: &RgbImage| put(&folder.join(picture_name(found, kind)), &output::png(&scaled(picture))?);
    let mut written = Vec::new();
    if is_first {
        written.push(put("input", &output::drawn(&loaded.left))?);
        if let Some(truth) = &loaded.truth {
            written.push(put("truth", &output::truth_picture(&thinned(&truth.map)?, range))?);
        }
    }
    let number = found.numbers[1];
    written.push(put(&format!("estimate{number}"), &output::picture(estimate, range))?);
    // Occluded pixels are half as bright.
    if let Some(truth) = loaded.noc.as_ref().or(loaded.truth.as_ref()) {
        written.push(put(&format!("errors{number}"), &truth.error_picture(&estimate.into())?)?);
    }
    Ok(written)
}

/// The tables of a report that show its pictures, one a scene.
fn picture_tables(scenes: &[SceneFound]) -> Result<String> {
    let mut text = String::new();
    for (i, found) in scenes.iter().enumerate() {
        let has_truth = found.scores[0].is_some();
        let shown = |file: &str, kind: &str| format!("![{kind}]({PICTURES}/{})", picture_name(found, file));
        if i == 0 || scenes[i - 1].numbers[0] != found.numbers[0] {
            let truth = if has_truth { shown("truth", "truth") } else { "none".into() };
            write!(text, "\n### {}/{}\n\n", escaped(&found.set), escaped(&found.scene))?;
            let size = format!("{} x {}", found.width, found.height);
            write!(text, "| input, {size} | truth |\n|---|---|\n| {} | {truth} |\n\n", shown("input", "input"))?;
            write!(text, "| setting | estimate | errors |\n|---|---|---|\n")?;
        }
        let [estimate, errors] = ["estimate", "errors"].map(|kind| {
            let file = format!("{kind}{}", found.numbers[1]);
            shown(&file, &file)
        });
        let errors = if has_truth { errors } else { String::new() };
        writeln!(text, "| {}: {} | {estimate} | {errors} |", escaped(&found.variant), found.told())?;
    }
    Ok(text)
}

/// Writes report.md and results.json.
fn write_report(folder: &Path, found: &Found) -> Result<()> {
    let mut text = String::from("# Scores of a data set\n\n");
    writeln!(text, "{}\n", escaped(&format!("{}, {} ({}).", found.adapter, found.backend, found.driver)))?;
    text += "Figures are defined in docs/EVALUATION.md; ms are of a frame: upload, kernels, readback. \"noc\" is without \
                 occluded pixels. \"pooled\" is over the pixels of all scenes together, the others are means of the scenes.\n";
    if !found.failures.is_empty() {
        text += "\n## Failures\n\n";
        for Failure { scene, variant, error } in &found.failures {
            let variant = variant.iter().map(|variant| format!(", {variant}")).collect::<String>();
            writeln!(text, "- {}: {}", escaped(&format!("{scene}{variant}")), escaped(error))?;
        }
    }
    for (title, table) in [("Sets", set_table(&found.sets)), ("Scenes", scene_table(&found.scenes))] {
        if !table.is_empty() {
            write!(text, "\n## {title}\n\n{table}")?;
        }
    }
    text += "\n## Pictures\n\nTurbo colours over the range searched: red is near, blue is far, black is unknown or invalid. \
                 Errors in KITTI's colours, holes filled: blue up to 3 px or 5 %, then yellow to red; half as bright where occluded.\n";
    text += &picture_tables(&found.scenes)?;
    output::write_in_folder(&folder.join(RESULTS), terminal::pretty_json(found)?.as_bytes())?;
    output::write_in_folder(&folder.join(REPORT), text.as_bytes()).map(drop)
}

/// At most [`PICTURE`] pixels wide, so that a sparse map can still be seen: each pixel takes the first value of its
/// block.
fn thinned(map: &FloatMap) -> Result<FloatMap> {
    let (width, height) = (map.width() as usize, map.height() as usize);
    let new_width = width.min(PICTURE as usize);
    let new_height = (height * new_width / width).max(1);
    let block = |at: usize, old: usize, new: usize| at * old / new..(at + 1) * old / new;
    let value = |x: usize, y: usize| {
        let rows = block(y, height, new_height);
        let mut values = rows.flat_map(|row| &map.data()[row * width..][block(x, width, new_width)]);
        values.find(|value| value.is_finite()).copied().unwrap_or(f32::NAN)
    };
    let values = (0..new_height).flat_map(|y| (0..new_width).map(move |x| (x, y))).map(|(x, y)| value(x, y)).collect();
    Ok(FloatMap::new(new_width as u32, new_height as u32, values)?)
}

/// At most [`PICTURE`] pixels wide.
fn scaled(picture: &RgbImage) -> RgbImage {
    let (width, height) = picture.dimensions();
    if width <= PICTURE {
        return picture.clone();
    }
    let height = (u64::from(height) * u64::from(PICTURE) / u64::from(width)).max(1) as u32;
    imageops::resize(picture, PICTURE, height, FilterType::Triangle)
}

/// A text in a line or a cell of Markdown, as it is.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for c in plain(text).chars() {
        match c {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            _ => {
                if "\\`*_[]|#".contains(c) {
                    escaped.push('\\');
                }
                escaped.push(c);
            }
        }
    }
    escaped
}
