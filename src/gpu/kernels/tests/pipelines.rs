//! Every text is valid, and wgpu makes every pipeline and matcher of it, without a driver.

use wgpu::naga;

use super::specialisations::{CAPABILITIES, PLAN, specialisations, specialised, texts};
use crate::gpu::kernels::compile;
use crate::gpu::kernels::table::Kernel;
use crate::gpu::kernels::{KERNELS, source};
use crate::{Cost, Median, Prefilter, RightView, Schedule, StereoMatcher};
use crate::{Params, PixelFormat};

/// Panics unless naga takes a text as it is.
fn validate(name: &str, text: &str) {
    let module =
        naga::front::wgsl::parse_str(text).unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(text)));
    let mut validator = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), CAPABILITIES);
    validator.subgroup_stages(naga::valid::ShaderStages::COMPUTE);
    validator.subgroup_operations(naga::valid::SubgroupOperationSet::all());
    if let Err(error) = validator.validate(&module) {
        panic!("{name}: {}", error.emit_to_string(text));
    }
}

#[test]
fn every_kernel_is_valid_wgsl() {
    assert!(!KERNELS.is_empty(), "the table of kernels is empty");
    for kernel in KERNELS {
        let texts = texts(kernel);
        assert!(texts.len() > 0, "{} has no text", kernel.name);
        texts.for_each(|text| validate(kernel.name, text));
    }
}

/// The texts that a matcher gives are those of its kernels and no others, each once and valid alone.
#[test]
fn a_matcher_gives_the_shaders_that_it_runs() {
    let (device, queue) = noop_device();
    let names = |params: &Params| {
        let matcher = StereoMatcher::new(&device, &queue, 70, 50, PixelFormat::Gray8, params).unwrap();
        let shaders = matcher.shaders();
        shaders.iter().for_each(|(name, text)| validate(name, text));
        shaders.into_iter().map(|(name, _)| name).collect::<Vec<_>>()
    };
    let classic = |schedule| Params { schedule, median: Median::Off, lr_check: None, ..Params::sgm(16) };
    let [before, after] = [["gray", "prefilter"], ["sgm_aggregate", "winner"]];
    for (schedule, cost) in
        [(Schedule::PerThread, "matching_cost_small"), (Schedule::PerSubgroup, "matching_cost_parallel")]
    {
        assert_eq!(names(&classic(schedule)), [&before[..], &[cost], &after[..]].concat());
    }
    let mutual =
        Params { cost: Cost::MutualInformation, block: 1, prefilter: Prefilter::None, ..classic(Schedule::PerThread) };
    let mutual = names(&mutual);
    for name in ["mi_histogram", "matching_cost_pixels", "winner"] {
        assert_eq!(mutual.iter().filter(|other| *other == name).count(), 1, "{name} in {mutual:?}");
    }
    // The images of the second match are prefiltered in the same way, but its winner gives no right view.
    let twice = names(&Params {
        right_view: RightView::Match,
        lr_check: Some(1),
        uniqueness: 10,
        ..classic(Schedule::PerThread)
    });
    assert!(twice.iter().any(|name| name.ends_with(".2")), "{twice:?}");
}

/// A device without a driver, with the features that some plans need.
fn noop_device() -> (wgpu::Device, wgpu::Queue) {
    wgpu::Device::noop(&wgpu::DeviceDescriptor {
        required_features: wgpu::Features::SUBGROUP | wgpu::Features::SHADER_INT64,
        ..Default::default()
    })
}

/// wgpu itself accepts every pipeline with the table's layout, and every bind group of a matcher at one of three sizes. The
/// backend `noop` has no driver, so this also holds where there is no adapter.
#[test]
fn pipelines_and_matchers_are_made_without_a_driver() {
    let (device, queue) = noop_device();
    for kernel in KERNELS {
        for (text, bound) in specialised(kernel) {
            for (params, format, plan) in bound {
                let made =
                    crate::gpu::scopes::guarded(&device, || compile(&device, kernel, text.as_str(), params, plan));
                assert!(made.is_ok(), "{} with {params:?}, {format:?}: {}", kernel.name, made.unwrap_err());
            }
        }
    }
    let sizes = [(1, 1), (2, 3), (301, 45)].into_iter().cycle();
    for ((params, format, plan), (width, height)) in specialisations().into_iter().step_by(7).zip(sizes) {
        let schedule = if plan.per_subgroup { Schedule::PerSubgroup } else { Schedule::PerThread };
        let params = Params { schedule, ..params };
        let matcher = StereoMatcher::new(&device, &queue, width, height, format, &params);
        assert!(matcher.is_ok(), "{width}x{height} in {format:?}, {params:?}: {}", matcher.unwrap_err());
    }
}

/// A kernel that lacks a binding is refused where the pipeline is made: the test of the test above.
#[test]
fn a_wrong_row_of_the_table_is_refused() {
    let (device, _queue) = noop_device();
    for kernel in KERNELS {
        let row = Kernel { storage: &kernel.storage[1..], ..*kernel };
        let params = Params::sgm(64);
        let text = source(&row, &params, PixelFormat::Gray8, &PLAN);
        let made = crate::gpu::scopes::guarded(&device, || compile(&device, &row, &*text, &params, &PLAN));
        assert!(made.is_err(), "{} was accepted with a binding too few", kernel.name);
    }
}
