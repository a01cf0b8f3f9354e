//! Stages after the winner on maps that are given, such as no pair of images leaves.

use crate::gpu::kernels::tests::{Setup, support};
use crate::gpu::maps::map_of;
use crate::gpu::readback;
use crate::gpu::recording::{Written, record_steps};
use crate::reference::Plane;
use crate::{DisparityMap, Fill, Median, Params, PixelFormat, Schedule, reference};

const INVALID: i16 = DisparityMap::INVALID;

fn map(width: u32, height: u32, value: impl Fn(u32, u32) -> i16) -> DisparityMap {
    let data = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| value(x, y)).collect();
    DisparityMap { width, height, data }
}

/// Runs the steps of one stage, of a matcher that has no other after the winner, on the views given.
fn run(setup: &Setup, params: &Params, stage: &str, left: &DisparityMap, right: &DisparityMap) -> DisparityMap {
    let (_, device, queue) = setup;
    let params = Params { lr_check: None, median: Median::Off, ..params.clone() };
    let matcher = support::matcher(device, queue, (left.width, left.height), PixelFormat::Gray8, &params).unwrap();
    let views = matcher.steps.iter().rposition(|step| matches!(step.written, Written::Views { .. })).unwrap();
    let stride = 2 * matcher.sizes.frame.map_stride as usize;
    let Written::Views { right: behind, .. } = &matcher.steps[views].written else { unreachable!() };
    for (buffer, map) in [(&matcher.steps[views].buffer, left), (behind, right)] {
        // The padding is what no kernel may take for a pixel.
        let mut bytes = Vec::new();
        for row in map.data.chunks(left.width as usize) {
            let padding = std::iter::repeat_n(&row[row.len() - 1], stride - row.len());
            bytes.extend(row.iter().chain(padding).flat_map(|value| value.to_le_bytes()));
        }
        queue.write_buffer(buffer, 0, &bytes);
    }
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    matcher.steps[views].record_copy(&mut encoder);
    for steps in matcher.steps[views + 1..].split_inclusive(|step| step.copy_to.is_some()) {
        assert!(steps.iter().all(|step| step.stage() == stage));
        record_steps(&mut encoder, stage, steps, None);
    }
    queue.submit([encoder.finish()]);
    let last = &matcher.steps[matcher.steps.len() - 1].buffer;
    let copy = readback::copy(device, queue, &matcher.waiter, last, matcher.sizes.map);
    let bytes = readback::block_on(copy).unwrap();
    map_of(&matcher.sizes.frame, &bytes)
}

/// A device of which a binding holds so few KiB that maps are worked on by lots of 64 rows or a few of them, and trees, with 28,
/// lie in up to four parts.
fn small_device(kibibytes: u64) -> Option<Setup> {
    support::device_with(|_, limits| limits.max_storage_buffer_binding_size = kibibytes << 10)
}

fn noise() -> impl FnMut() -> u32 {
    let mut state = 1u32;
    move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state >> 16
    }
}

fn speckle(setup: &Setup, map: &DisparityMap, window: u32, range: u32) {
    let expected = reference::speckle(map, window, range);
    for shader_checks in [false, true] {
        // The other schedule takes no rows of that length with checks.
        let base = Params { block: 1, shader_checks, schedule: Schedule::PerSubgroup, ..Params::bm(1) };
        let params = Params { speckle_window: window, speckle_range: range, ..base };
        let got = run(setup, &params, "speckle", map, map);
        let wrong = got.data.iter().zip(&expected.data).filter(|(a, b)| a != b).count();
        let (width, height) = (map.width, map.height);
        assert!(wrong == 0, "{wrong} pixels of {width}x{height}, window {window}, range {range}, {shader_checks}");
    }
}

/// The square spiral of walls two pixels apart, as the path that winds between them.
fn spiral(size: u32) -> DisparityMap {
    let mut map = map(size, size, |_, _| INVALID);
    let (mut x, mut y, mut dx, mut dy) = (0i64, 0i64, 1i64, 0i64);
    let size = i64::from(size);
    let free = |map: &DisparityMap, x: i64, y: i64| {
        (0..size).contains(&x) && (0..size).contains(&y) && map.data[(y * size + x) as usize] == INVALID
    };
    let far = |map: &DisparityMap, x: i64, y: i64| {
        !(0..size).contains(&x) || !(0..size).contains(&y) || map.data[(y * size + x) as usize] == INVALID
    };
    for value in 0.. {
        map.data[(y * size + x) as usize] = value % 7;
        let goes = |map: &DisparityMap, dx: i64, dy: i64| free(map, x + dx, y + dy) && far(map, x + 2 * dx, y + 2 * dy);
        if !goes(&map, dx, dy) {
            (dx, dy) = (-dy, dx);
            if !goes(&map, dx, dy) {
                return map;
            }
        }
        (x, y) = (x + dx, y + dy);
    }
    map
}

/// Pixels of a region on a map: `all` and `all - 1` are where a filter of this window changes its mind.
fn speckle_around(setup: &Setup, map: &DisparityMap, range: u32) {
    let all = map.data.iter().filter(|&&value| value != INVALID).count() as u32;
    for window in [all, all - 1] {
        speckle(setup, map, window, range);
    }
}

/// Regions whose parts meet late: spirals, combs with their backs above, below and at each side, snakes along rows and
/// columns, stairs, a chessboard, one region, none.
#[test]
fn speckle_of_winding_regions() {
    let Some(setup) = support::device() else { return };
    for size in [2, 33, 64, 131] {
        speckle_around(&setup, &spiral(size), 1);
    }
    winding_regions(&setup, 203, 77);
}

/// The same through several parts and lots.
#[test]
fn speckle_of_regions_in_parts() {
    let Some(setup) = small_device(28) else { return };
    for size in [91, 107] {
        speckle_around(&setup, &spiral(size), 1);
    }
    for (width, height) in [(93, 170), (40, 401)] {
        winding_regions(&setup, width, height);
    }
}

fn winding_regions(setup: &Setup, width: u32, height: u32) {
    let (right, bottom) = (width - 1, height - 1);
    let shapes: [&dyn Fn(u32, u32) -> bool; 10] = [
        &|x, y| x % 2 == 0 || y == 0,
        &|x, y| x % 2 == 0 || y == bottom,
        &|x, y| y % 2 == 0 || x == 0,
        &|x, y| y % 2 == 0 || x == right,
        &|x, y| y % 2 == 0 || x == if y % 4 == 1 { 0 } else { right },
        &|x, y| x % 2 == 0 || y == if x % 4 == 1 { 0 } else { bottom },
        &|x, y| (x + y) % 4 < 2,
        &|x, y| (x + height - y) % 4 < 2,
        &|_, _| true,
        // Teeth from above and from below, which the last row of each lot of four joins.
        &|x, y| x % 2 == 0 || (y % 4 == 3 && x % 4 == if y % 8 == 3 { 1 } else { 3 }),
    ];
    for shape in shapes {
        speckle_around(setup, &map(width, height, |x, y| if shape(x, y) { 40 } else { INVALID }), 0);
    }
    speckle(setup, &map(width, height, |x, y| if (x + y) % 2 == 0 { 40 } else { INVALID }), 1, 0);
    speckle(setup, &map(width, height, |_, _| INVALID), 9, 1);
}

/// Steps of 16 and 17 between neighbours, up to the largest there is; and noise, whose regions have every size.
#[test]
fn speckle_of_steps_and_noise() {
    let Some(setup) = support::device() else { return };
    let mut noise = noise();
    for (width, height) in [(1, 1), (1, 70), (70, 1), (8, 8), (9, 5), (129, 63)] {
        for levels in [2, 3, 5] {
            let mut noisy = map(width, height, |_, _| 0);
            noisy.data.iter_mut().for_each(|value| {
                *value = match noise() % (levels + 1) {
                    0 => INVALID,
                    level => 17 * level as i16 - (noise() % 2) as i16,
                }
            });
            for (window, range) in [(1, 1), (2, 1), (7, 0), (40, 2), (i32::MAX as u32, 3)] {
                speckle(&setup, &noisy, window, range);
            }
        }
    }
    let extremes = map(21, 9, |x, y| if (x / 3 + y / 2) % 2 == 0 { -32752 } else { 32752 });
    for range in [4093, 4094, 4095] {
        speckle(&setup, &extremes, 100, range);
    }
}

/// Noise whose regions of every size lie in several parts.
#[test]
fn speckle_of_noise_in_parts() {
    let Some(setup) = small_device(28) else { return };
    let mut noise = noise();
    for levels in [1, 2, 4] {
        let mut noisy = map(61, 233, |_, _| 0);
        noisy.data.iter_mut().for_each(|value| {
            *value = if noise().is_multiple_of(5) { INVALID } else { 17 * (noise() % levels) as i16 };
        });
        for (window, range) in [(2, 1), (40, 1), (5000, 0)] {
            speckle(&setup, &noisy, window, range);
        }
    }
}

/// Rows and columns of tens of thousands of pixels: no invocation walks farther than the driver lets it, not even with
/// rows of as many trees as pixels.
#[test]
fn speckle_of_long_maps() {
    let Some(setup) = support::device() else { return };
    for (width, height) in [(60_000, 3), (3, 60_000)] {
        let valid = |x: u32, y: u32| if width > height { y != 1 || x == width - 1 } else { x != 1 || y == height - 1 };
        speckle_around(&setup, &map(width, height, |x, y| if valid(x, y) { 5 } else { INVALID }), 0);
    }
    // Above, no pixel joins its neighbour; below, all do.
    let teeth = map(5000, 2, |x, y| if y == 1 { 16 } else { 32 * (x % 2) as i16 });
    speckle_around(&setup, &teeth, 1);
    let teeth = map(5000, 2, |x, y| if y == 0 { 16 } else { 32 * (x % 2) as i16 });
    speckle_around(&setup, &teeth, 1);
}

fn fill(setup: &Setup, left: &DisparityMap, right: &DisparityMap, lr_check: Option<u32>) {
    for (fill, shader_checks) in [Fill::Background, Fill::Rays, Fill::WeightedRays, Fill::Hirschmuller]
        .into_iter()
        .zip([false, true, true, false])
    {
        let base = Params { block: 1, shader_checks, schedule: Schedule::PerSubgroup, ..Params::bm(40) };
        let params = Params { fill, min_disparity: -3, ..base };
        let got = run(setup, &params, "fill", left, right);
        // Nothing has written the gray image, so its pixels are alike.
        let gray = Plane { width: left.width as usize, height: left.height as usize, data: vec![0; left.data.len()] };
        // `run` switches the check off, which means 1 px here.
        let expected = reference::fill(left, right, &gray, &Params { lr_check, ..params });
        let wrong = got.data.iter().zip(&expected.data).filter(|(a, b)| a != b).count();
        assert!(wrong == 0, "{wrong} pixels of {}x{}, {fill:?}", left.width, left.height);
        let any = left.data.iter().any(|&value| value != INVALID);
        assert!(got.data.iter().all(|&value| (value == INVALID) != any), "{fill:?} leaves holes");
    }
}

#[test]
fn fill_of_holes() {
    let Some(setup) = support::device() else { return };
    holes(&setup, &[(1, 1), (1, 70), (70, 1), (8, 8), (9, 5), (129, 63), (61, 203)]);
}

/// The same of maps that are worked on by lots of rows.
#[test]
fn fill_of_holes_by_lots() {
    let Some(setup) = small_device(57) else { return };
    holes(&setup, &[(61, 203), (1, 1900), (97, 131)]);
}

/// Holes of every size: noise that is almost full or almost empty, a valid pixel alone, rows without any, none at all.
fn holes(setup: &Setup, sizes: &[(u32, u32)]) {
    let mut noise = noise();
    for &(width, height) in sizes {
        let mut right = map(width, height, |_, _| INVALID);
        right.data.iter_mut().for_each(|value| {
            *value = if noise().is_multiple_of(3) { INVALID } else { 16 * ((noise() % 50) as i16 - 5) }
        });
        for holes in [1, 3, 30, 300] {
            let mut left = map(width, height, |_, _| INVALID);
            left.data.iter_mut().for_each(|value| {
                *value = if noise().is_multiple_of(holes + 1) { (noise() % 640) as i16 - 50 } else { INVALID }
            });
            fill(setup, &left, &right, None);
            let rows =
                map(
                    width,
                    height,
                    |x, y| {
                        if y % 5 < 2 || y > 50 { INVALID } else { left.data[(y * width + x) as usize] }
                    },
                );
            fill(setup, &rows, &right, None);
        }
        for (alone, x, y) in [(0, 0, 0), (5, width - 1, height - 1), (-9, width / 2, height / 3)] {
            fill(setup, &map(width, height, |i, j| if (i, j) == (x, y) { alone } else { INVALID }), &right, None);
        }
        fill(setup, &map(width, height, |_, _| INVALID), &right, None);
    }
}

/// Rows and columns of tens of thousands of pixels.
#[test]
fn fill_of_long_maps() {
    let Some(setup) = support::device() else { return };
    for (width, height) in [(60_000, 2), (2, 60_000)] {
        let right = map(width, height, |x, y| 16 * ((x + y) % 41) as i16);
        fill(&setup, &map(width, height, |x, y| if (x + y) % 200 == 0 { 7 } else { INVALID }), &right, None);
    }
}
