//! How near to a device's memory bandwidth the kernels come: `cargo bench --bench device -- [OPTIONS]`.
//!
//!     --small              two small sizes: does it work?
//!     --sizes WxHxD,..     default 741x500x64,1242x375x128,1920x1080x128,3840x2160x256; on CPU adapters the first two
//!     --schedule NAME      auto, per-thread or per-subgroup
//!     --frames N           frames a case, default 20
//!     --json FILE          everything measured, each stage's time among it
//!
//! The pairs are synthetic: no time depends on what is in the images. Columns of the table:
//!
//! - frame: the host's clock around `compute`: upload, all kernels, readback; the median.
//! - device: a frame without upload, readback and submission: what one more frame in a submission of several adds to it.
//! - kernels: the sum of the stages' times from timestamp queries, the least of the frames: neither what lies between
//!   two kernels nor copies into textures.
//! - G disp/s: pixels times disparities by the kernels' time.
//! - floor: the time that the unavoidable bytes take at the bandwidth of a copy from buffer to buffer, bytes read and
//!   bytes written, measured at the start of the same run; and the kernels' time as a multiple of it.
//!
//! The unavoidable bytes of a voxel, with one byte for its cost and one for its T of each direction: the cost is written
//! once and read by each direction; the T of each direction but the last, which ends in the winner, are written once and
//! read once. Where two directions share a byte, the second one reads and writes it, and one read does for both: that is
//! as many. So there are 1 + paths + 2 (paths - 1) = 3 paths - 1 bytes: 11 with 4 paths and 23 with 8. Images and maps
//! are left out: together less than a tenth of a byte a voxel at 128 disparities.
#![allow(missing_docs, clippy::unwrap_used)]

use std::time::Instant;

use gpu_stereo::{Image, Inputs, Outputs, Params, Paths, Schedule, StereoMatcher, wgpu};
use serde_json::{Value, json};

#[path = "../tests/support/mod.rs"]
mod support;

const SIZES: &str = "741x500x64,1242x375x128,1920x1080x128,3840x2160x256";
/// The largest of those takes a CPU adapter minutes, and more memory than many machines have.
const ON_CPU: &str = "741x500x64,1242x375x128";
const SMALL: &str = "185x125x32,370x250x64";

struct Options {
    sizes: Option<Vec<[u32; 3]>>,
    schedule: Schedule,
    frames: usize,
    json: Option<String>,
}

fn options() -> Result<Options, String> {
    let mut options = Options { sizes: None, schedule: Schedule::Auto, frames: 20, json: None };
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--bench" => (), // cargo's own
            "--small" => options.sizes = Some(sizes(SMALL)?),
            "--sizes" => options.sizes = Some(sizes(&value()?)?),
            "--frames" => options.frames = value()?.parse().map_err(|_| "--frames is a number, at least 1")?,
            "--json" => options.json = Some(value()?),
            "--schedule" => {
                options.schedule = match value()?.as_str() {
                    "auto" => Schedule::Auto,
                    "per-thread" => Schedule::PerThread,
                    "per-subgroup" => Schedule::PerSubgroup,
                    other => return Err(format!("--schedule is auto, per-thread or per-subgroup, not {other}")),
                }
            }
            other => return Err(format!("there is no option {other}: see the head of benches/device.rs")),
        }
    }
    if options.frames == 0 { Err("--frames is at least 1".into()) } else { Ok(options) }
}

fn sizes(text: &str) -> Result<Vec<[u32; 3]>, String> {
    let wrong = || format!("a size is WIDTHxHEIGHTxDISPARITIES, as in {SIZES}, not {text}");
    let size = |text: &str| {
        let numbers: Vec<u32> = text.split('x').map(str::parse).collect::<Result<_, _>>().map_err(|_| wrong())?;
        numbers.try_into().map_err(|_| wrong())
    };
    text.split(',').map(size).collect()
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Milliseconds that one more of what `record` records takes within a submission: the least of several.
fn added_ms(device: &wgpu::Device, queue: &wgpu::Queue, record: impl Fn(&mut wgpu::CommandEncoder)) -> f64 {
    let run = |times: u32| {
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        (0..times).for_each(|_| record(&mut encoder));
        let commands = encoder.finish();
        let start = Instant::now();
        queue.submit([commands]);
        device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        start.elapsed().as_secs_f64() * 1e3
    };
    run(1);
    let least = |times: u32| (0..5).map(|_| run(times)).fold(f64::INFINITY, f64::min);
    (least(5) - least(1)) / 4.0
}

/// GB/s, bytes read and bytes written, of a copy from buffer to buffer.
fn copy_bandwidth(device: &wgpu::Device, queue: &wgpu::Queue) -> f64 {
    let size = device.limits().max_buffer_size.min(1 << 29);
    let buffer = || {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("bandwidth"),
            size,
            usage: wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    };
    let (from, to) = (buffer(), buffer());
    2.0 * size as f64 / added_ms(device, queue, |encoder| encoder.copy_buffer_to_buffer(&from, 0, &to, 0, size)) * 1e-6
}

fn case(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    bandwidth: f64,
    [width, height, disparities]: [u32; 3],
    paths: Paths,
    options: &Options,
) -> Result<Value, gpu_stereo::Error> {
    let mut params = Params::sgm(disparities);
    (params.paths, params.schedule) = (paths, options.schedule);
    let (left, right): (Image, Image) = support::pair(width, height, 1);
    let matcher = StereoMatcher::new(device, queue, width, height, left.format(), &params)?;
    let start = Instant::now();
    matcher.compute_blocking(&left, &right)?;
    let first = start.elapsed().as_secs_f64() * 1e3;
    let mut frames = Vec::new();
    for _ in 0..options.frames {
        let start = Instant::now();
        matcher.compute_blocking(&left, &right)?;
        frames.push(start.elapsed().as_secs_f64() * 1e3);
    }
    let record = |encoder: &mut _| matcher.record(encoder, &Inputs::Uploaded, &Outputs::default()).expect("recorded");
    let on_device = added_ms(device, queue, record);
    let mut least: Option<(f64, Value)> = None;
    for _ in 0..options.frames {
        let (_, stages) = matcher.compute_timed_blocking(&left, &right)?;
        let sum: f64 = stages.iter().map(|stage| stage.ms).sum();
        if !stages.is_empty() && least.as_ref().is_none_or(|(ms, _)| sum < *ms) {
            let stages = stages.into_iter().map(|stage| (stage.name, stage.ms.into())).collect();
            least = Some((sum, Value::Object(stages)));
        }
    }
    let voxels = f64::from(width) * f64::from(height) * f64::from(disparities);
    let count = match paths {
        Paths::Three => 3,
        Paths::Four => 4,
        _ => 8,
    };
    let bytes = 3 * count - 1;
    let floor = voxels * f64::from(bytes) / bandwidth * 1e-6;
    let (kernels, stages) = least.unzip();
    Ok(json!({
        "width": width, "height": height, "disparities": disparities, "paths": count,
        "first_frame_ms": first, "frame_ms": median(frames), "device_ms": on_device, "kernels_ms": kernels,
        "stages_ms": stages, "giga_disparities_per_second": kernels.map(|ms| voxels / ms * 1e-6),
        "bytes_per_voxel": bytes, "floor_ms": floor, "kernels_by_floor": kernels.map(|ms| ms / floor),
        "device_bytes": matcher.device_bytes(), "device_bytes_per_voxel": matcher.device_bytes() as f64 / voxels,
    }))
}

fn run() -> Result<(), String> {
    let options = options()?;
    let Some((adapter, device, queue)) = support::device() else { return Err("there is no adapter".into()) };
    let info = adapter.get_info();
    let default = if info.device_type == wgpu::DeviceType::Cpu { ON_CPU } else { SIZES };
    let sizes = options.sizes.clone().map_or_else(|| sizes(default), Ok)?;
    let bandwidth = copy_bandwidth(&device, &queue);
    println!("{} ({:?}, {} {})", info.name, info.backend, info.driver, info.driver_info);
    println!("copy: {bandwidth:.1} GB/s, read and written\n");
    println!("| size | D | paths | frame, ms | device, ms | kernels, ms | G disp/s | floor, ms | kernels / floor |");
    println!("|---|---|---|---|---|---|---|---|---|");
    let mut cases = Vec::new();
    for &size in &sizes {
        for paths in [Paths::Four, Paths::Eight] {
            let [width, height, disparities] = size;
            match case(&device, &queue, bandwidth, size, paths, &options) {
                Ok(found) => {
                    let number = |key: &str| match found[key].as_f64() {
                        Some(value) => format!("{value:.2}"),
                        None => "not told".into(),
                    };
                    println!(
                        "| {width}x{height} | {disparities} | {} | {} | {} | {} | {} | {} | {} |",
                        found["paths"],
                        number("frame_ms"),
                        number("device_ms"),
                        number("kernels_ms"),
                        number("giga_disparities_per_second"),
                        number("floor_ms"),
                        number("kernels_by_floor"),
                    );
                    cases.push(found);
                }
                Err(error) => println!("| {width}x{height} | {disparities} | {paths:?} | {error} | | | | | |"),
            }
        }
    }
    if let Some(path) = &options.json {
        let machine = json!({
            "adapter": info.name, "backend": format!("{:?}", info.backend), "driver": info.driver,
            "driver_info": info.driver_info, "copy_gigabytes_per_second": bandwidth,
            "schedule": format!("{:?}", options.schedule), "frames": options.frames,
        });
        let text = serde_json::to_string_pretty(&json!({ "machine": machine, "cases": cases })).unwrap();
        std::fs::write(path, text + "\n").map_err(|error| format!("{path}: {error}"))?;
    }
    Ok(())
}

fn main() -> std::process::ExitCode {
    match run() {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("device: {error}");
            std::process::ExitCode::from(2)
        }
    }
}
