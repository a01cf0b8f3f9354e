//! Resolve: the scenes and the variants, and that everything can be written.

use super::report::{PICTURES, REPORT, RESULTS};
use super::scene::settings;
use super::submission::Submission;
use crate::args::{self, BenchArgs, DeviceArgs, InputArgs};
use crate::commands::network;
use crate::commands::variants::{self, Variant, in_words};
use crate::engine::compute::Cameras;
use crate::engine::disk;
use crate::engine::output_files::{self, MapFolder, file_name};
use crate::engine::{adapter, places};
use crate::terminal::name;
use anyhow::{Result, bail, ensure};
use gpu_stereo::files::datasets::{DataSet, Scene};
use gpu_stereo::files::encoders::{self, Look};
use gpu_stereo::files::lists::absolute;
use gpu_stereo::files::weights::fingerprint;
use gpu_stereo::{FeatureNetwork, Params};
use std::collections::BTreeSet;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// A run over a data set, ready to start.
pub struct Bench {
    /// The layout of the data set.
    pub layout: DataSet,
    /// Its scenes.
    pub scenes: Vec<Scene>,
    /// What to compute for each.
    pub variants: Vec<Variant>,
    /// How the images are read.
    pub input: InputArgs,
    /// Where to compute.
    pub device: DeviceArgs,
    /// Frames after one warm-up, if they are given.
    pub repeat: Option<u32>,
    /// The folder of the report.
    pub report: Option<PathBuf>,
    /// The cameras of all pairs.
    pub cameras: Cameras,
    /// How maps are drawn.
    pub look: Look,
    /// Where maps go.
    pub maps: Option<MapFolder>,
    /// Where files to submit go.
    pub submission: Option<Submission>,
    /// Keep what an earlier run found.
    pub resume: bool,
    /// Print JSON.
    pub json: bool,
    /// Print nothing.
    pub quiet: bool,
}

/// Finds the scenes and checks what can be checked without computing.
pub fn resolve(typed: BenchArgs) -> Result<Bench> {
    let mut variants = resolve_variants(&typed)?;
    network::give(&typed.network, variants.iter_mut().map(|variant| &mut variant.params))?;
    let given = variants.iter().map(|v| (v.settings.iter().map(|(name, _)| name.as_str()).collect(), &v.params));
    args::report_unused(&given.collect::<Vec<_>>());
    adapter::ensure_consistent(&typed.device)?;
    let repeat = typed.repeat.as_ref().map(args::repeat).transpose()?;
    let scenes = scenes(typed.layout, &typed.dataset, &typed.only)?;
    ensure!(
        typed.input.split.is_none() || typed.layout == DataSet::Manifest,
        "--split is for images that hold both views, but those of this --layout are two; drop it, or use --layout manifest"
    );
    let submission = typed.submission.map(|folder| submission(folder, typed.method_name, typed.layout, variants.len()));
    let submission = submission.transpose()?;
    let cameras = Cameras::resolve(&typed.cameras)?;
    let maps = MapFolder::resolve(&typed.maps, &typed.look)?;
    let formats = MapFolder::formats(maps.as_ref());
    // Else the scenes may have cameras of their own.
    if cameras.are_known() || scenes.iter().all(|scene| scene.cameras.is_none()) {
        cameras.ensure_fit(output_files::asks_for_depth(formats), typed.look.scale_bar)?;
    }
    output_files::ensure_rectified(formats, &cameras)?;
    for folder in [typed.report.as_ref(), submission.as_ref().map(|s| &s.folder)].into_iter().flatten() {
        places::ensure_folder(folder)?;
    }
    ensure!(
        !typed.resume || typed.report.is_some(),
        "--resume needs the folder where the earlier run kept what it found; add --report FOLDER"
    );
    if typed.no_sync {
        disk::leave_to_the_system();
    }
    let bench = Bench {
        layout: typed.layout,
        scenes,
        variants,
        input: typed.input.of_many(),
        device: typed.device,
        repeat,
        report: typed.report,
        cameras,
        look: typed.look.look(),
        maps,
        submission,
        resume: typed.resume,
        json: typed.json,
        quiet: typed.quiet,
    };
    bench.ensure_outputs(typed.network.weights.as_deref())?;
    Ok(bench)
}

/// What to compute for each scene; no two are the same.
fn resolve_variants(typed: &BenchArgs) -> Result<Vec<Variant>> {
    let common: Vec<_> = typed.settings.iter().collect();
    if typed.variants.is_empty() {
        let settings = common.iter().map(|(name, value)| (String::from(*name), String::from(*value))).collect();
        let label = match in_words(common.iter().copied()) {
            text if text.is_empty() => "default".into(),
            text => text,
        };
        return Ok(vec![Variant { label, settings, params: args::params(common.iter().copied())? }]);
    }
    let variants = variants::named(&typed.variants, &common)?;
    for (i, variant) in variants.iter().enumerate() {
        if let Some(other) =
            variants[..i].iter().find(|other| other.params == variant.params && other.range() == variant.range())
        {
            bail!(
                "--variants has {:?} and {:?}, which are the same settings; name them once",
                other.label,
                variant.label
            );
        }
    }
    Ok(variants)
}

/// The scenes of a data set that `only` names.
fn scenes(layout: DataSet, dataset: &Path, only: &[String]) -> Result<Vec<Scene>> {
    let all = layout.scenes(dataset)?;
    let mut labels = BTreeSet::new();
    if let Some(label) = all.iter().map(Scene::label).find(|label| !labels.insert(label.clone())) {
        bail!("the data set has the scene {:?} twice; give each SET/NAME once", name(&label));
    }
    let (found, first) = (all.len(), all.first().map(Scene::label).unwrap_or_default());
    let is_wanted = |scene: &Scene| only.is_empty() || only.iter().any(|part| scene.label().contains(part));
    let scenes: Vec<_> = all.into_iter().filter(is_wanted).collect();
    ensure!(
        !scenes.is_empty(),
        "--only is {:?}, but none of the {found} scenes has that in its SET/NAME, such as {}; give a part of one",
        only.join(" "),
        name(&first)
    );
    Ok(scenes)
}

fn submission(folder: PathBuf, method: String, layout: DataSet, variants: usize) -> Result<Submission> {
    ensure!(
        !matches!(layout, DataSet::Vkitti2 | DataSet::Manifest),
        "--submission is {folder:?}, but there is no submission for this --layout; drop it, or use kitti2012, kitti2015, \
         middlebury or eth3d"
    );
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    ensure!(
        !method.is_empty() && method.chars().all(is_plain),
        "--method-name is {method:?}, but only letters, digits, - _ and . are allowed, since it becomes part of file names"
    );
    Ok(Submission { folder, method, layout, several: variants > 1 })
}

impl Bench {
    /// Every file can be written and can hold what it is to hold, and none is one of the data set's or the file of weights.
    fn ensure_outputs(&self, weights: Option<&Path>) -> Result<()> {
        let mut outputs = Vec::new();
        if let Some(folder) = &self.report {
            for name in [REPORT, RESULTS] {
                places::writable_place(&folder.join(name))?;
                outputs.push(folder.join(name));
            }
            places::make_folder(&folder.join(PICTURES), &folder.join(PICTURES))?;
        }
        if let Some(submission) = &self.submission {
            let mut folders = BTreeSet::new();
            for variant in &self.variants {
                ensure!(
                    folders.insert(submission.folder_of(variant)),
                    "--variants has {:?} and another variant whose folder would have the same name; run them one by one",
                    variant.label
                );
                for scene in &self.scenes {
                    let files = [false, true].map(|sparse| submission.files(scene, variant, sparse));
                    let (_, params) = settings(variant, scene.disparities()?)?;
                    encoders::ensure_range(files[0].format, &files[0].map, &params)?;
                    outputs.extend(files.into_iter().flat_map(|files| [Some(files.map), files.time]).flatten());
                }
            }
        }
        if let Some(maps) = &self.maps {
            for variant in &self.variants {
                for scene in &self.scenes {
                    let (_, params) = settings(variant, scene.disparities()?)?;
                    outputs.extend(maps.files(&self.map_name(scene, variant), &params)?);
                }
            }
        }
        let weights = weights.into_iter().chain(self.cameras.files());
        let inputs = self.scenes.iter().flat_map(Scene::files).chain(weights);
        places::ensure_apart(outputs.iter().map(PathBuf::as_path), inputs)
    }

    /// Whether anything is made from the depth, where there is one, and whether anything cannot be made without.
    pub fn needs_depth(&self) -> [bool; 2] {
        let needs = self.maps.as_ref().is_some_and(MapFolder::needs_depth);
        [needs || self.look.scale_bar, needs]
    }

    /// The disparities that all files of a scene with a variant can hold.
    pub fn held(&self, scene: &Scene, variant: &Variant) -> Option<RangeInclusive<i32>> {
        let submitted = self.submission.as_ref().map(|submission| submission.files(scene, variant, false).format);
        output_files::held(MapFolder::formats(self.maps.as_ref()).iter().copied().chain(submitted))
    }

    /// The name of a map below the folder of `--maps`: [VARIANT/]SET/SCENE.
    pub fn map_name(&self, scene: &Scene, variant: &Variant) -> PathBuf {
        let of_scene = Path::new(&scene.set).join(&scene.name);
        if self.variants.len() > 1 { Path::new(&file_name(&variant.label)).join(of_scene) } else { of_scene }
    }

    /// Everything that determines the results and files of a scene with a variant, except the contents of the scene's files.
    pub fn key(&self, number: usize, place: usize, scene: &Scene) -> String {
        let variant = &self.variants[place];
        let submission = self.submission.as_ref().map(|to| (absolute(&to.folder), &to.method));
        let files: Vec<_> = scene.files().map(absolute).collect();
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
        let maps = self.maps.as_ref().map(|maps| (absolute(&maps.folder), &maps.formats));
        let cameras = (self.cameras.digest(), self.look);
        let weights = weights(&variant.params);
        format!(
            "{of_run:?} {number} {place} {:?} {:?} {weights:?} {scene:?} {files:?} {maps:?} {cameras:?}",
            variant.settings, variant.params
        )
    }
}

/// The fingerprint of the weights that were given for these settings.
fn weights(params: &Params) -> Option<String> {
    let of_features = || params.features.as_ref().filter(|_| params.takes_features());
    params.network.as_ref().map(fingerprint).or_else(|| of_features().map(FeatureNetwork::fingerprint))
}
