use rand::SeedableRng;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;

use crate::gpu::kernels::tests::{Setup, support};
use crate::network::tiny::tiny;
use crate::{Fill, Inputs, Outputs, Params, Schedule, StereoMatcher, Unrounded};

mod made;

/// A network of every kind of operation, and no filter.
fn params(disparities: u32, schedule: Schedule) -> Params {
    Params { schedule, ..Params::psmnet(disparities, tiny(3)) }
}

/// What differs from the definition.
fn wrong(setup: &Setup, [width, height]: [u32; 2], format: u32, params: &Params) -> Vec<String> {
    let (_, device, queue) = setup;
    let (left, right) = support::pair(width, height, 7);
    let [left, right] = [left, right].map(|image| support::as_format(&image, format));
    let matcher = StereoMatcher::new(device, queue, width, height, left.format(), params).unwrap();
    let stages = matcher.check_blocking(&left, &right).unwrap();
    let names: Vec<&str> = stages.iter().map(|stage| &*stage.stage).collect();
    for name in ["network_input", "conv2d", "average_pool", "upsample", "conv3d", "conv3d_transposed"] {
        assert!(names.contains(&name), "{name} in {names:?}");
    }
    assert!(names.contains(&"disparity_regression") && names.contains(&"round_disparities"), "{names:?}");
    let wrong = stages.iter().filter(|stage| stage.mismatches > 0);
    wrong.map(|stage| format!("{width}x{height}, {params:?}: {stage:?}")).collect()
}

/// Every operation on sizes that are no multiple of what an invocation computes, in both schedules, from every format.
#[test]
fn every_operation_is_the_definition() {
    let Some(setup) = support::device() else { return };
    let mut all = Vec::new();
    for (i, (schedule, size, disparities)) in [
        (Schedule::PerThread, [93, 41], 16),
        (Schedule::PerThread, [300, 270], 48),
        (Schedule::PerSubgroup, [257, 30], 32),
        (Schedule::PerSubgroup, [31, 256], 16),
    ]
    .into_iter()
    .enumerate()
    {
        let params = Params { shader_checks: i % 2 == 1, align_corners: i < 2, ..params(disparities, schedule) };
        all.extend(wrong(&setup, size, i as u32, &params));
    }
    assert!(all.is_empty(), "{}", all.join("\n"));
}

/// Where a binding holds no volume, some channels at a time are read and written: with the same values, to the bit. What no
/// buffer holds is refused.
#[test]
fn volumes_beyond_a_binding_are_cut() {
    let cut = support::device_with(|_, limits| {
        limits.max_storage_buffer_binding_size = 2 << 20;
        limits.max_buffer_size = 3 << 20;
    });
    let (Some(cut), Some(whole)) = (cut, support::device()) else { return };
    let (left, right) = &support::pair(90, 40, 7);
    let [cut, whole] = [cut, whole].map(|(_, device, queue)| {
        move |disparities, schedule| {
            let params = Params { unrounded: true, ..params(disparities, schedule) };
            let matcher = StereoMatcher::new(&device, &queue, 90, 40, left.format(), &params)?;
            matcher.compute_blocking(left, right).map(|matched| matched.unrounded)
        }
    });
    for schedule in [Schedule::PerThread, Schedule::PerSubgroup] {
        let (cut, whole) = (cut(80, schedule).unwrap(), whole(80, schedule).unwrap());
        assert!(cut.is_some() && cut == whole, "{schedule}");
    }
    let refused = cut(112, Schedule::PerSubgroup).unwrap_err().to_string();
    let told = "a volume of the network needs 3670016 bytes, but the device allows 3145728; use fewer disparities or smaller images";
    assert_eq!(refused, told);
}

/// The right view by a second run, the filters, the disparities before they are rounded; another size and back in the same memory.
#[test]
fn what_follows_the_network() {
    let Some(setup) = support::device() else { return };
    let base =
        Params { lr_check: Some(1), right_map: true, unrounded: true, labels: true, ..params(16, Schedule::PerThread) };
    let params = Params { fill: Fill::Background, ..base };
    assert!(wrong(&setup, [101, 50], 2, &params).is_empty());
    let (_, device, queue) = &setup;
    let (left, right) = support::pair(101, 50, 7);
    let mut matcher = StereoMatcher::new(device, queue, 101, 50, left.format(), &params).unwrap();
    let before = matcher.compute_blocking(&left, &right).unwrap();
    assert!(before.labels.is_none() && before.right.is_some(), "a network has no labels");
    let unrounded = before.unrounded.as_ref().unwrap();
    let Unrounded { width, height, data } = unrounded;
    assert_eq!((*width, *height, data.len()), (101, 50, 101 * 50));
    let bytes = matcher.device_bytes();
    matcher.resize(40, 30).unwrap();
    let (small_left, small_right) = support::pair(40, 30, 7);
    matcher.compute_blocking(&small_left, &small_right).unwrap();
    matcher.resize(101, 50).unwrap();
    assert_eq!(matcher.compute_blocking(&left, &right).unwrap(), before);
    assert_eq!(matcher.device_bytes(), bytes);
    matcher.set_params(&Params { network: Some(tiny(4)), ..params.clone() }).unwrap();
    assert_ne!(matcher.compute_blocking(&left, &right).unwrap().unrounded, before.unrounded);
    assert_eq!(matcher.device_bytes(), bytes);
}

/// Options that may stand beside the method, and values of them.
const OPTIONS: &[(&str, &[&str])] = &[
    ("schedule", &["per-thread", "per-subgroup"]),
    ("align-corners", &["on", "off"]),
    ("shader-checks", &["off", "on"]),
    ("right-view", &["match"]),
    ("lr-check", &["off", "1"]),
    ("texture", &["off", "12"]),
    ("speckle-window", &["0", "9"]),
    ("median", &["off", "3", "5"]),
    ("fill", &["none", "background", "rays"]),
    ("weighted-median", &["off", "2"]),
    ("wls", &["off", "on"]),
];

/// Random settings beside the method: every stage is the reference.
#[test]
fn settings_beside_the_network() {
    const SEED: u64 = 8;
    let Some(setup) = support::device() else { return };
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let mut all = Vec::new();
    for case in 0..3 {
        let mut params = params(16, Schedule::PerThread);
        let mut chosen = Vec::new();
        for (name, values) in OPTIONS {
            let value = values.choose(&mut random).unwrap();
            chosen.push(format!("--{name} {value}"));
            params.set(name, value).unwrap();
        }
        params.confidence = false;
        let wrong = wrong(&setup, [61 + case, 33 - case], case % 4, &params);
        all.extend(wrong.iter().map(|wrong| format!("{chosen:?}, seed {SEED}: {wrong}")));
    }
    assert!(all.is_empty(), "{}", all.join("\n"));
}

/// `record` only records, and makes nothing on the device from the second frame on.
#[test]
fn a_frame_in_the_callers_encoder() {
    let Some((_, device, queue)) = support::device() else { return };
    let (left, right) = support::pair(48, 20, 7);
    let params = Params { lr_check: Some(1), ..params(16, Schedule::PerThread) };
    let matcher = StereoMatcher::new(&device, &queue, 48, 20, left.format(), &params).unwrap();
    let expected = matcher.compute_blocking(&left, &right).unwrap().map;
    let size = matcher.output().size();
    queue.write_buffer(matcher.output(), 0, &vec![0x5a; size as usize]);
    let read = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let copied = |record: &dyn Fn(&mut wgpu::CommandEncoder)| {
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        record(&mut encoder);
        encoder.copy_buffer_to_buffer(matcher.output(), 0, &read, 0, size);
        queue.submit([encoder.finish()]);
        read.map_async(wgpu::MapMode::Read, .., |result| result.unwrap());
        device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        let bytes = read.get_mapped_range(..).unwrap().to_vec();
        read.unmap();
        bytes
    };
    let frame = |encoder: &mut wgpu::CommandEncoder| {
        matcher.upload(&left, &right).unwrap();
        matcher.record(encoder, &Inputs::Uploaded, &Outputs::default()).unwrap();
    };
    let mut unused = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    frame(&mut unused);
    assert!(copied(&|_| ()).iter().all(|&byte| byte == 0x5a), "something was submitted");
    for round in 0..3 {
        let made = made::during(|| {
            let rows: Vec<i16> = bytemuck::pod_collect_to_vec(&copied(&|encoder| frame(encoder)));
            assert!(rows[..48 * 20] == expected.data[..], "frame {round}");
        });
        assert!(round == 0 || made == ["Device::create_command_encoder"], "frame {round}: {made:?}");
    }
}
