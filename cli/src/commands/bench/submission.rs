//! `--submission`: the files that a benchmark takes.

use super::files::put;
use super::scene::SceneReport;
use crate::commands::variants::Variant;
use crate::engine::known::KnownFile;
use crate::engine::output_files::file_name;
use anyhow::Result;
use gpu_stereo::files::datasets::{DataSet, Scene};
use gpu_stereo::files::encoders;
use gpu_stereo::files::encoders::{Format, Maps, SampleFormat};
use gpu_stereo::{DisparityMap, Params};
use std::path::PathBuf;

/// Where files to submit go.
pub struct Submission {
    /// The folder.
    pub folder: PathBuf,
    /// The method's name.
    pub method: String,
    /// The layout of the data set and of the submission.
    pub layout: DataSet,
    /// Whether there are several variants.
    pub several: bool,
}

/// What is submitted of a scene.
pub struct Files {
    /// The map.
    pub map: PathBuf,
    /// What it holds.
    pub format: Format,
    /// The time, if it is wanted.
    pub time: Option<PathBuf>,
}

impl Submission {
    /// The folder of a variant, one of its own if there are several.
    pub fn folder_of(&self, variant: &Variant) -> PathBuf {
        match self.several {
            false => self.folder.clone(),
            true => self.folder.join(file_name(&variant.label)),
        }
    }

    /// The files of a scene as the benchmark wants them; `sparse`: whether its map has holes.
    pub fn files(&self, scene: &Scene, variant: &Variant, sparse: bool) -> Files {
        let folder = self.folder_of(variant);
        let (set, method) = (folder.join(&scene.set), &self.method);
        let kitti = |map| Files { map, format: Format::Disparity(SampleFormat::Png), time: None };
        let with_time = |map, time| Files { map, format: Format::Disparity(SampleFormat::Pfm), time: Some(time) };
        match self.layout {
            DataSet::Kitti2015 => kitti(set.join("disp_0").join(format!("{}.png", scene.name))),
            DataSet::Kitti2012 => kitti(set.join(format!("{}.png", scene.name))),
            DataSet::Middlebury => {
                // A map with holes has a name of its own.
                let suffix = if sparse { "_s" } else { "" };
                let folder = set.join(&scene.name);
                with_time(folder.join(format!("disp0{method}{suffix}.pfm")), folder.join(format!("time{method}.txt")))
            }
            // The other layouts were refused.
            DataSet::Eth3d | DataSet::Vkitti2 | DataSet::Manifest => {
                let folder = folder.join("low_res_two_view");
                with_time(folder.join(format!("{}.pfm", scene.name)), folder.join(format!("{}.txt", scene.name)))
            }
        }
    }

    /// Writes them.
    pub fn write(
        &self,
        scene: &Scene,
        variant: &Variant,
        map: &DisparityMap,
        found: &SceneReport,
        params: &Params,
    ) -> Result<Vec<KnownFile>> {
        let files = self.files(scene, variant, map.data.contains(&DisparityMap::INVALID));
        let mut written = vec![put(&files.map, &encoders::encode(files.format, &Maps::of(map, params))?.bytes)?];
        let Some(time) = files.time else { return Ok(written) };
        let seconds = found.frame_ms.median / 1e3;
        let text = match self.layout {
            DataSet::Eth3d => format!("runtime {seconds:.6}\n"),
            _ => format!("{seconds:.6}\n"),
        };
        written.push(put(&time, text.as_bytes())?);
        Ok(written)
    }
}
