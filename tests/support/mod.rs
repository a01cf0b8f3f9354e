//! What the tests share: a device, and pairs made from a seed.
#![allow(dead_code, unused_imports, clippy::unwrap_used, clippy::expect_used)]

use std::cell::RefCell;
use std::io::Write as _;
use std::sync::{LazyLock, Mutex, PoisonError};

use gpu_stereo::{Error, Image, Params, PixelFormat, Pixels, StageCheck, StereoMatcher, wgpu};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

mod feature_network;
pub use feature_network::feature_network;

/// One for all devices: those of several instances may seem equal.
static INSTANCE: LazyLock<wgpu::Instance> =
    LazyLock::new(|| wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env()));

/// A device, with features and limits changed by the test. `None` only where there is no adapter and the environment allows that.
pub fn device_with(
    change: impl FnOnce(&mut wgpu::Features, &mut wgpu::Limits),
) -> Option<(wgpu::Adapter, wgpu::Device, wgpu::Queue)> {
    let backends = wgpu::Backends::from_env().unwrap_or(wgpu::Backends::PRIMARY);
    let adapters = pollster::block_on(INSTANCE.enumerate_adapters(backends));
    let Some(adapter) = adapters.into_iter().next() else {
        assert!(
            std::env::var_os("GPU_STEREO_NO_ADAPTER").is_some(),
            "no adapter was found: install a Vulkan driver (Debian: mesa-vulkan-drivers), or set GPU_STEREO_NO_ADAPTER=1 \
             to go on without the tests that need one"
        );
        // Past libtest's capture, which hides what a passing test prints.
        let _ = writeln!(std::io::stderr(), "NOT TESTED: there is no adapter, and GPU_STEREO_NO_ADAPTER is set");
        return None;
    };
    let mut limits = gpu_stereo::StereoMatcher::required_limits(&adapter);
    let mut features = gpu_stereo::StereoMatcher::required_features(&adapter);
    change(&mut features, &mut limits);
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: features,
        required_limits: limits,
        ..Default::default()
    }))
    .expect("the adapter gives a device");
    Some((adapter, device, queue))
}

pub fn device() -> Option<(wgpu::Adapter, wgpu::Device, wgpu::Queue)> {
    device_with(|_, _| ())
}

/// A device without any feature: no subgroups, no 64-bit integers.
pub fn bare_device() -> Option<(wgpu::Adapter, wgpu::Device, wgpu::Queue)> {
    device_with(|features, _| *features = wgpu::Features::empty())
}

/// The first matcher of each device of a test, from which the others are made.
struct First(Vec<(wgpu::Device, StereoMatcher)>);

/// Those of tests that have ended: where a thread's own values are dropped, wgpu panics.
static ENDED: Mutex<Vec<(wgpu::Device, StereoMatcher)>> = Mutex::new(Vec::new());

impl Drop for First {
    fn drop(&mut self) {
        ENDED.lock().unwrap_or_else(PoisonError::into_inner).append(&mut self.0);
    }
}

thread_local! {
    static FIRST: RefCell<First> = const { RefCell::new(First(Vec::new())) };
}

/// A matcher as [`StereoMatcher::new`] makes it. Those of one device and one test compile each kernel once: a driver takes longer to
/// compile the kernels of a small pair than to run them.
pub fn matcher(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    (width, height): (u32, u32),
    format: PixelFormat,
    params: &Params,
) -> Result<StereoMatcher, Error> {
    let ended = std::mem::take(&mut *ENDED.lock().unwrap_or_else(PoisonError::into_inner));
    drop(ended);
    FIRST.with_borrow_mut(|First(all)| {
        if let Some((_, first)) = all.iter().find(|(known, _)| known == device) {
            return first.another(width, height, format, params);
        }
        let first = StereoMatcher::new(device, queue, width, height, format, params)?;
        let matcher = first.another(width, height, format, params);
        all.push((device.clone(), first));
        matcher
    })
}

/// A pair: smooth noise, the right image the left one shifted by disparities that change over the image, plus noise.
pub fn pair(width: u32, height: u32, seed: u64) -> (Image, Image) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (w, h) = (width as usize, height as usize);
    let coarse: Vec<u8> = (0..(w / 3 + 40) * (h / 3 + 2)).map(|_| random.random()).collect();
    let texture = |x: usize, y: usize| coarse[(y / 3) * (w / 3 + 40) + (x / 3) % (w / 3 + 40)];
    let image = |shift: usize, random: &mut ChaCha8Rng| {
        let mut samples = Vec::with_capacity(w * h);
        for y in 0..h {
            for x in 0..w {
                let near = usize::from(y > h / 3 && x > w / 3 && x < 2 * w / 3 + 1);
                samples.push(texture(x + shift * (2 + 5 * near), y).saturating_add(random.random_range(0..6)));
            }
        }
        Image::new(width, height, Pixels::Gray8(samples)).unwrap()
    };
    (image(0, &mut random), image(1, &mut random))
}

/// The same pair in another format.
pub fn as_format(image: &Image, format: u32) -> Image {
    let Pixels::Gray8(gray) = image.pixels() else { panic!("made from gray") };
    let pixels = match format {
        0 => Pixels::Gray8(gray.clone()),
        1 => {
            Pixels::Gray16(gray.iter().enumerate().map(|(i, &v)| u16::from(v) * 256 + (i * 37 % 256) as u16).collect())
        }
        2 => Pixels::Rgba8(gray.iter().enumerate().flat_map(|(i, &v)| [v, v ^ 85, (i % 251) as u8, 7]).collect()),
        _ => Pixels::Rgba16(
            gray.iter()
                .enumerate()
                .flat_map(|(i, &v)| [u16::from(v) * 257, (i * 997 % 65536) as u16, u16::from(v) * 9, 1])
                .collect(),
        ),
    };
    Image::new(image.width(), image.height(), pixels).unwrap()
}

/// Fails with the first mismatch of the first stage that has one.
pub fn assert_equal(checks: &[StageCheck], adapter: &wgpu::Adapter, case: &dyn std::fmt::Debug) {
    assert!(checks.len() >= 3, "only {} stages were compared: {checks:?}", checks.len());
    for check in checks {
        assert!(check.elements > 0, "stage {} compared nothing", check.stage);
        assert!(
            check.mismatches == 0,
            "stage {}: {} of {} elements differ from the reference, first {:?}, on {}, case {case:?}",
            check.stage,
            check.mismatches,
            check.elements,
            check.first,
            adapter.get_info().name,
        );
    }
}

/// Fails unless the native schedule gives `expected`, all maps of the reference.
#[track_caller]
pub fn assert_native(
    left: &Image,
    right: &Image,
    params: &Params,
    expected: &gpu_stereo::Matched,
    case: &dyn std::fmt::Debug,
) {
    let matcher = gpu_stereo::cpu::CpuMatcher::new(left.width(), left.height(), left.format(), params).unwrap();
    assert!(matcher.compute(left, right).unwrap() == *expected, "the native schedule differs, case {case:?}");
}

/// Fails with the first stage of the native schedule that differs from the reference.
#[track_caller]
pub fn check_native(left: &Image, right: &Image, params: &Params, case: &dyn std::fmt::Debug) {
    let matcher = gpu_stereo::cpu::CpuMatcher::new(left.width(), left.height(), left.format(), params).unwrap();
    for check in matcher.check(left, right).unwrap() {
        assert!(check.elements > 0, "stage {} compared nothing", check.stage);
        assert!(
            check.mismatches == 0,
            "stage {} of the native schedule: {} of {} elements differ from the reference, first {:?}, case {case:?}",
            check.stage,
            check.mismatches,
            check.elements,
            check.first
        );
    }
}

/// The costs that go with every method and block, and whose images are not matched in rounds: all but two.
pub fn costs() -> Vec<&'static str> {
    let cost = Params::OPTIONS.iter().find(|option| option.name == "cost").unwrap();
    cost.values
        .iter()
        .map(|(name, _)| *name)
        .filter(|name| !["ncc", "mi", "learned", "learned-census"].contains(name))
        .collect()
}

/// Parameters from a seed: every setting, every range.
pub fn random_params(random: &mut ChaCha8Rng) -> Params {
    use gpu_stereo::{Fill, Median, Paths, Prefilter, RightView, Schedule, Subpixel};
    let disparities = *[1, 2, 3, 7, 15, 16, 17, 31, 33, 48, 64, 65, 97, 130].get(random.random_range(0..14)).unwrap();
    let mut params = if random.random_bool(0.3) { Params::bm(disparities) } else { Params::sgm(disparities) };
    params.min_disparity = *[0, 0, 0, 1, 5, -1, -7, -40, 30].get(random.random_range(0..9)).unwrap();
    params.paths = [Paths::Three, Paths::Four, Paths::Five, Paths::Eight, Paths::Sixteen][random.random_range(0..5)];
    params.block = 2 * random.random_range(0..10) + 1;
    params.prefilter =
        [Prefilter::XSobel, Prefilter::Sobel, Prefilter::Normalized, Prefilter::None][random.random_range(0..4)];
    params.prefilter_cap = random.random_range(1..=127);
    params.p2 = random.random_range(0..=127);
    params.p1 = random.random_range(0..=params.p2);
    params.uniqueness = if random.random() { 0 } else { random.random_range(1..=99) };
    params.lr_check = if random.random_bool(0.3) { None } else { Some(random.random_range(0..4)) };
    params.median = if random.random_bool(0.3) { Median::Off } else { Median::Three };
    params.subpixel = [Subpixel::Off, Subpixel::Parabola, Subpixel::Equiangular][random.random_range(0..3)];
    params.shader_checks = random.random_bool(0.3);
    use gpu_stereo::{Census, Cost};
    const WINDOWS: [Census; 4] = [Census::Five, Census::Seven, Census::NineBySeven, Census::CentreSymmetric];
    if random.random_bool(0.7) {
        let costs = costs();
        params.set("cost", costs[random.random_range(0..costs.len())]).unwrap();
        params.census = WINDOWS[random.random_range(0..4)];
        params.prefilter_cap = random.random_range(1..=32);
        params.color_cost = matches!(params.cost, Cost::Sad | Cost::BirchfieldTomasi) && random.random();
        (params.ad_weight, params.census_weight) = (random.random_range(1..=64), random.random_range(0..=64));
    }
    params.prefilter_window = 2 * random.random_range(1..=25) + 1;
    params.schedule = [Schedule::Auto, Schedule::PerThread, Schedule::PerSubgroup][random.random_range(0..3)];
    params.confidence = random.random();
    if random.random_bool(0.3) {
        params.texture = random.random_range(0..=params.block * params.block * params.prefilter_cap / 2);
    }
    if random.random_bool(0.3) {
        params.median = Median::Five;
    }
    params.weighted_median_sigma = random.random_range(1..=255);
    if random.random_bool(0.4) {
        params.weighted_median = Some(random.random_range(1..=15));
    }
    if random.random_bool(0.3) {
        let lambda = *[0.0, 0.7, 50.0, 8000.0, 1e6].get(random.random_range(0..5)).unwrap();
        let sigma = *[0.1, 1.5, 1000.0].get(random.random_range(0..3)).unwrap();
        params.wls = Some(gpu_stereo::Wls::new(lambda, sigma));
    }
    params.speckle_window = if random.random_bool(0.7) { 0 } else { random.random_range(1..20) };
    params.speckle_range = random.random_range(0..4);
    params.fill = match random.random_range(0..10) {
        0..6 => Fill::None,
        6 => Fill::Background,
        7 => Fill::Rays,
        8 => Fill::WeightedRays,
        _ => Fill::Hirschmuller,
    };
    params.adaptive_p2 = random.random_bool(0.4);
    params.p2_step = random.random_range(1..=255);
    params.right_view = if random.random_bool(0.3) { RightView::Match } else { RightView::Diagonal };
    if random.random_bool(0.1) {
        (params.cost, params.color_cost) = (Cost::MutualInformation, false);
    }
    if params.method == gpu_stereo::Method::Bm && random.random_bool(0.2) {
        (params.cost, params.color_cost) = (Cost::Ncc, false);
        params.block = 2 * random.random_range(1..10) + 1;
    }
    if params.method == gpu_stereo::Method::Sgm && random.random_bool(0.25) {
        use gpu_stereo::Smoothness;
        params.method = gpu_stereo::Method::Bp;
        params.smoothness = [Smoothness::Linear, Smoothness::Quadratic, Smoothness::Potts][random.random_range(0..3)];
        (params.smoothness_weight, params.smoothness_truncation) =
            (random.random_range(0..40), random.random_range(0..=127));
        params.smoothness_edge = if random.random() { None } else { Some(random.random_range(1..80)) };
        (params.bp_levels, params.bp_iterations) = (random.random_range(1..=6), random.random_range(1..5));
        params.bp_reweighting = random.random_range(4..=16);
    }
    params.adaptive_p1 = random.random_bool(0.3);
    if random.random_bool(0.3) {
        params.passes = 2;
        params.passes = if params.validate().is_ok() { 2 } else { 1 };
    }
    params.right_map = random.random_bool(0.2);
    if random.random_bool(0.5) {
        let focal = *[1.0, 994.978, 1e6].get(random.random_range(0..3)).unwrap();
        let baseline = *[1e-6, 0.193001, 1000.0].get(random.random_range(0..3)).unwrap();
        let doffs = if random.random() { 0.0 } else { random.random_range(-50.0..50.0) };
        params.depth = Some(gpu_stereo::Camera::new(focal, baseline).with_doffs(doffs));
    }
    params
}

/// Cameras that are turned a little against each other, each with a lens of its own; the right one is a rational one.
pub fn lenses(width: u32, height: u32) -> [gpu_stereo::Lens; 2] {
    let (w, h) = (f64::from(width), f64::from(height));
    let turned = |a: f64, b: f64| {
        let ([sin_a, cos_a], [sin_b, cos_b]) = ([a.sin(), a.cos()], [b.sin(), b.cos()]);
        [cos_a, -sin_a, 0.0, cos_b * sin_a, cos_b * cos_a, -sin_b, sin_b * sin_a, sin_b * cos_a, cos_b]
    };
    let matrix = |f: f64, x: f64, y: f64| [f, 0.0, x, 0.0, f, y, 0.0, 0.0, 1.0];
    let pinhole = |numbers: &[f64]| gpu_stereo::Distortion::pinhole(numbers).unwrap();
    let lens = |distortion: &[f64], rotation: [f64; 9]| {
        let (matrix, projection) = (matrix(0.9 * w, 0.48 * w, 0.53 * h), matrix(0.95 * w, 0.5 * w, 0.5 * h));
        gpu_stereo::Lens::new(matrix, pinhole(distortion), rotation, projection)
    };
    let left = lens(&[-0.28, 0.09, 0.0011, -0.0004, 0.01], turned(0.011, -0.02));
    let right = lens(&[0.31, -0.2, -0.0007, 0.0009, 0.003, 0.6, -0.1, 0.02], turned(-0.008, 0.017));
    [left, right]
}

/// Masks with holes from a single pixel to half of the image, of the left image, of the right one or of both.
pub fn masks(width: u32, height: u32, seed: u64) -> gpu_stereo::Masks {
    let mut random = ChaCha8Rng::seed_from_u64(seed + 1000);
    let mut sides = [0, 1].map(|side| {
        let mut mask = vec![255u8; (width * height) as usize];
        for _ in 0..random.random_range(1..6) {
            let part = 1 << random.random_range(1..5);
            let [w, h] = [width, height].map(|side| random.random_range(1..=side.div_ceil(part)));
            let (x, y) = (random.random_range(0..=width - w), random.random_range(0..=height - h));
            for row in y..y + h {
                mask[(row * width + x) as usize..][..w as usize].fill(0);
            }
        }
        // Any other value stands for content.
        mask.iter_mut().filter(|value| **value != 0).for_each(|value| *value = random.random_range(1..=255));
        (seed % 3 != side).then_some(mask)
    });
    if width > 8 && seed.is_multiple_of(5) {
        let shown = |i: usize| u8::from(i as u32 % width < width - 3);
        sides[0] = Some((0..(width * height) as usize).map(shown).collect());
    }
    gpu_stereo::Masks::new(width, height, sides).unwrap()
}

/// A texture of the caller's, whose views may be with sRGB or without.
pub fn texture(
    device: &wgpu::Device,
    (width, height): (u32, u32),
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[format.add_srgb_suffix(), format.remove_srgb_suffix()],
    })
}

/// Pseudorandom, 0 to 65535: docs/VECTORS.md.
pub fn mixed(x: u32, y: u32, c: u32) -> u32 {
    let h = x
        .wrapping_mul(374_761_393)
        .wrapping_add(y.wrapping_mul(668_265_263))
        .wrapping_add(c.wrapping_mul(2_246_822_519));
    let h = (h ^ (h >> 15)).wrapping_mul(2_654_435_761);
    let h = (h ^ (h >> 13)).wrapping_mul(3_266_489_917);
    (h ^ (h >> 16)) & 0xffff
}
