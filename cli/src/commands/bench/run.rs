//! Run: computes, scores and writes one scene with one variant after the other.

use super::log::{BenchLog, Kept};
use super::report::{BenchReport, FailedScene, write_pictures};
use super::resolve::Bench;
use super::scene::{Loaded, SceneReport, load, settings};
use super::tables::sets;
use crate::commands::variants::Variant;
use crate::engine::compute::{self, Coarse, EngineNames, RangeFinder};
use crate::engine::known::KnownFile;
use crate::engine::output_files::{self, MapFolder};
use crate::engine::{adapter, disk};
use crate::terminal::{Progress, name, one_line, plain, warnings};
use anyhow::{Result, anyhow};
use gpu_stereo::backend::Engine;
use gpu_stereo::files::datasets::Scene;
use gpu_stereo::{Matched, Params};
use std::fmt::{self, Display, Formatter};

/// Computes everything.
pub fn run(bench: &Bench) -> Result<BenchReport> {
    adapter::ensure_there(&bench.device)?;
    let progress = Progress::new(bench.scenes.len() * bench.variants.len(), bench.quiet);
    let log = BenchLog::open(bench.report.as_deref(), bench.resume)?;
    let (engine, names) = (None, None);
    let finder = RangeFinder::new(&bench.device);
    let (scenes, failures) = (Vec::new(), Vec::new());
    let mut run = Run { bench, log: &log, progress, engine, finder, coarse: None, names, scenes, failures };
    for (number, scene) in (1..).zip(&bench.scenes) {
        run.scene(number, scene)?;
    }
    let Run { names, scenes, failures, .. } = run;
    let (names, sets) = (names.unwrap_or_default(), sets(&scenes));
    Ok(BenchReport { names, scenes, sets, failures, warnings: warnings::all() })
}

/// The state of a run.
struct Run<'a> {
    bench: &'a Bench,
    log: &'a BenchLog,
    progress: Progress,
    engine: Option<Engine>,
    finder: RangeFinder,
    /// The scene's coarse match, once a variant needed it.
    coarse: Option<Coarse>,
    names: Option<EngineNames>,
    scenes: Vec<SceneReport>,
    failures: Vec<FailedScene>,
}

/// A scene with a variant.
struct Task<'a> {
    scene: &'a Scene,
    variant: &'a Variant,
    /// Everything that determines the result except the contents of files.
    key: String,
    /// The numbers of scene and variant, from 1.
    numbers: [usize; 2],
    /// Whether no variant of the scene is done yet.
    is_first: bool,
    /// Warnings before the scene.
    warned: usize,
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

impl<'a> Run<'a> {
    /// A scene with all variants.
    fn scene(&mut self, number: usize, scene: &'a Scene) -> Result<()> {
        let (bench, log, label) = (self.bench, self.log, scene.label());
        self.progress.begin(&label);
        self.coarse = None;
        let mut is_first = true;
        let warned = warnings::all().len();
        let key = |place: usize| bench.key(number, place, scene);
        let kept = |place: usize| log.find(&label, &bench.variants[place].label, &key(place));
        let kept: Vec<Option<&Kept>> = (0..bench.variants.len()).map(kept).collect();
        let mut read = None;
        if !kept.iter().all(Option::is_some) {
            let inputs = log.inputs(scene.files());
            match load(scene, &bench.input, &bench.cameras, bench.needs_depth()) {
                Ok(loaded) => read = Some((inputs, loaded)),
                Err(error) => {
                    self.failed(&label, None, &error);
                    bench.variants.iter().for_each(|_| self.progress.done(&name(&label).to_string()));
                    return Ok(());
                }
            }
        }
        for (place, variant) in bench.variants.iter().enumerate() {
            let task = Task { scene, variant, key: key(place), numbers: [number, place + 1], is_first, warned };
            let done = match (kept[place], &read) {
                (Some(kept), _) => self.keep(&task, kept),
                (None, Some((inputs, loaded))) => self.compute(&task, inputs, loaded),
                (None, None) => continue, // all were kept
            };
            let told = format!("{}, {}", name(&label), plain(&variant.label));
            match done {
                Ok(report) => {
                    is_first = false;
                    self.progress.done(&format!("{told}: {}", report.in_words()));
                    self.scenes.push(SceneReport { numbers: task.numbers, ..report });
                }
                Err(error) => {
                    self.ensure_not_lasting(&error)?;
                    self.failed(&label, Some(variant), &error);
                    self.progress.done(&told);
                }
            }
        }
        Ok(())
    }

    fn failed(&mut self, scene: &str, variant: Option<&Variant>, error: &anyhow::Error) {
        let variant = variant.map(|variant| variant.label.clone());
        let error = one_line(&format!("{error:#}"));
        let of = variant.iter().map(|variant| format!(", {variant}")).collect::<String>();
        self.progress.message(&format!("failed: {}{}: {error}", name(scene), plain(&of)));
        self.failures.push(FailedScene { scene: scene.into(), variant, error });
    }

    /// Ends the run if results cannot be written any more, as on a full disk.
    fn ensure_not_lasting(&self, error: &anyhow::Error) -> Result<()> {
        let unwritten = error.downcast_ref().map(|Unwritten(error)| error);
        let Some(error) = unwritten.filter(|error| disk::is_lasting(error)) else { return Ok(()) };
        let (maps, all) = (self.scenes.len(), self.bench.scenes.len() * self.bench.variants.len());
        let advice = if self.bench.report.is_some() { ": --resume computes the rest" } else { "" };
        Err(anyhow!("{error:#}; {maps} of {all} maps were scored{advice}"))
    }

    /// What was found before.
    fn keep(&mut self, task: &Task<'_>, kept: &Kept) -> Result<SceneReport> {
        self.names.get_or_insert_default().add(kept.names.clone());
        kept.warnings.iter().for_each(|line| warnings::warn_by(line, |line| self.progress.message(line)));
        SceneReport::of_kept(task.scene, task.variant, kept)
    }

    /// Matches, scores and writes.
    fn compute(&mut self, task: &Task<'_>, inputs: &[KnownFile], loaded: &Loaded) -> Result<SceneReport> {
        let result = self.matched(task, loaded);
        let names = self.engine.as_ref().map(|engine| engine.names([&task.variant.params]).into());
        if let Some(names) = names.clone() {
            self.names.get_or_insert_default().add(names);
        }
        let (params, matched, report) = result?;
        loaded.warn(task.scene, task.variant, &params, &self.progress);
        let report = report.scored(loaded, &(&matched.map).into())?;
        let outputs = self.write(task, &report, loaded, &matched, &params).map_err(Unwritten)?;
        let found = report.kept(names.unwrap_or_default(), &warnings::all()[task.warned..]);
        let label = task.scene.label();
        let of = [&label, &task.variant.label, &task.key].map(String::as_str);
        self.log.keep(of, inputs, outputs, found).map_err(Unwritten)?;
        Ok(report)
    }

    /// The map of a scene, not scored yet.
    fn matched(&mut self, task: &Task<'_>, loaded: &Loaded) -> Result<(Params, Matched, SceneReport)> {
        let (settings, mut params) = settings(task.variant, loaded.disparities)?;
        output_files::want(&mut params, MapFolder::formats(self.bench.maps.as_ref()));
        (params.rectify, params.depth) = (loaded.rectify.clone(), loaded.camera);
        self.set_range(task, loaded, &mut params)?;
        let engine = compute::again(&mut self.engine, &self.bench.device, &loaded.left, &params)?;
        // On an adapter the first frame compiles.
        let repeat = self.bench.repeat.or_else(|| (engine.device_bytes() > 0).then_some(1));
        let (progress, label) = (&self.progress, task.scene.label());
        let show = |share| progress.share(&label, share);
        let frames = match compute::frames(engine, &loaded.left, &loaded.right, &params, false, repeat, &show) {
            Ok(frames) => frames,
            Err(error) => {
                self.engine = None; // the device may be lost
                return Err(error.into());
            }
        };
        let mut matched = frames.matched;
        self.bench.cameras.cut(&mut matched);
        let map = &matched.map;
        let report = SceneReport::new(task.scene, task.variant, &params, settings, frames.times);
        let (width, height, valid) = (map.width, map.height, map.valid_fraction());
        let report = SceneReport { width, height, valid, numbers: task.numbers, ..report };
        Ok((params, matched, report))
    }

    /// Sets the range of the settings, if the variant leaves it to the scene, whose coarse match all variants have in common.
    fn set_range(&mut self, task: &Task<'_>, loaded: &Loaded, params: &mut Params) -> Result<()> {
        let range = task.variant.range();
        if !range.is_found() {
            return Ok(());
        }
        let coarse = match self.coarse.take() {
            Some(coarse) => coarse,
            None => self.finder.coarse([&loaded.left, &loaded.right], params)?,
        };
        let held = self.bench.held(task.scene, task.variant);
        let doubt = self.coarse.insert(coarse).set(range, held.as_ref(), params)?;
        let label = task.scene.label();
        let warn = |doubt| warnings::warn_by(&format!("{label}: {doubt}"), |line| self.progress.message(line));
        doubt.into_iter().for_each(warn);
        Ok(())
    }

    /// Writes the files of a scene with a variant.
    fn write(
        &self,
        task: &Task<'_>,
        report: &SceneReport,
        loaded: &Loaded,
        matched: &Matched,
        params: &Params,
    ) -> Result<Vec<KnownFile>> {
        let mut written = Vec::new();
        if let Some(submission) = &self.bench.submission {
            written.extend(submission.write(task.scene, task.variant, &matched.map, report, params)?);
        }
        if let Some(folder) = &self.bench.report {
            written.extend(write_pictures(
                folder,
                report,
                loaded,
                &matched.map,
                (params, self.bench.look.colors),
                task.is_first,
            )?);
        }
        if let Some(maps) = &self.bench.maps {
            let name = self.bench.map_name(task.scene, task.variant);
            written.extend(maps.write(&name, matched, (&loaded.left, Some(&loaded.right)), params)?);
        }
        Ok(written)
    }
}
