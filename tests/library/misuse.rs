//! What a program may do wrong with the matcher, and in which order: the maps are right, or an error names the mistake and a
//! remedy that fits it. Nothing panics, nothing hangs, nothing reaches the caller's error handler.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, mpsc};
use std::time::Duration;

use crate::support;
use gpu_stereo::{
    Cost, Error, Fill, Image, Inputs, Matched, Outputs, Params, PixelBuffer, PixelFormat, StereoMatcher, StereoStream,
    TextureLayer, Wls, reference, wgpu,
};
use wgpu::{BufferUsages, TextureFormat, TextureUsages};

/// A device whose errors that reach the caller are counted.
struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    heard: Arc<AtomicU32>,
}

impl Gpu {
    fn of(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        let heard = Arc::new(AtomicU32::new(0));
        let count = heard.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            eprintln!("heard: {error}");
            count.fetch_add(1, Ordering::Relaxed);
        }));
        Self { device, queue, heard }
    }

    fn new() -> Option<Self> {
        support::device().map(|(_, device, queue)| Self::of(device, queue))
    }

    /// Another device of the same adapter.
    fn two_of_an_instance() -> Option<[Self; 2]> {
        let (adapter, device, queue) = support::device()?;
        let descriptor =
            wgpu::DeviceDescriptor { required_limits: StereoMatcher::required_limits(&adapter), ..Default::default() };
        let (other, other_queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
        Some([Self::of(device, queue), Self::of(other, other_queue)])
    }

    fn matcher(&self, size: (u32, u32), params: &Params) -> StereoMatcher {
        StereoMatcher::new(&self.device, &self.queue, size.0, size.1, PixelFormat::Gray8, params).unwrap()
    }

    fn texture(&self, size: (u32, u32), format: TextureFormat, usage: TextureUsages) -> wgpu::Texture {
        support::texture(&self.device, size, format, usage)
    }

    fn filled(&self, image: &Image) -> wgpu::Texture {
        let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
        let texture = self.texture((image.width(), image.height()), TextureFormat::R8Unorm, usage);
        let gpu_stereo::Pixels::Gray8(bytes) = image.pixels() else { panic!("not gray") };
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(image.width()), rows_per_image: None };
        self.queue.write_texture(texture.as_image_copy(), bytes, layout, texture.size());
        texture
    }

    fn buffer(&self, size: u64, usage: BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
    }

    /// A buffer for a copy of a map.
    fn copy_of(&self, (width, height): (u32, u32)) -> wgpu::Buffer {
        let size = u64::from(2 * width).next_multiple_of(16) * u64::from(height);
        self.buffer(size, BufferUsages::COPY_DST | BufferUsages::COPY_SRC)
    }

    /// The map in a buffer.
    fn map_in(&self, buffer: &wgpu::Buffer, (width, height): (u32, u32)) -> Vec<i16> {
        let staging = self.buffer(buffer.size(), BufferUsages::MAP_READ | BufferUsages::COPY_DST);
        let mut encoder = self.encoder();
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, buffer.size());
        self.queue.submit([encoder.finish()]);
        staging.map_async(wgpu::MapMode::Read, .., |result| result.unwrap());
        self.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        let bytes = staging.get_mapped_range(..).unwrap().to_vec();
        let rows = bytes.chunks_exact((2 * width as usize).next_multiple_of(16)).take(height as usize);
        let values = rows.flat_map(|row| row[..2 * width as usize].chunks_exact(2));
        values.map(|v| i16::from_le_bytes([v[0], v[1]])).collect()
    }

    fn encoder(&self) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }

    /// Nothing reached the caller's error handler.
    fn heard_nothing(&self) {
        assert_eq!(self.heard.load(Ordering::Relaxed), 0, "errors reached the caller's handler");
    }
}

fn expected(pair: &(Image, Image), params: &Params) -> Vec<i16> {
    reference::compute(&pair.0, &pair.1, params).unwrap().data
}

fn says(error: &Error, parts: &[&str]) {
    let text = error.to_string();
    assert!(!text.contains('\n') && text.contains("; "), "no line, or no remedy: {text}");
    assert!(parts.iter().all(|part| text.contains(part)), "{text:?} does not say {parts:?}");
}

/// Settings whose uniforms and tables differ.
fn settings() -> [Params; 4] {
    let mut tables = Params::sgm(16);
    (tables.wls, tables.fill) = (Some(Wls::new(8000.0, 1.5)), Fill::None);
    let mut other = Params::sgm(16);
    (other.wls, other.p1, other.p2) = (Some(Wls::new(500.0, 4.0)), 3, 20);
    let mut information = Params::bm(9);
    (information.cost, information.min_disparity) = (Cost::MutualInformation, -2);
    [tables, other, information, Params::sgm(24)]
}

/// A recording keeps what it was recorded with: whatever is set, resized, uploaded, computed or dropped before it is
/// submitted, and in whatever order the recordings are submitted.
#[test]
fn what_was_recorded_is_what_is_computed() {
    let Some(gpu) = Gpu::new() else { return };
    let sizes = [(40, 22), (40, 22), (31, 15), (52, 30)];
    let pairs: Vec<_> = (0..).zip(sizes).map(|(seed, (width, height))| support::pair(width, height, seed)).collect();
    for uploaded in [false, true] {
        for backwards in [false, true] {
            let mut matcher = gpu.matcher(sizes[0], &settings()[0]);
            let mut recorded = Vec::new();
            for ((pair, size), params) in pairs.iter().zip(sizes).zip(settings()) {
                if <(u32, u32)>::from(matcher.size()) != size {
                    matcher.resize(size.0, size.1).unwrap();
                }
                matcher.set_params(&params).unwrap();
                let textures = [gpu.filled(&pair.0), gpu.filled(&pair.1)];
                let inputs = if uploaded {
                    matcher.upload(&pair.0, &pair.1).unwrap();
                    Inputs::Uploaded
                } else {
                    Inputs::textures(&textures[0], &textures[1])
                };
                let copy = gpu.copy_of(size);
                let mut encoder = gpu.encoder();
                matcher.record(&mut encoder, &inputs, &Outputs::default().buffer(&copy, 0)).unwrap();
                recorded.push((encoder.finish(), copy, size, expected(pair, &params)));
                // Another pair, by other ways.
                matcher.upload(&pair.1, &pair.0).unwrap();
                let other = (pair.1.clone(), pair.0.clone());
                assert_eq!(matcher.compute_blocking(&other.0, &other.1).unwrap().map.data, expected(&other, &params));
            }
            drop(matcher);
            if backwards {
                recorded.reverse();
            }
            for (commands, copy, size, expected) in recorded {
                gpu.queue.submit([commands]);
                let case = format!("{size:?}, uploaded {uploaded}, backwards {backwards}");
                assert!(gpu.map_in(&copy, size) == expected, "{case}");
            }
        }
    }
    gpu.heard_nothing();
}

/// Several settings and pairs in one encoder.
#[test]
fn one_encoder_holds_frames_of_several_settings() {
    let Some(gpu) = Gpu::new() else { return };
    let size = (37, 19);
    let mut matcher = gpu.matcher(size, &settings()[0]);
    let mut encoder = gpu.encoder();
    let mut frames = Vec::new();
    for (seed, params) in (0..).zip(settings()) {
        matcher.set_params(&params).unwrap();
        for seed in [seed, seed + 10] {
            let pair = support::pair(size.0, size.1, seed);
            matcher.upload(&pair.0, &pair.1).unwrap();
            let copy = gpu.copy_of(size);
            matcher.record(&mut encoder, &Inputs::Uploaded, &Outputs::default().buffer(&copy, 0)).unwrap();
            frames.push((copy, expected(&pair, &params), seed));
        }
    }
    gpu.queue.submit([encoder.finish()]);
    for (copy, expected, seed) in frames {
        assert!(gpu.map_in(&copy, size) == expected, "seed {seed}");
    }
    gpu.heard_nothing();
}

/// A stream and a recording of its matcher.
#[test]
fn a_stream_leaves_a_recording_alone() {
    let Some(gpu) = Gpu::new() else { return };
    let size = (44, 21);
    let params = settings();
    let mut stream = StereoStream::new(gpu.matcher(size, &params[0]), 2).unwrap();
    let [first, second] = [1, 2].map(|seed| support::pair(size.0, size.1, seed));
    let copy = gpu.copy_of(size);
    let mut encoder = gpu.encoder();
    stream.matcher().upload(&first.0, &first.1).unwrap();
    stream.matcher().record(&mut encoder, &Inputs::Uploaded, &Outputs::default().buffer(&copy, 0)).unwrap();
    stream.try_push(&second.0, &second.1).unwrap().unwrap();
    stream.set_params(&params[1]).unwrap();
    stream.try_push(&second.0, &second.1).unwrap().unwrap();
    gpu.queue.submit([encoder.finish()]);
    for params in &params[..2] {
        let frame = stream.next_blocking().unwrap().result.unwrap();
        assert_eq!(frame.map.data, expected(&second, params));
    }
    assert!(gpu.map_in(&copy, size) == expected(&first, &params[0]));
    gpu.heard_nothing();
}

/// What nothing was recorded for is not read, and what was recorded and not submitted has no disparities.
#[test]
fn nothing_is_read_that_was_not_computed() {
    let Some(gpu) = Gpu::new() else { return };
    let size = (30, 12);
    let pair = support::pair(size.0, size.1, 3);
    let mut params = Params::sgm(16);
    (params.right_map, params.confidence) = (true, true);
    let mut matcher = gpu.matcher(size, &params);
    let unread = |matcher: &StereoMatcher| {
        let error = matcher.read_blocking().unwrap_err();
        assert!(matches!(error, Error::Misuse(_)), "{error:?}");
        says(&error, &["no map", "present settings", "compute"]);
    };
    let unfed = |matcher: &StereoMatcher| {
        let error = matcher.record(&mut gpu.encoder(), &Inputs::Uploaded, &Outputs::default()).unwrap_err();
        assert!(matches!(error, Error::Misuse(_)), "{error:?}");
        says(&error, &["no pair", "upload"]);
    };
    unread(&matcher);
    unfed(&matcher);
    matcher.compute_blocking(&pair.0, &pair.1).unwrap();
    assert_eq!(matcher.read_blocking().unwrap().map.data, expected(&pair, &params));
    unfed(&matcher);

    matcher.upload(&pair.0, &pair.1).unwrap();
    for change in 0..3 {
        match change {
            0 => matcher.resize(20, 10).unwrap(),
            1 => matcher.resize(30, 12).unwrap(),
            _ => matcher.set_params(&params).unwrap(),
        }
        unread(&matcher);
        if change == 0 {
            unfed(&matcher); // the pair has another size
        } else {
            let mut encoder = gpu.encoder();
            matcher.record(&mut encoder, &Inputs::Uploaded, &Outputs::default()).unwrap();
            let Matched { map, right, confidence, .. } = matcher.read_blocking().unwrap();
            assert!(map.valid_fraction() == 0.0 && right.unwrap().valid_fraction() == 0.0, "change {change}");
            assert!(confidence.unwrap().data.iter().all(|&value| value == 0), "change {change}");
            gpu.queue.submit([encoder.finish()]);
            assert_eq!(matcher.read_blocking().unwrap().map.data, expected(&pair, &params), "change {change}");
        }
    }
    let mut reading = matcher.read();
    while reading.try_take().is_none() {}
    assert!(reading.try_take().is_none());
    let error = reading.wait_blocking().unwrap_err();
    assert!(matches!(error, Error::Misuse(_)), "{error:?}");
    says(&error, &["taken before", "read once more"]);
    gpu.heard_nothing();
}

/// After the first frames no buffer is made for uploads, recordings and changes whose work is done.
#[test]
fn what_is_done_is_used_again() {
    let Some(gpu) = Gpu::new() else { return };
    let size = (40, 20);
    let pair = support::pair(size.0, size.1, 3);
    let mut matcher = gpu.matcher(size, &Params::sgm(16));
    let frame = |matcher: &StereoMatcher| {
        matcher.upload(&pair.0, &pair.1).unwrap();
        let mut encoder = gpu.encoder();
        matcher.record(&mut encoder, &Inputs::Uploaded, &Outputs::default()).unwrap();
        gpu.queue.submit([encoder.finish()]);
        gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    };
    frame(&matcher);
    let bytes = matcher.device_bytes();
    for i in 0..6 {
        frame(&matcher);
        assert_eq!(matcher.device_bytes(), bytes, "frame {i}");
        drop({
            let mut encoder = gpu.encoder(); // never submitted
            matcher.record(&mut encoder, &Inputs::Uploaded, &Outputs::default()).unwrap();
            encoder
        });
        matcher.set_params(&Params::sgm(16)).unwrap();
        assert_eq!(matcher.device_bytes(), bytes, "change {i}");
    }
    gpu.heard_nothing();
}

/// Every public call on a lost device says so; none hangs, panics, or gives a map.
#[test]
fn a_lost_device_is_said_by_every_call() {
    let (done, hangs) = mpsc::channel();
    let test = std::thread::spawn(move || {
        lost_device();
        let _ = done.send(());
    });
    if hangs.recv_timeout(Duration::from_secs(120)) == Err(mpsc::RecvTimeoutError::Timeout) {
        panic!("a call on a lost device hangs");
    }
    test.join().unwrap();
}

fn lost_device() {
    let Some(gpu) = Gpu::new() else { return };
    let size = (40, 20);
    let (left, right) = support::pair(size.0, size.1, 3);
    let params = Params::sgm(16);
    let mut matcher = gpu.matcher(size, &params);
    let mut stream = StereoStream::new(gpu.matcher(size, &params), 2).unwrap();
    let textures = [gpu.filled(&left), gpu.filled(&right)];
    let target = gpu.texture(size, TextureFormat::R32Float, TextureUsages::RENDER_ATTACHMENT);
    let pixels = gpu.buffer(4096, BufferUsages::STORAGE);
    let pixels = PixelBuffer::new(&pixels, 0, size.0);
    let copy = gpu.copy_of(size);
    let inputs = [Inputs::Uploaded, Inputs::textures(&textures[0], &textures[1]), Inputs::buffers(pixels, pixels)];
    let outputs = Outputs::default().disparity(&target).buffer(&copy, 0);
    matcher.upload(&left, &right).unwrap();
    // Everything is made, so that nothing has to be made on the lost device.
    for _ in 0..3 {
        let mut encoder = gpu.encoder();
        inputs.iter().for_each(|inputs| matcher.record(&mut encoder, inputs, &outputs).unwrap());
        gpu.queue.submit([encoder.finish()]);
        stream.try_push(&left, &right).unwrap().unwrap();
        stream.next_blocking().unwrap().result.unwrap();
    }
    matcher.compute_timed_blocking(&left, &right).unwrap();
    let mut old_encoder = gpu.encoder();
    stream.try_push(&left, &right).unwrap().unwrap();
    stream.try_push(&left, &right).unwrap().unwrap();
    let readings = [(); 3].map(|()| matcher.read());

    gpu.device.destroy();
    let mut calls: Vec<(String, Option<Error>)> = Vec::new();
    for round in 0..2 {
        let mut call = |name: &str, error: Option<Error>| calls.push((format!("{name}, round {round}"), error));
        let (device, queue) = (&gpu.device, &gpu.queue);
        let new = || (device, queue, size.0, size.1, PixelFormat::Gray8, &params);
        let (d, q, w, h, f, p) = new();
        call("new", StereoMatcher::new(d, q, w, h, f, p).err());
        call("new_async", pollster::block_on(StereoMatcher::new_async(d, q, w, h, f, p)).err());
        call("another", matcher.another(w, h, f, p).err());
        call("another_async", pollster::block_on(matcher.another_async(w, h, f, p)).err());
        call("upload", matcher.upload(&left, &right).err());
        for (i, inputs) in inputs.iter().enumerate() {
            call(&format!("record {i}"), matcher.record(&mut gpu.encoder(), inputs, &outputs).err());
            call(&format!("record {i} before"), matcher.record(&mut old_encoder, inputs, &outputs).err());
        }
        call("compute", pollster::block_on(matcher.compute(&left, &right)).err());
        call("compute_blocking", matcher.compute_blocking(&left, &right).err());
        call("compute_timed_blocking", matcher.compute_timed_blocking(&left, &right).err());
        call("check", pollster::block_on(matcher.check(&left, &right)).err());
        call("check_blocking", matcher.check_blocking(&left, &right).err());
        call("read", pollster::block_on(matcher.read()).err());
        call("read_blocking", matcher.read_blocking().err());
        call("try_take", matcher.read().try_take().unwrap().err());
        call("resize", matcher.resize(20, 10).err());
        call("resize_async", pollster::block_on(matcher.resize_async(20, 10)).err());
        call("set_params", matcher.set_params(&Params::bm(8)).err());
        call("set_params_async", pollster::block_on(matcher.set_params_async(&Params::bm(8))).err());
        call("try_push", if round == 1 { stream.try_push(&left, &right).err() } else { lost() });
        call("next", stream.next_blocking().map_or_else(lost, |frame| frame.result.err()));
        call("next", pollster::block_on(stream.next()).map_or_else(lost, |frame| frame.result.err()));
        call("try_next", stream.try_next().map_or_else(lost, |frame| frame.result.err()));
        call("push_or_drop", stream.push_or_drop(&left, &right).err());
        call("stream resize", stream.resize(20, 10).err());
        call("stream resize_async", pollster::block_on(stream.resize_async(20, 10)).err());
        call("stream set_params", stream.set_params(&Params::bm(8)).err());
        call("stream set_params_async", pollster::block_on(stream.set_params_async(&Params::bm(8))).err());
        // Those that only look still do.
        assert!(matcher.device_bytes() > 0 && <(u32, u32)>::from(matcher.size()) == size && stream.capacity() == 2);
        matcher.forget_resources();
        let _ = gpu.device.poll(wgpu::PollType::wait_indefinitely()); // lets go of what was made
    }
    for (i, mut reading) in readings.into_iter().enumerate() {
        let error = match i {
            0 => pollster::block_on(reading).err(),
            1 => reading.wait_blocking().err(),
            _ => loop {
                if let Some(taken) = reading.try_take() {
                    break taken.err();
                }
            },
        };
        calls.push((format!("reading {i}"), error));
    }
    calls.push(("StereoStream::new".into(), StereoStream::new(matcher, 2).err()));
    for (name, error) in calls {
        let Some(Error::Lost(text)) = &error else { panic!("{name}: {error:?}") };
        assert!(text.contains("device lost; "), "{name}: {text}");
    }
    gpu.heard_nothing();
}

/// For calls that have nothing to say in a round.
fn lost() -> Option<Error> {
    Some(Error::Lost("device lost; ".into()))
}

/// What another device made, of the same instance or of another one, is an error that says so: not a panic, and not the
/// resource of the same number.
#[test]
fn what_is_of_another_device_is_refused() {
    let Some(instance) = Gpu::two_of_an_instance() else { return };
    let Some(apart) = Gpu::new().zip(Gpu::new()).map(|(own, other)| [own, other]) else { return };
    for (place, [own, other]) in [("instance", &instance), ("adapter", &apart)] {
        let size = (40, 20);
        let (left, right) = support::pair(size.0, size.1, 3);
        let params = Params::sgm(16);
        let matcher = own.matcher(size, &params);
        // What has the same numbers.
        let _twin = other.matcher(size, &params);
        let make = |gpu: &Gpu| {
            let draw = TextureUsages::RENDER_ATTACHMENT;
            let targets = [TextureFormat::R32Float, TextureFormat::Rgba8Unorm].map(|f| gpu.texture(size, f, draw));
            let stored = gpu.texture(size, TextureFormat::R32Float, TextureUsages::STORAGE_BINDING);
            let pixels = gpu.buffer(4096, BufferUsages::STORAGE);
            (gpu.filled(&left), gpu.filled(&right), targets, stored, pixels, gpu.copy_of(size))
        };
        let ((l, r, targets, stored, pixels, copy), theirs) = (make(own), make(other));
        let whole = |pixels| PixelBuffer::new(pixels, 0, size.0);
        let (to, from) = (Outputs::default(), Inputs::textures(&l, &r));
        let mistakes = [
            (Inputs::textures(&theirs.0, &r), to, "the left input"),
            (Inputs::textures(&l, &theirs.1), to, "the right input"),
            (Inputs::textures(&l, TextureLayer::new(&theirs.1, 0)), to, "the right input"),
            (Inputs::buffers(whole(&pixels), whole(&theirs.4)), to, "the right input"),
            (from, to.disparity(&theirs.2[0]), "the output disparity"),
            (from, to.color(&theirs.2[1]), "the output color"),
            (from, to.disparity(&theirs.3), "the output disparity"),
            (from, to.buffer(&theirs.5, 0), "the output buffer"),
        ];
        // First with nothing, then with everything known: a number that is known must not do.
        for round in 0..3 {
            for (i, (inputs, outputs, name)) in mistakes.iter().enumerate() {
                let mut encoder = own.encoder();
                let error = matcher.record(&mut encoder, inputs, outputs).unwrap_err();
                assert!(matches!(error, Error::Image(_)), "{place}, {i}, {round}: {error:?}");
                says(&error, &[name, "another wgpu device", "create it with the device"]);
                own.queue.submit([encoder.finish()]);
            }
            let mut encoder = other.encoder();
            let error = matcher.record(&mut encoder, &from, &to).unwrap_err();
            assert!(matches!(error, Error::Misuse(_)), "{place}, {round}: {error:?}");
            says(&error, &["the encoder", "another wgpu device", "create it with the device"]);
            other.queue.submit([encoder.finish()]);
            for outputs in [to.disparity(&targets[0]).color(&targets[1]).buffer(&copy, 0), to.disparity(&stored)] {
                for inputs in [from, Inputs::buffers(whole(&pixels), whole(&pixels))] {
                    let mut encoder = own.encoder();
                    matcher.record(&mut encoder, &inputs, &outputs).unwrap();
                    own.queue.submit([encoder.finish()]);
                }
            }
        }
        for (device, queue) in [(&own.device, &other.queue), (&other.device, &own.queue)] {
            let error = StereoMatcher::new(device, queue, size.0, size.1, PixelFormat::Gray8, &params).unwrap_err();
            assert!(matches!(error, Error::Misuse(_)), "{place}: {error:?}");
            says(&error, &["the queue", "another device", "take the queue that came with"]);
        }
        assert_eq!(matcher.compute_blocking(&left, &right).unwrap().map.data, expected(&(left, right), &params));
        own.heard_nothing();
        other.heard_nothing();
    }
}

/// A place that would be written twice, or is read, or is the matcher's own.
#[test]
fn outputs_have_places_of_their_own() {
    let Some(gpu) = Gpu::new() else { return };
    let size = (40, 20);
    let mut params = Params::sgm(16);
    (params.right_map, params.confidence) = (true, true);
    let matcher = gpu.matcher(size, &params);
    let both = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
    let [gray, float] = [TextureFormat::R8Unorm, TextureFormat::R32Float].map(|f| gpu.texture(size, f, both));
    let other = gpu.texture(size, TextureFormat::R8Unorm, both);
    let bytes = 80 * 20;
    let buffer = gpu.buffer(8192, BufferUsages::STORAGE | BufferUsages::COPY_DST);
    let pixels = |offset| PixelBuffer::new(&buffer, offset, size.0);
    let (to, from) = (Outputs::default(), Inputs::textures(&other, &other)); // one texture for both is a pair
    for (inputs, outputs, parts) in [
        (Inputs::textures(&gray, &other), to.confidence(&gray), ["the output confidence", "the left input"]),
        (from, to.disparity(&float).right_disparity(&float), ["the output right_disparity", "the output disparity"]),
        (from, to.buffer(&buffer, 0).right_buffer(&buffer, bytes - 4), ["right_buffer", "the output buffer"]),
        (from, to.buffer(&buffer, 0).confidence_buffer(&buffer, bytes - 4), ["confidence_buffer", "the output buffer"]),
        (Inputs::buffers(pixels(256), pixels(256)), to.buffer(&buffer, 0), ["the output buffer", "the left input"]),
    ] {
        let error = matcher.record(&mut gpu.encoder(), &inputs, &outputs).unwrap_err();
        assert!(matches!(error, Error::Image(_)), "{error:?}");
        says(&error, &parts);
        says(&error, &["overlaps", "a place of its own"]);
    }
    for own in [matcher.output(), matcher.right().unwrap(), matcher.confidence().unwrap()] {
        let pixels = PixelBuffer::new(own, 0, size.0);
        for (inputs, outputs) in [(from, to.buffer(own, 0)), (Inputs::buffers(pixels, pixels), to)] {
            let error = matcher.record(&mut gpu.encoder(), &inputs, &outputs).unwrap_err();
            says(&error, &["the matcher's own buffer", "make another one"]);
        }
    }
    let next = bytes.next_multiple_of(256);
    let mut encoder = gpu.encoder();
    let outputs = to.right_buffer(&buffer, 0).confidence_buffer(&buffer, next).confidence(&gray).disparity(&float);
    matcher.record(&mut encoder, &Inputs::buffers(pixels(4096), pixels(4096)), &outputs).unwrap();
    gpu.queue.submit([encoder.finish()]);
    gpu.heard_nothing();
}

/// What was destroyed, what is no picture, and an encoder with an open pass.
#[test]
fn what_cannot_be_used_is_refused() {
    let Some(gpu) = Gpu::new() else { return };
    let size = (40, 20);
    let matcher = gpu.matcher(size, &Params::sgm(16));
    let (left, right) = support::pair(size.0, size.1, 3);
    let good = gpu.filled(&left);
    let gone = gpu.filled(&right);
    let gone_target = gpu.texture(size, TextureFormat::R32Float, TextureUsages::RENDER_ATTACHMENT);
    let gone_stored = gpu.texture(size, TextureFormat::R32Float, TextureUsages::STORAGE_BINDING);
    let gone_pixels = gpu.buffer(4096, BufferUsages::STORAGE);
    [&gone, &gone_target, &gone_stored].into_iter().for_each(wgpu::Texture::destroy);
    gone_pixels.destroy();
    let depth = gpu.texture(size, TextureFormat::Depth32Float, TextureUsages::TEXTURE_BINDING);
    let pixels = PixelBuffer::new(&gone_pixels, 0, size.0);
    let (to, from) = (Outputs::default(), Inputs::textures(&good, &good));
    for (i, (inputs, outputs, parts)) in [
        (Inputs::textures(&good, &gone), to, ["the right input was refused", "create another texture"]),
        (from, to.disparity(&gone_target), ["the output disparity was refused", "destroyed"]),
        (from, to.disparity(&gone_stored), ["the output disparity was refused", "destroyed"]),
        (Inputs::buffers(pixels, pixels), to, ["the left input was refused", "destroyed: create another buffer"]),
        (Inputs::textures(&depth, &good), to, ["the left input", "Depth32Float"]),
    ]
    .iter()
    .enumerate()
    {
        let error = matcher.record(&mut gpu.encoder(), inputs, outputs).unwrap_err();
        assert!(matches!(error, Error::Image(_)), "{i}: {error:?}");
        says(&error, parts);
    }
    let mut encoder = gpu.encoder();
    let open = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default()).forget_lifetime();
    let error = matcher.record(&mut encoder, &from, &to).unwrap_err();
    assert!(matches!(error, Error::Misuse(_)), "{error:?}");
    says(&error, &["the encoder", "open passes"]);
    gpu.heard_nothing();
    drop((open, encoder));
}
