//! Study: maps of one pair with several settings, on one sheet and in one table: `sweep` and `compare`.

use crate::args::{Compare, DeviceArgs, InputArgs, StudyArgs};
use crate::diagnosis::{self, Finding};
use crate::mask::MaskFiles;
use crate::output::{self, Output, SheetFormat};
use crate::progress::Progress;
use crate::report::{self, FrameMs};
use crate::resolve;
use crate::run::Engine;
use crate::sheet::{Layout, Order, Sheet};
use crate::views::{self, Views};
use crate::{terminal, tips, warnings};
use anyhow::{Context as _, Result, bail, ensure};
use gpu_stereo::{Image, Params, Preset};
use serde::{Serialize, Serializer};
use std::path::PathBuf;

/// Frames of a map on an adapter, after a warm-up. The reference computes one: its time is no one's concern.
const REPEAT: u32 = 5;
/// The most maps of a sheet.
const MAX_MAPS: usize = 1000;
const TILE_WIDTHS: std::ops::RangeInclusive<i64> = 16..=4096;

/// A study, ready to start.
pub struct Study {
    left: PathBuf,
    right: PathBuf,
    masks: MaskFiles,
    input: InputArgs,
    variants: Vec<Variant>,
    /// The settings that all have in common.
    common: String,
    order: Order,
    tile_width: Option<u32>,
    device: DeviceArgs,
    repeat: Option<u32>,
    outputs: Vec<Output<SheetFormat>>,
    json: bool,
    quiet: bool,
}

/// One of the settings that are compared.
pub struct Variant {
    /// What is its own.
    pub label: String,
    /// As they were given, in the order in which they count.
    pub settings: Vec<(String, String)>,
    /// What they make.
    pub params: Params,
}

/// A combination of every value of the options that were given several.
pub fn resolve_sweep(args: StudyArgs) -> Result<Study> {
    let given: Vec<(&str, Vec<&str>)> =
        args.settings.iter().map(|(name, values)| (name, values.split(',').collect())).collect();
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
        let label = told(on_axes.copied());
        let params = resolve::params(settings.iter().copied())?;
        let settings = settings.into_iter().map(|(name, value)| (name.into(), value.into())).collect();
        Ok(Variant { label, settings, params })
    });
    let variants = variants.collect::<Result<_>>()?;
    let common = given.iter().filter(|(_, values)| values.len() == 1 && !axes.is_empty());
    let common = told(common.map(|(name, values)| (*name, values[0])));
    resolve(&args, variants, common, order, "sweep.png")
}

/// The variants that were named.
pub fn resolve_compare(args: Compare) -> Result<Study> {
    let Compare { variants, study } = args;
    let common: Vec<_> = study.settings.iter().collect();
    let variants = named(&variants, &common)?;
    resolve(&study, variants, told(common.into_iter()), Order::Wrapped, "compare.png")
}

/// The variants that were named, each with what all have in common.
pub fn named(variants: &[String], common: &[(&str, &str)]) -> Result<Vec<Variant>> {
    ensure!(
        variants.len() <= MAX_MAPS,
        "--variants has {} variants, but at most {MAX_MAPS} are computed; give fewer",
        variants.len()
    );
    let variants = variants.iter().map(|text| {
        let context = || format!("--variants has {text:?}");
        let own = text.split('+').map(setting).collect::<Result<Vec<_>>>().with_context(context)?;
        let label = told(own.iter().map(|(name, value)| (*name, value.as_str())));
        let common = common.iter().map(|(name, value)| (*name, (*value).to_owned()));
        let settings: Vec<_> = common.chain(own).map(|(name, value)| (name.to_owned(), value)).collect();
        let params = resolve::params(settings.iter().map(|(name, value)| (name.as_str(), value.as_str())));
        Ok(Variant { label, params: params.with_context(context)?, settings })
    });
    variants.collect()
}

/// A part of a variant: `option=value`, or a word that tells its option.
fn setting(part: &str) -> Result<(&str, String)> {
    if let Some((name, value)) = part.split_once('=') {
        return Ok((name, value.into()));
    }
    let has = |words: &[(&str, &str)], word| words.iter().any(|(known, _)| *known == word);
    if has(Preset::NAMES, part) {
        return Ok(("preset", part.into()));
    }
    for option in Params::OPTIONS {
        if ["method", "cost"].contains(&option.name) && has(option.values, part) {
            return Ok((option.name, part.into()));
        }
        if option.name == part && has(option.values, "on") {
            return Ok((part, "on".into()));
        }
    }
    let meant = tips::word(part).map(|word| format!("take {word}, or ")).unwrap_or_default();
    bail!(
        "{part:?} is neither a preset, a method or a cost nor an option that can be on; {meant}give OPTION=VALUE, several \
         joined by +, and see gpu-stereo --help"
    )
}

/// Settings in words.
pub fn told<'a>(settings: impl Iterator<Item = (&'a str, &'a str)>) -> String {
    settings.map(|(name, value)| format!("{name} {value}")).collect::<Vec<_>>().join(", ")
}

/// What both have in common.
fn resolve(args: &StudyArgs, variants: Vec<Variant>, common: String, order: Order, name: &str) -> Result<Study> {
    let given = variants.iter().map(|Variant { settings, params, .. }| {
        let names: Vec<_> = settings.iter().map(|(name, _)| name.as_str()).collect();
        (names, params)
    });
    let given: Vec<_> = given.collect();
    given.iter().try_for_each(|(given, _)| resolve::ensure_disparities(given))?;
    resolve::ensure_adapter(&args.device)?;
    let repeat = args.repeat.as_ref().map(resolve::repeat).transpose()?;
    let tile_width = args.tile_width.as_ref().map(|given| {
        let allowed = TILE_WIDTHS.contains(&given.value).then_some(given.value as u32);
        allowed.with_context(|| {
            let (least, most) = (TILE_WIDTHS.start(), TILE_WIDTHS.end());
            format!("--tile-width is {}, but must be from {least} to {most} px; 320 is usual", given.text)
        })
    });
    let tile_width = tile_width.transpose()?;
    let masks = MaskFiles::resolve(args.masks.mask_in.as_deref())?;
    let inputs: Vec<_> = [args.left.as_path(), &args.right].into_iter().chain(masks.paths()).collect();
    let outputs = output::resolve_sheet(args.output.as_deref().unwrap_or(name.as_ref()), &inputs)?;
    resolve::tell_unused(&given);
    Ok(Study {
        left: args.left.clone(),
        right: args.right.clone(),
        masks,
        input: args.input.clone(),
        variants,
        common,
        order,
        tile_width,
        device: args.device.clone(),
        repeat,
        outputs,
        json: args.json,
        quiet: args.quiet,
    })
}

/// What a study found; `--json` prints it as it is.
#[derive(Serialize)]
pub struct StudyReport {
    adapter: String,
    backend: String,
    driver: String,
    width: u32,
    height: u32,
    variants: Vec<Found>,
    warnings: Vec<String>,
    #[serde(serialize_with = "report::paths")]
    outputs: Vec<PathBuf>,
}

/// What was found of a variant.
#[derive(Serialize)]
struct Found {
    label: String,
    #[serde(serialize_with = "settings")]
    settings: Vec<(String, String)>,
    min_disparity: i32,
    disparities: u32,
    valid: f64,
    frame_ms: FrameMs,
    peak_device_bytes: u64,
}

/// Options and values as an object; of an option given twice the last counts.
pub fn settings<S: Serializer>(settings: &[(String, String)], serializer: S) -> Result<S::Ok, S::Error> {
    let map: serde_json::Map<_, _> =
        settings.iter().map(|(name, value)| (name.clone(), value.as_str().into())).collect();
    map.serialize(serializer)
}

impl Found {
    fn ms(&self) -> String {
        format!("{:.1}", self.frame_ms.median)
    }

    fn percent(&self) -> String {
        format!("{:.1} %", 100.0 * self.valid)
    }

    /// What stands below the map.
    fn note(&self) -> String {
        format!("{} ms, {:.0} % valid", self.ms(), 100.0 * self.valid)
    }
}

impl Study {
    /// Computes every map and writes the sheet.
    pub fn run(&self) -> Result<StudyReport> {
        let Views { left, right, doubts, .. } = views::read_pair(&self.left, &self.right, &self.input)?;
        doubts.iter().for_each(|doubt| warnings::warn(doubt));
        let evidence = diagnosis::evidence(&left, &right, &Params::sgm(1))?; // no variant rectifies
        let masks = self.masks.read_for(&left)?;
        let mut engine: Option<Engine> = None;
        let mut sheet = None;
        let mut variants = Vec::new();
        let (first, last) = self.range();
        let progress = Progress::new(self.variants.len(), self.quiet);
        let warn = |text: &str| warnings::warn_by(text, |line| progress.tell(line));
        for (place, Variant { label, settings, params }) in (1..).zip(&self.variants) {
            progress.begin(label);
            let mut params = params.clone();
            params.masks = masks.clone();
            let params = &params;
            let context = || label.clone();
            let ready = match engine.take() {
                None => Engine::open(&self.device, false, &left, params),
                Some(engine) => engine.again(&left, params),
            };
            let ready = engine.insert(ready.with_context(context)?);
            let repeat = self.repeat.or_else(|| (ready.device_bytes() > 0).then_some(REPEAT));
            if sheet.is_none() {
                sheet = Some(self.blank(ready, &left, repeat, (first, last))?);
            }
            let frames = ready.frames(&left, &right, params, false, repeat).with_context(context)?;
            let (map, times) = (frames.matched.map, frames.times);
            match evidence.finding(&params.searched()) {
                Some(finding @ Finding::Range { .. }) => warn(&format!("{label}: {finding}")),
                Some(finding) => warn(&finding.to_string()), // of all variants
                None => {}
            }
            let found = Found {
                label: label.clone(),
                settings: settings.clone(),
                min_disparity: params.min_disparity,
                disparities: params.disparities,
                valid: map.valid_fraction(),
                frame_ms: times,
                peak_device_bytes: ready.device_bytes(),
            };
            if let Some(sheet) = &mut sheet {
                sheet.tile(place, &output::picture(&map, (first, last)), &found.note());
            }
            progress.done(&format!("{}: {}", found.label, found.note()));
            variants.push(found);
        }
        let (Some(engine), Some(sheet)) = (engine, sheet) else {
            bail!("there is nothing to compute; give a setting");
        };
        output::write_sheet(&self.outputs, &sheet.finish())?;
        let (adapter, backend, driver) = engine.names();
        let outputs = self.outputs.iter().map(|output| output.path.clone()).collect();
        let (width, height, warnings) = (left.width(), left.height(), warnings::all());
        Ok(StudyReport { adapter, backend, driver, width, height, variants, warnings, outputs })
    }

    /// The range of colours: every disparity that any variant searches.
    fn range(&self) -> (i32, i32) {
        let ranges = self.variants.iter().map(|variant| output::searched(&variant.params));
        ranges.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or_default()
    }

    /// The sheet without maps.
    fn blank(&self, engine: &Engine, left: &Image, repeat: Option<u32>, range: (i32, i32)) -> Result<Sheet> {
        let (adapter, ..) = engine.names();
        let name = self.left.file_name().unwrap_or_default().to_string_lossy();
        let captions: Vec<_> = [name.into()].into_iter().chain(self.variants.iter().map(|v| v.label.clone())).collect();
        let times = match repeat {
            Some(frames @ 2..) => format!("times: median of {frames} frames after a warm-up, {adapter}"),
            Some(_) => format!("times: one frame after a warm-up, {adapter}"),
            None => format!("times: one frame, {adapter}"),
        };
        let legend = ["black: no disparity".to_owned(), self.common.clone(), times];
        let legend: Vec<_> = legend.into_iter().filter(|line| !line.is_empty()).collect();
        let layout = Layout::new((left.width(), left.height()), &captions, &legend, self.order, self.tile_width)?;
        Ok(Sheet::new(layout, &output::drawn(left), range))
    }

    /// Prints what was found.
    pub fn print(&self, found: &StudyReport) -> Result<()> {
        if self.json {
            return terminal::print_json(found);
        }
        if self.quiet {
            return Ok(());
        }
        let rows = found.variants.iter().map(|v| [v.label.clone(), v.ms(), v.percent()]);
        terminal::print(&report::table(["settings", "ms", "valid"], rows, 1..3))
    }
}
