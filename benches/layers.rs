//! What the stages of a network compute a second: `cargo bench --bench layers -- [OPTIONS]`.
//!
//!     --small                two small sizes: does it work?
//!     --sizes WxHxD,..       default 512x256x192
//!     --architecture NAME    stackhourglass or basic (default: all of whose volumes have 32 channels); of random weights
//!     --schedule NAME        auto, per-thread or per-subgroup
//!     --frames N             frames a case, default 2, after one that is not counted
//!
//! Times are those of the kernels by timestamp queries, the least of the frames. No time depends on what is in the images or in the
//! weights. G MAC/s: multiplications with weights, each with an addition. At 512x256 with 192 disparities the stage `conv3d`
//! of `basic` is ten convolutions from 32 to 32 channels of volumes of 48x64x128, the first one, from 64 to 32, and the last one.
#![allow(missing_docs, clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::time::Instant;

use gpu_stereo::network::{Architecture, Kind, Network, Operation, Padded, Tensor};
use gpu_stereo::{Median, Method, Params, RightView, Schedule, StereoMatcher};
use rand::{Rng, SeedableRng};

#[path = "../tests/support/mod.rs"]
mod support;

struct Options {
    sizes: Vec<[u32; 3]>,
    architecture: Architecture,
    schedule: Schedule,
    frames: usize,
}

fn options() -> Result<Options, String> {
    let mut options = Options {
        sizes: vec![[512, 256, 192]],
        architecture: Architecture::Basic,
        schedule: Schedule::Auto,
        frames: 2,
    };
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--bench" => (), // cargo's own
            "--small" => options.sizes = vec![[256, 256, 16], [256, 272, 32]],
            "--sizes" => options.sizes = sizes(&value()?)?,
            "--frames" => options.frames = value()?.parse().map_err(|_| "--frames is a number, at least 1")?,
            "--architecture" => {
                let name = value()?;
                let known = Architecture::ALL.into_iter().find(|known| known.to_string() == name);
                options.architecture = known.ok_or("--architecture is stackhourglass or basic")?;
            }
            "--schedule" => {
                options.schedule = match value()?.as_str() {
                    "auto" => Schedule::Auto,
                    "per-thread" => Schedule::PerThread,
                    "per-subgroup" => Schedule::PerSubgroup,
                    _ => return Err("--schedule is auto, per-thread or per-subgroup".into()),
                }
            }
            _ => return Err(format!("{argument} is unknown; the head of benches/layers.rs lists the options")),
        }
    }
    Ok(options)
}

fn sizes(text: &str) -> Result<Vec<[u32; 3]>, String> {
    let size = |text: &str| {
        let sides: Result<Vec<u32>, _> = text.split('x').map(str::parse).collect();
        sides.ok().and_then(|sides| sides.try_into().ok()).ok_or(format!("{text} is no size; write 512x256x192"))
    };
    text.split(',').map(size).collect()
}

/// A network with random weights, of values that stay about as large as they are.
fn random(architecture: Architecture) -> Network {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    let tensor = |(name, shape): (String, Vec<usize>)| {
        let each: usize = shape[1..].iter().product();
        let [low, high] = match &name {
            name if name.ends_with("running_var") => [0.9, 1.1],
            _ if shape.len() == 1 => [-0.1, 1.0],
            _ => [-1.5 / (each as f32).sqrt(), 1.5 / (each as f32).sqrt()],
        };
        let data = (0..shape.iter().product()).map(|_| random.random_range(low..high)).collect();
        (name, Tensor::new(shape, data).unwrap())
    };
    Network::new(architecture.tensors().into_iter().map(tensor).collect()).unwrap()
}

/// The stage that computes an operation with weights.
fn stage(kind: Kind) -> Option<&'static str> {
    match kind {
        Kind::Conv2d { .. } => Some("conv2d"),
        Kind::VolumeConv3d | Kind::Conv3d { .. } => Some("conv3d"),
        Kind::TransposedConv3d => Some("conv3d_transposed"),
        _ => None,
    }
}

/// Multiplications of each stage, in billions.
fn work(operations: &[Operation], padded: &Padded) -> BTreeMap<&'static str, f64> {
    let mut work = BTreeMap::new();
    for operation in operations {
        if let Some(stage) = stage(operation.kind) {
            *work.entry(stage).or_default() += operation.multiplications(operations, padded) as f64 * 1e-9;
        }
    }
    work
}

fn case([width, height, disparities]: [u32; 3], options: &Options, network: &Network) -> Result<(), String> {
    let Some((adapter, device, queue)) = support::device() else { return Ok(()) };
    let mut params = Params::sgm(disparities);
    (params.method, params.right_view, params.network) = (Method::Psmnet, RightView::Match, Some(network.clone()));
    (params.lr_check, params.median, params.schedule) = (None, Median::Off, options.schedule);
    let (left, right) = support::pair(width, height, 1);
    let new = StereoMatcher::new(&device, &queue, width, height, left.format(), &params);
    let matcher = new.map_err(|error| error.to_string())?;
    let mut stages: BTreeMap<String, f64> = BTreeMap::new();
    let mut frame = f64::MAX;
    for nth in 0..=options.frames {
        let start = Instant::now();
        let (_, times) = matcher.compute_timed_blocking(&left, &right).map_err(|error| error.to_string())?;
        if nth > 0 {
            frame = frame.min(start.elapsed().as_secs_f64());
            for time in times {
                let least = stages.entry(time.name.to_string()).or_insert(f64::MAX);
                *least = least.min(time.ms * 1e-3);
            }
        }
    }
    let work = work(network.operations(), &Padded::new(width, height, disparities));
    println!("{width}x{height}x{disparities} {} on {}", network.architecture(), adapter.get_info().name);
    println!("{:22} {:>9} {:>9} {:>9}", "stage", "s", "G MAC", "G MAC/s");
    let row = |name: &str, seconds: f64, work: f64| {
        println!("{name:22} {seconds:9.3} {work:9.2} {:9.2}", work / seconds);
    };
    for (name, &seconds) in &stages {
        row(name, seconds, work.get(name.as_str()).copied().unwrap_or(0.0));
    }
    row("frame", frame, work.values().sum());
    Ok(())
}

fn run() -> Result<(), String> {
    let options = options()?;
    let network = random(options.architecture);
    options.sizes.iter().try_for_each(|&size| case(size, &options, &network))
}

fn main() -> std::process::ExitCode {
    match run() {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            std::process::ExitCode::FAILURE
        }
    }
}
