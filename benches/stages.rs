//! Each stage and the whole frame, by criterion: `cargo bench --bench stages [FILTER]`; the dev profile will not do.
//!
//! A stage's time comes from timestamp queries on the device, a frame's from the host's clock: upload, every kernel,
//! readback. Throughput is in elements: pixels times disparities, whether or not a stage has a value for each.
#![allow(missing_docs, clippy::unwrap_used)]

use std::path::PathBuf;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput};
use gpu_stereo::files::images::{Bits, read_pair};
use gpu_stereo::reference::{Channel, gray};
use gpu_stereo::{Image, Params, Paths, Pixels, StereoMatcher, wgpu};

/// The pair in gray.
fn load() -> [Image; 2] {
    let at = |name: &str| PathBuf::from(format!("{}/data/motorcycle/{name}.png", env!("CARGO_MANIFEST_DIR")));
    let pair = read_pair(&at("left"), &at("right"), Bits::Auto).unwrap();
    [pair.left, pair.right].map(|image| {
        let luma = gray(&image, Channel::Luma).data;
        Image::new(image.width(), image.height(), Pixels::Gray8(luma)).unwrap()
    })
}

fn settings(disparities: u32) -> [(&'static str, Params); 3] {
    let mut eight = Params::sgm(disparities);
    eight.paths = Paths::Eight;
    [("sgm 4 paths", Params::sgm(disparities)), ("sgm 8 paths", eight), ("bm", Params::bm(disparities))]
}

fn stages(criterion: &mut Criterion) {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    let adapter = adapters.into_iter().next().expect("an adapter: install a Vulkan driver");
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: StereoMatcher::required_features(&adapter),
        required_limits: StereoMatcher::required_limits(&adapter),
        ..Default::default()
    }))
    .unwrap();
    println!("adapter: {}", adapter.get_info().name);
    if !device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
        println!("NOT MEASURED: stages, for lack of timestamps; whole frames only");
    }

    let [left, right] = load();
    for disparities in [64, 128] {
        for (name, params) in settings(disparities) {
            let matcher =
                StereoMatcher::new(&device, &queue, left.width(), left.height(), left.format(), &params).unwrap();
            let (_, times) = matcher.compute_timed_blocking(&left, &right).unwrap(); // also compiles
            let mut group = criterion.benchmark_group(name);
            let pixels = u64::from(left.width()) * u64::from(left.height());
            group.throughput(Throughput::Elements(pixels * u64::from(disparities)));
            group.sample_size(10).warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_secs(1));
            group.bench_function(BenchmarkId::new("frame", disparities), |bencher| {
                bencher.iter(|| matcher.compute_blocking(&left, &right).unwrap().map);
            });
            for stage in times.iter().map(|time| &time.name) {
                group.bench_function(BenchmarkId::new(stage, disparities), |bencher| {
                    bencher.iter_custom(|frames| {
                        let of_frame = |_| {
                            let (_, times) = matcher.compute_timed_blocking(&left, &right).unwrap();
                            times.iter().find(|time| time.name == *stage).unwrap().ms / 1e3
                        };
                        Duration::from_secs_f64((0..frames).map(of_frame).sum())
                    });
                });
            }
            group.finish();
        }
    }
}

criterion::criterion_group!(benches, stages);
criterion::criterion_main!(benches);
