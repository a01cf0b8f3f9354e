//! Disparities of a network before they are rounded, and its time: what benches/psmnet.py compares with PyTorch.
//! `cargo bench --bench network -- --weights FILE LEFT RIGHT [OPTIONS]`.
//!
//!     --disp N              default 192
//!     --by WAY              native: matrix products on the CPU; reference: the definition in doubles; device: the first
//!                           adapter. Default native
//!     --align-corners off
//!     --frames N            frames after the first, of which the least time is told; default 0: the first one's
//!     --npy FILE            writes the disparities
//!     --tensors FOLDER      writes what each operation makes, with reference: NAME.SIDE.f32
//!
//! Prints a line of JSON: milliseconds, the work, and what there is to know of the process's memory.
#![allow(missing_docs, clippy::unwrap_used)]

use std::path::{Path, PathBuf};
use std::time::Instant;

use gpu_stereo::cpu::CpuMatcher;
use gpu_stereo::files::images::{Bits, read_pair};
use gpu_stereo::{Image, Network, Params, StereoMatcher, reference};
use npyz::WriterBuilder as _;
use serde_json::json;

#[path = "../tests/support/mod.rs"]
mod support;

struct Options {
    weights: PathBuf,
    pair: [PathBuf; 2],
    disparities: u32,
    by: String,
    align_corners: bool,
    frames: usize,
    npy: Option<PathBuf>,
    tensors: Option<PathBuf>,
}

fn options() -> Result<Options, String> {
    let (mut weights, mut pair, mut by) = (None, Vec::new(), "native".to_owned());
    let (mut disparities, mut align_corners, mut frames, mut npy, mut tensors) = (192, true, 0, None, None);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--bench" => (), // cargo's own
            "--weights" => weights = Some(value()?.into()),
            "--disp" => disparities = value()?.parse().map_err(|_| "--disp is a number")?,
            "--by" => by = value()?,
            "--align-corners" => align_corners = value()? != "off",
            "--frames" => frames = value()?.parse().map_err(|_| "--frames is a number")?,
            "--npy" => npy = Some(value()?.into()),
            "--tensors" => tensors = Some(value()?.into()),
            other if other.starts_with('-') => return Err(format!("there is no option {other}")),
            _ => pair.push(argument.into()),
        }
    }
    let weights = weights.ok_or("--weights FILE is needed: benches/psmnet.py finds some")?;
    let pair = pair.try_into().map_err(|_| "two images are needed")?;
    Ok(Options { weights, pair, disparities, by, align_corners, frames, npy, tensors })
}

/// The definition, with what each operation makes.
fn traced(pair: [&Image; 2], network: &Network, params: &Params, folder: &Path) -> Result<Vec<f32>, gpu_stereo::Error> {
    let mut receive = |at: usize, side: usize, values: &reference::Values| {
        let bytes: Vec<u8> = values.data.iter().flat_map(|&value| (value as f32).to_le_bytes()).collect();
        std::fs::write(folder.join(format!("{}.{side}.f32", network.operations()[at].name)), bytes).unwrap();
    };
    let plane = reference::network(pair[0], pair[1], network, params, &mut receive)?;
    Ok(plane.data.into_iter().map(|value| value as f32).collect())
}

/// The peak of this process's resident memory in bytes, where the system tells it.
fn peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
    Some(1024 * line.split_whitespace().nth(1)?.parse::<u64>().ok()?)
}

fn run() -> Result<(), Box<dyn std::error::Error>> {
    let options = options()?;
    let network = Network::load(&options.weights)?;
    let images = read_pair(&options.pair[0], &options.pair[1], Bits::Auto)?;
    let [left, right] = [&images.left, &images.right];
    let mut params = Params::psmnet(options.disparities, network.clone());
    (params.align_corners, params.unrounded) = (options.align_corners, true);
    let matcher = match options.by.as_str() {
        "device" => {
            let (_, device, queue) = support::device().ok_or("there is no adapter")?;
            Some(StereoMatcher::new(&device, &queue, left.width(), left.height(), left.format(), &params)?)
        }
        "native" | "reference" => None,
        other => return Err(format!("--by is native, reference or device, not {other}").into()),
    };
    let compute = || {
        if let Some(folder) = &options.tensors {
            return traced([left, right], &network, &params, folder);
        }
        let matched = match &matcher {
            Some(matcher) => matcher.compute_blocking(left, right)?,
            None if options.by == "native" => {
                CpuMatcher::new(left.width(), left.height(), left.format(), &params)?.compute(left, right)?
            }
            None => reference::compute_all(left, right, &params)?,
        };
        Ok(matched.unrounded.unwrap().data)
    };
    let mut times = Vec::new();
    let mut disparities = Vec::new();
    for _ in 0..=options.frames {
        let start = Instant::now();
        disparities = compute()?;
        times.push(start.elapsed().as_secs_f64() * 1e3);
    }
    if let Some(path) = &options.npy {
        let file = std::io::BufWriter::new(std::fs::File::create(path)?);
        let shape = [u64::from(left.height()), u64::from(left.width())];
        let mut writer = npyz::WriteOptions::new().default_dtype().shape(&shape).writer(file).begin_nd()?;
        writer.extend(disparities)?;
        writer.finish()?;
    }
    let least = times[options.frames.min(1)..].iter().copied().fold(f64::INFINITY, f64::min);
    let giga = params.multiplications(left.width(), left.height()) as f64 * 1e-9;
    println!(
        "{}",
        json!({ "by": options.by, "ms": least, "giga_multiplications": giga, "per_second": giga / least * 1e3, "peak_bytes": peak() })
    );
    Ok(())
}

fn main() {
    if let Err(error) = run() {
        eprintln!("network: {error}");
        std::process::exit(2);
    }
}
