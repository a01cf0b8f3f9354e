//! The summary of many pairs, and the lines that all summaries have.

use crate::engine::compute::{EngineNames, ParamsBySize, ends};
use crate::engine::pipeline::Ran;
use crate::terminal::{self, name, plain, rounded};
use anyhow::Result;
use serde::ser::SerializeMap as _;
use serde::{Serialize, Serializer};
use std::path::PathBuf;

/// The line on the adapter.
pub fn adapter_line(names: &EngineNames) -> String {
    let EngineNames { adapter, backend, driver, also } = names;
    let mut text = format!("adapter  {}\n", plain(&format!("{adapter} ({backend}, {driver})")));
    if let Some(also) = also {
        text += &format!("         {} runs the shaders with --backend gpu\n", plain(also));
    }
    text
}

/// The line on the disparities searched.
pub fn range_line(min_disparity: i32, disparities: u32) -> String {
    let last = i64::from(min_disparity) + i64::from(disparities) - 1;
    format!("range    {disparities} disparities, {min_disparity} to {last} px\n")
}

/// What was searched.
pub enum Searched {
    /// These disparities, the first and the last.
    Given([i32; 2]),
    /// Those of the first so many pairs.
    OfFirst([i32; 2], usize),
    /// What each pair needs; of all that were computed, these.
    OfEach(Option<[i32; 2]>),
}

impl Searched {
    /// By settings that are given, or of each pair.
    pub fn of(params: &ParamsBySize) -> Self {
        match params.has_ranges() {
            true => Self::OfEach(params.searched()),
            false => Self::Given(ends(&params.common)),
        }
    }

    fn line(&self) -> String {
        let line = |[first, last]: &[i32; 2]| range_line(*first, last.abs_diff(*first) + 1);
        match self {
            Self::Given(ends) => line(ends),
            Self::OfFirst(ends, pairs) => format!("{}, as the first {pairs} frames need\n", line(ends).trim_end()),
            Self::OfEach(Some([first, last])) => {
                format!("range    what each pair needs, {first} to {last} px in all\n")
            }
            Self::OfEach(None) => "range    what each pair needs\n".into(),
        }
    }

    /// The first and the last disparity, and whether they were found.
    fn ends(&self) -> (Option<[i32; 2]>, bool) {
        match self {
            Self::Given(ends) => (Some(*ends), false),
            Self::OfFirst(ends, _) => (Some(*ends), true),
            Self::OfEach(ends) => (*ends, true),
        }
    }
}

/// The results of a video or a batch.
pub struct Summary<F> {
    /// What a pair is called, `pairs` or `frames`.
    pub unit: &'static str,
    /// The adapter and its driver, if there was anything to compute.
    pub names: Option<EngineNames>,
    /// For a video: columns and rows of all frames, if there was anything to compute.
    pub size: Option<Option<(u32, u32)>>,
    /// Which disparities were searched.
    pub searched: Searched,
    /// For a batch: the shard, if one was given.
    pub shard: Option<Option<String>>,
    /// Pairs that were written.
    pub done: usize,
    /// Pairs whose files were there.
    pub skipped: usize,
    /// From the start to the last map written, with the creation of device and pipelines.
    pub seconds: f64,
    /// The most bytes in use on the device.
    pub peak_device_bytes: u64,
    /// The pairs that failed.
    pub failures: Vec<F>,
    /// Where they are logged.
    pub log: Option<PathBuf>,
    /// Why maps are doubtful.
    pub warnings: Vec<String>,
    /// How many maps are doubtful.
    pub doubtful: usize,
    /// Where the maps are.
    pub output: PathBuf,
}

impl<F> Summary<F> {
    /// The summary of a run, with its failures as the caller lists them.
    pub fn new(unit: &'static str, ran: Ran, searched: Searched, output: PathBuf, failures: Vec<F>) -> Self {
        Self {
            unit,
            warnings: ran.warnings(),
            doubtful: ran.doubtful_pairs,
            names: ran.names,
            size: None,
            searched,
            shard: None,
            done: ran.done,
            skipped: 0,
            seconds: ran.seconds,
            peak_device_bytes: ran.device_bytes,
            failures,
            log: None,
            output,
        }
    }

    fn per_second(&self) -> f64 {
        self.done as f64 / self.seconds.max(1e-9)
    }

    /// Prints the summary: as JSON, in words or, if `quiet`, not at all.
    pub fn print(&self, json: bool, quiet: bool) -> Result<()>
    where
        F: Serialize,
    {
        match (json, quiet) {
            (true, _) => terminal::print_json(self),
            (false, false) => terminal::print(&self.text()),
            (false, true) => Ok(()),
        }
    }

    fn text(&self) -> String {
        let mut text = self.names.as_ref().map(adapter_line).unwrap_or_default();
        if let Some(Some((width, height))) = self.size {
            text += &format!("size     {width} x {height}\n");
        }
        text += &self.searched.line();
        if let Some(Some(shard)) = &self.shard {
            text += &format!("shard    {shard}\n");
        }
        let (unit, failed) = (self.unit, self.failures.len());
        text += &format!("{unit:<9}{} done, {failed} failed, {} there already\n", self.done, self.skipped);
        if self.doubtful > 0 {
            text += &format!("doubtful {} {unit}: see the notes; --json lists them all\n", self.doubtful);
        }
        text += &format!("time     {:.1} s, {:.1} {unit} a second\n", self.seconds, self.per_second());
        text += &match self.done {
            0 => "written  nothing\n".into(),
            _ => format!("written  {}\n", name(&self.output)),
        };
        if let Some(log) = self.log.as_ref().filter(|_| failed > 0) {
            text += &format!("failed   {}\n", name(log));
        }
        text
    }
}

impl<F: Serialize> Serialize for Summary<F> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (unit, failed) = (self.unit, self.failures.len());
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("adapter", &self.names.as_ref().map(|names| &names.adapter))?;
        map.serialize_entry("backend", &self.names.as_ref().map(|names| &names.backend))?;
        map.serialize_entry("driver", &self.names.as_ref().map(|names| &names.driver))?;
        if let Some(size) = self.size {
            map.serialize_entry("width", &size.map(|(width, _)| width))?;
            map.serialize_entry("height", &size.map(|(_, height)| height))?;
        }
        let (ends, is_found) = self.searched.ends();
        map.serialize_entry("min_disparity", &ends.map(|[first, _]| first))?;
        map.serialize_entry("disparities", &ends.map(|[first, last]| last.abs_diff(first) + 1))?;
        if is_found {
            map.serialize_entry("disp", "auto")?;
        }
        if let Some(shard) = &self.shard {
            map.serialize_entry("shard", shard)?;
        }
        map.serialize_entry(unit, &(self.done + failed + self.skipped))?;
        map.serialize_entry("done", &self.done)?;
        map.serialize_entry("failed", &failed)?;
        map.serialize_entry("skipped", &self.skipped)?;
        map.serialize_entry("seconds", &rounded(self.seconds))?;
        map.serialize_entry(&format!("{unit}_per_second"), &rounded(self.per_second()))?;
        map.serialize_entry("peak_device_bytes", &self.peak_device_bytes)?;
        map.serialize_entry("failures", &self.failures)?;
        map.serialize_entry("warnings", &self.warnings)?;
        map.serialize_entry("output", &self.output.to_string_lossy())?;
        map.end()
    }
}
