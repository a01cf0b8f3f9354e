//! Nothing is made on the device from the second frame on, by wgpu's own log of what it makes. A test binary of its own,
//! since a program has one logger.
#![allow(clippy::unwrap_used)]

mod support;

use std::collections::BTreeMap;
use std::sync::Mutex;

use gpu_stereo::{Inputs, Outputs, Params, PixelBuffer, PixelFormat, StereoMatcher, wgpu};
use wgpu::{BufferUsages, TextureFormat, TextureUsages};

/// How often each call that makes something was logged since this was last emptied.
struct Made(Mutex<BTreeMap<String, u32>>);

static MADE: Made = Made(Mutex::new(BTreeMap::new()));

impl log::Log for Made {
    fn enabled(&self, metadata: &log::Metadata<'_>) -> bool {
        metadata.target().starts_with("wgpu_core")
    }

    fn log(&self, record: &log::Record<'_>) {
        if !self.enabled(record.metadata()) {
            return;
        }
        let text = record.args().to_string();
        let call = text.split(|c: char| c != ':' && c != '_' && !c.is_ascii_alphanumeric()).next().unwrap();
        if call.starts_with("Device::create_") || call.starts_with("Texture::create_") {
            *self.0.lock().unwrap().entry(call.into()).or_default() += 1;
        }
    }

    fn flush(&self) {}
}

/// What was made since the last call.
fn made() -> BTreeMap<String, u32> {
    std::mem::take(&mut *MADE.0.lock().unwrap())
}

const FRAMES: u32 = 100;

#[test]
fn a_frame_after_the_first_makes_nothing() {
    log::set_logger(&MADE).unwrap();
    log::set_max_level(log::LevelFilter::Trace);
    let Some((_, device, queue)) = support::device() else { return };
    let (width, height) = (48, 20);
    let (left, right) = support::pair(width, height, 1);
    let mut params = Params::sgm(16);
    params.confidence = true;
    let texture = |format, usage| support::texture(&device, (width, height), format, usage);
    // Three pairs in turn, as the pictures of a camera come.
    let pairs = [(); 3].map(|()| [(); 2].map(|()| texture(TextureFormat::R8Unorm, TextureUsages::TEXTURE_BINDING)));
    let pixels = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(width * height),
        usage: BufferUsages::STORAGE,
        mapped_at_creation: false,
    });
    let pixels = PixelBuffer::new(&pixels, 0, width);
    let copy = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(width * height * 3),
        usage: BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let draw = TextureUsages::RENDER_ATTACHMENT;
    let disparity = [TextureFormat::R32Float, TextureFormat::R16Sint].map(|format| texture(format, draw));
    let color = texture(TextureFormat::Rgba8Unorm, TextureUsages::STORAGE_BINDING);
    let confidence = texture(TextureFormat::R8Unorm, draw);
    let maps = u64::from(height * width.next_multiple_of(8) * 2);
    let all = Outputs::default().color(&color).confidence(&confidence).confidence_buffer(&copy, maps).buffer(&copy, 0);

    made();
    let matcher = StereoMatcher::new(&device, &queue, width, height, PixelFormat::Gray8, &params).unwrap();
    let by_new = made();
    // Another matcher compiles what this one has not, and no more.
    let another = matcher.another(33, 21, PixelFormat::Gray8, &params).unwrap();
    let by_another = made();
    assert!(by_another.contains_key("Device::create_buffer"), "{by_another:?}");
    for kind in ["shader_module", "compute_pipeline"] {
        assert!(!by_another.contains_key(&format!("Device::create_{kind}")), "{by_another:?}");
    }
    let mut other = params.clone();
    other.shader_checks = true;
    another.another(33, 21, PixelFormat::Gray8, &other).unwrap();
    assert!(made().contains_key("Device::create_compute_pipeline"), "the guards are another kernel's");
    let frame = || {
        for pair in &pairs {
            for target in &disparity {
                let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                let inputs = Inputs::textures(&pair[0], &pair[1]);
                matcher.record(&mut encoder, &inputs, &all.disparity(target)).unwrap();
                queue.submit([encoder.finish()]);
            }
        }
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        matcher.record(&mut encoder, &Inputs::buffers(pixels, pixels), &all).unwrap();
        matcher.upload(&left, &right).unwrap();
        matcher.record(&mut encoder, &Inputs::Uploaded, &Outputs::default()).unwrap();
        queue.submit([encoder.finish()]);
        device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    };
    frame();
    let by_first = made();
    // The counter counts: the kinds that must not be made were made before.
    for kind in ["buffer", "texture", "bind_group", "compute_pipeline"] {
        assert!(by_new.contains_key(&format!("Device::create_{kind}")), "{kind} is not counted: {by_new:?}");
    }
    for kind in
        ["Device::create_buffer", "Device::create_bind_group", "Device::create_render_pipeline", "Texture::create_view"]
    {
        assert!(by_first.contains_key(kind), "{kind} is not counted: {by_first:?}");
    }

    (0..FRAMES).for_each(|_| frame());
    let mut after = made();
    assert_eq!(after.remove("Device::create_command_encoder"), Some(7 * FRAMES), "the caller's encoders");
    assert!(after.is_empty(), "made over {FRAMES} frames after the first: {after:?}");

    // What is forgotten is made again, once.
    matcher.forget_resources();
    frame();
    let again = made();
    assert!(again.contains_key("Device::create_bind_group"), "{again:?}");
    assert!(!again.contains_key("Device::create_render_pipeline"), "{again:?}");
}
