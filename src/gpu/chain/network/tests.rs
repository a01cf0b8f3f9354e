use crate::gpu::kernels::tests::{Setup, support};
use crate::network::tiny::tiny;
use crate::{Fill, Params, Schedule, StereoMatcher, Unrounded};

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

/// Volumes are written some channels at a time where a binding holds no more.
#[test]
fn volumes_beyond_a_binding_are_cut() {
    let setup = support::device_with(|_, limits| limits.max_storage_buffer_binding_size = 2 << 20);
    let Some(setup) = setup else { return };
    let all = wrong(&setup, [90, 40], 0, &params(128, Schedule::PerThread));
    assert!(all.is_empty(), "{}", all.join("\n"));
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
