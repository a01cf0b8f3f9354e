//! `sweep` and `compare`: maps of one pair with several settings, on one sheet and in one table.

mod sheet;

use super::energy::{self, EnergyReport};
use super::network;
use super::outcome::Outcome;
use super::variants::{self, MAX_MAPS, Variant, in_words};
use crate::args::{self, CompareArgs, DeviceArgs, InputArgs, StudyArgs};
use crate::engine::compute::{self, Cameras, EngineNames, FrameMs, RangeFinder};
use crate::engine::diagnosis::{self, Finding};
use crate::engine::output_files::{self, MapFolder, file_name};
use crate::engine::pair::Pair;
use crate::engine::{adapter, images, places};
use crate::terminal::{self, Progress, table, warnings};
use anyhow::{Context as _, Result, bail, ensure};
use gpu_stereo::backend::Engine;
use gpu_stereo::files::encoders::{Look, SheetFormat};
use gpu_stereo::files::images::ImagePair;
use gpu_stereo::files::masks::MaskFiles;
use gpu_stereo::files::outputs::Output;
use gpu_stereo::files::{encoders, outputs};
use gpu_stereo::{Image, Params};
use serde::Serialize;
use sheet::{Order, Sheet, SheetPlan};
use std::path::PathBuf;

/// Frames per map after a warm-up. What takes long is computed once.
const REPEAT: u32 = 5;
const TILE_WIDTHS: std::ops::RangeInclusive<i64> = 16..=4096;

/// A study, ready to start.
struct Study {
    left: PathBuf,
    right: PathBuf,
    masks: MaskFiles,
    input: InputArgs,
    cameras: Cameras,
    maps: Option<MapFolder>,
    variants: Vec<Variant>,
    /// The settings that all have in common.
    common: String,
    order: Order,
    tile_width: Option<u32>,
    look: Look,
    device: DeviceArgs,
    repeat: Option<u32>,
    outputs: Vec<Output<SheetFormat>>,
    json: bool,
    quiet: bool,
}

/// Maps for every combination of values.
pub fn sweep(args: StudyArgs) -> Result<Outcome> {
    report(&resolve_sweep(args)?)
}

/// Maps of several variants.
pub fn compare(args: CompareArgs) -> Result<Outcome> {
    report(&resolve_compare(args)?)
}

fn report(study: &Study) -> Result<Outcome> {
    let report = study.run()?;
    study.print(&report)?;
    Ok(Outcome::Done)
}

/// A combination of every value of the options that were given several.
fn resolve_sweep(typed: StudyArgs) -> Result<Study> {
    let given: Vec<(&str, Vec<&str>)> =
        typed.settings.iter().map(|(name, values)| (name, values.split(',').collect())).collect();
    let count = given.iter().try_fold(1_usize, |count, (_, values)| count.checked_mul(values.len()));
    ensure!(
        count.is_some_and(|count| count <= MAX_MAPS),
        "the values make {} combinations, but at most {MAX_MAPS} are computed; give fewer values",
        count.map_or("countless".into(), |count| count.to_string())
    );
    let mut combinations: Vec<Vec<(&str, &str)>> = vec![Vec::new()];
    for (name, values) in &given {
        let with = |combination: &Vec<_>, value| [&combination[..], &[(*name, value)]].concat();
        combinations = combinations.iter().flat_map(|c| values.iter().map(|value| with(c, *value))).collect();
    }
    let axes: Vec<_> = given.iter().filter(|(_, values)| values.len() > 1).collect();
    let order = match axes[..] {
        [_, (_, columns)] => Order::Columns(columns.len() as u32),
        _ => Order::Wrapped,
    };
    let variants = combinations.into_iter().map(|settings| {
        let on_axes = settings.iter().filter(|(name, _)| axes.is_empty() || axes.iter().any(|(axis, _)| axis == name));
        let label = in_words(on_axes.copied());
        let params = args::params(settings.iter().copied())?;
        let settings = settings.into_iter().map(|(name, value)| (name.into(), value.into())).collect();
        Ok(Variant { label, settings, params })
    });
    let variants = variants.collect::<Result<_>>()?;
    let common = given.iter().filter(|(_, values)| values.len() == 1 && !axes.is_empty());
    let common = in_words(common.map(|(name, values)| (*name, values[0])));
    resolve(&typed, variants, common, order, "sweep.png")
}

/// The variants that were given.
fn resolve_compare(typed: CompareArgs) -> Result<Study> {
    let CompareArgs { variants, study } = typed;
    let common: Vec<_> = study.settings.iter().collect();
    let variants = variants::named(&variants, &common)?;
    resolve(&study, variants, in_words(common.into_iter()), Order::Wrapped, "compare.png")
}

/// What `sweep` and `compare` have in common.
fn resolve(typed: &StudyArgs, mut variants: Vec<Variant>, common: String, order: Order, name: &str) -> Result<Study> {
    network::give(&typed.network, variants.iter_mut().map(|variant| &mut variant.params))?;
    let given = variants.iter().map(|Variant { settings, params, .. }| {
        let names: Vec<_> = settings.iter().map(|(name, _)| name.as_str()).collect();
        (names, params)
    });
    let given: Vec<_> = given.collect();
    given.iter().try_for_each(|(given, _)| args::ensure_disparities(given))?;
    adapter::ensure_consistent(&typed.device)?;
    let repeat = typed.repeat.as_ref().map(args::repeat).transpose()?;
    let tile_width = typed.tile_width.as_ref().map(|given| {
        let allowed = TILE_WIDTHS.contains(&given.value).then_some(given.value as u32);
        allowed.with_context(|| {
            let (least, most) = (TILE_WIDTHS.start(), TILE_WIDTHS.end());
            format!("--tile-width is {}, but must be from {least} to {most} px; 320 is usual", given.text)
        })
    });
    let tile_width = tile_width.transpose()?;
    let masks = MaskFiles::resolve(typed.masks.mask_in.as_deref())?;
    let (Pair { left, right }, input) = images::given(&typed.left, typed.right.as_deref(), &typed.input)?;
    let cameras = Cameras::resolve(&typed.cameras)?;
    let maps = MapFolder::resolve(&typed.maps, &typed.look)?;
    let formats = MapFolder::formats(maps.as_ref());
    cameras.ensure_fit(output_files::asks_for_depth(formats), typed.look.scale_bar)?;
    output_files::ensure_rectified(formats, &cameras)?;
    let images = [left.as_path(), &right];
    let others = masks.paths().chain(cameras.files()).chain(typed.network.weights.as_deref());
    let inputs: Vec<_> = images.into_iter().chain(others).collect();
    let outputs = output_files::resolve_sheet(typed.output.as_deref().unwrap_or(name.as_ref()), &inputs)?;
    args::report_unused(&given);
    if let Some(maps) = &maps {
        let files = (1..).zip(&variants).map(|(place, v)| maps.files(&map_name(place, v, variants.len()), &v.params));
        let files = files.collect::<Result<Vec<_>>>()?.concat();
        places::ensure_apart(files.iter().map(PathBuf::as_path), inputs.iter().copied())?;
    }
    Ok(Study {
        left,
        right,
        masks,
        input,
        cameras,
        maps,
        variants,
        common,
        order,
        tile_width,
        look: typed.look.look(),
        device: typed.device.clone(),
        repeat,
        outputs,
        json: typed.json,
        quiet: typed.quiet,
    })
}

/// The range of colours: every disparity that any of the settings search.
fn range(of: &[Params]) -> (i32, i32) {
    let ranges = of.iter().map(encoders::searched);
    ranges.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or_default()
}

/// The name of a variant's map in the folder of `--maps`: its number, which makes it unique, and the beginning of its label.
fn map_name(place: usize, variant: &Variant, of: usize) -> PathBuf {
    let digits = of.to_string().len();
    let label: String = file_name(&variant.label).chars().take(80).collect();
    format!("{place:0digits$}_{label}").into()
}

/// The results of a study; `--json` prints them as they are.
#[derive(Serialize)]
struct StudyReport {
    #[serde(flatten)]
    names: EngineNames,
    width: u32,
    height: u32,
    variants: Vec<VariantReport>,
    warnings: Vec<String>,
    #[serde(serialize_with = "terminal::paths")]
    outputs: Vec<PathBuf>,
}

/// The results of a variant.
#[derive(Serialize)]
struct VariantReport {
    label: String,
    #[serde(serialize_with = "variants::settings")]
    settings: Vec<(String, String)>,
    min_disparity: i32,
    disparities: u32,
    valid: f64,
    frame_ms: FrameMs,
    energy: Option<EnergyReport>,
    peak_device_bytes: u64,
}

impl VariantReport {
    fn range(&self) -> String {
        let last = self.min_disparity.saturating_add_unsigned(self.disparities) - 1;
        format!("{} to {last} px", self.min_disparity)
    }

    fn ms(&self) -> String {
        format!("{:.1}", self.frame_ms.median)
    }

    fn percent(&self) -> String {
        format!("{:.1} %", 100.0 * self.valid)
    }

    /// The text below the map.
    fn note(&self) -> String {
        format!("{} ms, {:.0} % valid", self.ms(), 100.0 * self.valid)
    }
}

impl Study {
    /// Computes every map and writes the sheet.
    fn run(&self) -> Result<StudyReport> {
        let ImagePair { left, right, doubts, .. } = images::read_pair(&self.left, &self.right, &self.input)?;
        doubts.iter().for_each(|doubt| warnings::warn(doubt));
        let mut fitted = Params::sgm(1); // any: all variants have the cameras in common
        let needs_depth = self.maps.as_ref().is_some_and(MapFolder::needs_depth) || self.look.scale_bar;
        self.cameras.fit(&mut fitted, [left.width(), left.height()], needs_depth)?;
        let evidence = diagnosis::evidence(&left, &right, &fitted)?;
        let masks = images::reported(self.masks.read_for(&left)?);
        let (mut engine, mut names): (Option<Engine>, _) = (None, EngineNames::default());
        let mut sheet = None;
        let mut variants = Vec::new();
        let found = self.with_ranges([&left, &right], &fitted)?;
        let (first, last) = range(&found);
        let progress = Progress::new(self.variants.len(), self.quiet);
        let warn = |text: &str| warnings::warn_by(text, |line| progress.message(line));
        for ((place, Variant { label, settings, .. }), mut params) in (1..).zip(&self.variants).zip(found) {
            progress.begin(label);
            params.masks = masks.clone();
            (params.rectify, params.depth) = (fitted.rectify.clone(), fitted.depth);
            output_files::want(&mut params, MapFolder::formats(self.maps.as_ref()));
            energy::want(&mut params, self.json);
            let context = || label.clone();
            let open = |params: &Params| compute::again(&mut engine, &self.device, &left, params).map(drop);
            let ((), params) = &energy::opened(&params, open).with_context(context)?;
            let Some(ready) = &engine else { bail!("{label}: there is nothing to compute with") };
            let repeat = self.repeat.or_else(|| ready.is_quick(params).then_some(REPEAT));
            names.add(ready.names([params]).into());
            if sheet.is_none() {
                let left = images::rectified(&left, params, 0)?;
                sheet = Some(self.blank(ready, &left, repeat, (first, last))?);
            }
            let show = |share| progress.share(label, share);
            let mut frames =
                compute::frames(ready, &left, &right, params, false, repeat, &show).with_context(context)?;
            let energy = EnergyReport::new(&left, &right, &frames.matched, params)?;
            if let Some(maps) = &self.maps {
                let name = map_name(place, &self.variants[place - 1], self.variants.len());
                self.cameras.cut(&mut frames.matched);
                maps.write(&name, &frames.matched, (&left, Some(&right)), params).with_context(context)?;
            }
            let (map, times) = (frames.matched.map, frames.times);
            match evidence.finding(&params.searched()) {
                Some(finding @ Finding::Range { .. }) => warn(&format!("{label}: {finding}")),
                Some(finding) => warn(&finding.to_string()), // of all variants
                None => {}
            }
            let found = VariantReport {
                label: label.clone(),
                settings: settings.clone(),
                min_disparity: params.min_disparity,
                disparities: params.disparities,
                valid: map.valid_fraction(),
                frame_ms: times,
                energy,
                peak_device_bytes: ready.device_bytes(),
            };
            if let Some(sheet) = &mut sheet {
                sheet.tile(place, &encoders::picture(&map, (first, last), self.look.colors), &found.note());
            }
            progress.done(&format!("{}: {}", found.label, found.note()));
            variants.push(found);
        }
        let Some(sheet) = sheet else {
            bail!("there is nothing to compute; give a setting");
        };
        outputs::write_sheet(&self.outputs, &sheet.finish())?;
        let sheets = self.outputs.iter().map(|output| output.path.clone());
        let outputs = sheets.chain(self.maps.iter().map(|maps| maps.folder.clone())).collect();
        let (width, height, warnings) = (left.width(), left.height(), warnings::all());
        Ok(StudyReport { names, width, height, variants, warnings, outputs })
    }

    fn settings(&self) -> impl Iterator<Item = &Params> {
        self.variants.iter().map(|variant| &variant.params)
    }

    /// The settings of all variants, with the range that the pair needs where they leave it to the pair.
    fn with_ranges(&self, pair: [&Image; 2], fitted: &Params) -> Result<Vec<Params>> {
        let mut all: Vec<_> = self.settings().cloned().collect();
        if !self.variants.iter().any(|variant| variant.range().is_found()) {
            return Ok(all);
        }
        let coarse = RangeFinder::new(&self.device).coarse(pair, fitted)?;
        let held = output_files::held(MapFolder::formats(self.maps.as_ref()).iter().copied());
        for (place, (variant, params)) in (1..).zip(self.variants.iter().zip(&mut all)) {
            let doubt = coarse.set(variant.range(), held.as_ref(), params).with_context(|| variant.label.clone())?;
            doubt.iter().for_each(|doubt| warnings::warn(doubt));
            if let Some(maps) = &self.maps {
                maps.files(&map_name(place, variant, self.variants.len()), params)?; // refuses what they cannot hold
            }
        }
        Ok(all)
    }

    /// The sheet without maps.
    fn blank(&self, engine: &Engine, left: &Image, repeat: Option<u32>, range: (i32, i32)) -> Result<Sheet> {
        let adapter = engine.names(self.settings()).adapter;
        let name = self.left.file_name().unwrap_or_default().to_string_lossy();
        let captions: Vec<_> = [name.into()].into_iter().chain(self.variants.iter().map(|v| v.label.clone())).collect();
        let times = match repeat {
            Some(frames @ 2..) => format!("times: median of {frames} frames after a warm-up, {adapter}"),
            Some(_) => format!("times: one frame after a warm-up, {adapter}"),
            None => format!("times: one frame, {adapter}"),
        };
        let legend = ["black: no disparity".to_owned(), self.common.clone(), times];
        let legend: Vec<_> = legend.into_iter().filter(|line| !line.is_empty()).collect();
        let plan = SheetPlan::new((left.width(), left.height()), &captions, &legend, self.order, self.tile_width)?;
        Ok(Sheet::new(plan, &images::drawn(left), range, self.look.colors))
    }

    /// Prints what was found.
    fn print(&self, found: &StudyReport) -> Result<()> {
        if self.json {
            return terminal::print_json(found);
        }
        if self.quiet {
            return Ok(());
        }
        if self.variants.iter().any(|variant| variant.range().is_found()) {
            let rows = found.variants.iter().map(|v| [v.label.clone(), v.range(), v.ms(), v.percent()]);
            return terminal::print(&table(["settings", "range", "ms", "valid"], rows, 1..4));
        }
        let rows = found.variants.iter().map(|v| [v.label.clone(), v.ms(), v.percent()]);
        terminal::print(&table(["settings", "ms", "valid"], rows, 1..3))
    }
}
