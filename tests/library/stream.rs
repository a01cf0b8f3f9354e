//! A matcher that goes on: other sizes, other settings, results that come later, several frames in flight.

use crate::support;
use gpu_stereo::{
    Error, Fill, Image, Inputs, Matched, Outputs, Params, Paths, PixelFormat, Reading, RightView, StereoMatcher,
    StereoStream, reference, wgpu,
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn with(mut params: Params, change: impl FnOnce(&mut Params)) -> Params {
    change(&mut params);
    params
}

fn expected(left: &Image, right: &Image, params: &Params) -> Matched {
    reference::compute_all(left, right, params).unwrap()
}

/// Whatever the size and the settings were before, the bits are those of a matcher made for them; and nothing new is made
/// for a size that is not larger than the largest.
#[test]
fn a_matcher_takes_other_sizes_and_settings() {
    let setups = [support::device(), support::bare_device()];
    for seed in 0..5 {
        let Some((adapter, device, queue)) = &setups[seed as usize % 2] else { return };
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let (width, height) = (random.random_range(1..=120), random.random_range(1..=60));
        let format = random.random_range(0..4);
        let pair = |width, height| {
            let (left, right) = support::pair(width, height, seed);
            (support::as_format(&left, format), support::as_format(&right, format))
        };
        let mut params = support::random_params(&mut random);
        let samples = pair(1, 1).0.format();
        let mut matcher = StereoMatcher::new(device, queue, width, height, samples, &params).unwrap();
        for change in 0..2 {
            let bytes = matcher.device_bytes();
            for _ in 0..3 {
                let (width, height) = (random.random_range(1..=width), random.random_range(1..=height));
                let case = (adapter.get_info().name, seed, change, width, height, &params);
                matcher.resize(width, height).unwrap();
                assert_eq!(matcher.size(), [width, height]);
                let (left, right) = pair(width, height);
                assert_eq!(
                    matcher.compute_blocking(&left, &right).unwrap(),
                    expected(&left, &right, &params),
                    "{case:?}"
                );
                assert_eq!(matcher.device_bytes(), bytes, "something was made for {case:?}");
            }
            params = support::random_params(&mut random);
            matcher.set_params(&params).unwrap();
            assert_eq!(matcher.params(), &params);
        }
        // A larger pair makes it grow.
        matcher.resize(width + 30, height + 9).unwrap();
        let (left, right) = pair(width + 30, height + 9);
        assert_eq!(matcher.compute_blocking(&left, &right).unwrap(), expected(&left, &right, &params), "seed {seed}");
    }
}

/// Volumes in many bands, with bindings of 48 KiB: what was made for the largest pair does for all smaller ones.
#[test]
fn bands_of_a_smaller_pair_fit_those_of_a_larger_one() {
    let small = support::device_with(|_, limits| limits.max_storage_buffer_binding_size = 48 << 10);
    let Some((_, device, queue)) = small else { return };
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let beliefs = with(Params::bp(33), |p| (p.bp_levels, p.bp_iterations) = (3, 3));
    for (params, width, height) in
        [(Params::sgm(33), 61, 97), (Params::bm(16), 40, 60), (Params::sgm(16), 300, 41), (beliefs, 61, 97)]
    {
        let mut matcher = StereoMatcher::new(&device, &queue, width, height, PixelFormat::Gray8, &params).unwrap();
        let bytes = matcher.device_bytes();
        for _ in 0..12 {
            let (width, height) = (random.random_range(1..=width), random.random_range(1..=height));
            matcher.resize(width, height).unwrap();
            assert_eq!(matcher.device_bytes(), bytes, "something was made for {width}x{height}, {params:?}");
            let (left, right) = support::pair(width, height, 5);
            let case = (width, height, &params);
            assert_eq!(matcher.compute_blocking(&left, &right).unwrap(), expected(&left, &right, &params), "{case:?}");
        }
    }
}

/// What is refused leaves the matcher as it was.
#[test]
fn a_refused_change_changes_nothing() {
    let Some((_, device, queue)) = support::device() else { return };
    let (left, right) = support::pair(33, 14, 3);
    let params = Params::sgm(16);
    let mut matcher = StereoMatcher::new(&device, &queue, 33, 14, left.format(), &params).unwrap();
    let refused = with(params.clone(), |p| p.p2 = 200);
    assert!(matches!(matcher.set_params(&refused), Err(Error::Parameter { name: "p2", .. })));
    assert!(matches!(matcher.resize(0, 14), Err(Error::Image(_))));
    assert!(matches!(matcher.resize(60_001, 1), Err(Error::Image(_))));
    assert_eq!((matcher.size(), matcher.params()), ([33, 14], &params));
    assert_eq!(matcher.compute_blocking(&left, &right).unwrap(), expected(&left, &right, &params));
}

/// The right view is the one that the left-right check reads, from the diagonal or from a match of its own.
#[test]
fn the_right_view_is_given_when_asked_for() {
    let Some((_, device, queue)) = support::device() else { return };
    let (left, right) = support::pair(57, 20, 9);
    for right_view in [RightView::Diagonal, RightView::Match] {
        let params = with(Params::sgm(20), |p| {
            (p.right_view, p.lr_check, p.right_map, p.fill) = (right_view, None, true, Fill::None);
        });
        let expected = expected(&left, &right, &params);
        let mut matcher = StereoMatcher::new(&device, &queue, 57, 20, left.format(), &params).unwrap();
        assert!(matcher.right().is_some() && expected.right.is_some());
        assert_eq!(matcher.compute_blocking(&left, &right).unwrap(), expected, "{right_view:?}");
        matcher.set_params(&with(params, |p| p.right_map = false)).unwrap();
        assert!(matcher.right().is_none());
        assert_eq!(matcher.compute_blocking(&left, &right).unwrap().right, None);
    }
}

/// Results come to every executor, to one that only looks, and to a thread that waits; several at a time.
#[test]
fn results_come_later() {
    let Some((_, device, queue)) = support::device() else { return };
    let (left, right) = support::pair(70, 30, 2);
    let params = Params::sgm(32);
    let expected = expected(&left, &right, &params);
    let matcher = StereoMatcher::new(&device, &queue, 70, 30, left.format(), &params).unwrap();
    assert_eq!(pollster::block_on(matcher.compute(&left, &right)).unwrap(), expected);
    let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
    assert_eq!(runtime.block_on(matcher.compute(&left, &right)).unwrap(), expected);

    let mut readings: Vec<Reading> = (0..4).map(|_| matcher.read()).collect();
    assert_eq!(readings.pop().unwrap().wait_blocking().unwrap(), expected);
    assert_eq!(pollster::block_on(readings.pop().unwrap()).unwrap(), expected);
    drop(readings.pop()); // nobody waits for this one
    let mut looked = readings.pop().unwrap();
    let seen = loop {
        if let Some(seen) = looked.try_take() {
            break seen;
        }
        std::thread::yield_now();
    };
    assert_eq!(seen.unwrap(), expected);
    assert!(looked.try_take().is_none());
    assert!(matches!(looked.wait_blocking(), Err(Error::Misuse(_))));

    // A reading does not hold the matcher.
    let reading = matcher.read();
    drop(matcher);
    assert_eq!(runtime.block_on(reading).unwrap(), expected);
}

/// Matchers on one device, each in a thread of its own.
#[test]
fn matchers_in_several_threads() {
    fn shared<T: Send + Sync>() {}
    shared::<StereoMatcher>();
    shared::<StereoStream>();
    shared::<Reading>();
    let Some((_, device, queue)) = support::device() else { return };
    std::thread::scope(|scope| {
        for seed in 0..4 {
            let (device, queue) = (&device, &queue);
            scope.spawn(move || {
                let (left, right) = support::pair(40 + seed as u32, 25, seed);
                let params = if seed % 2 == 0 { Params::sgm(24) } else { Params::bm(24) };
                let expected = expected(&left, &right, &params);
                let (width, height) = (left.width(), left.height());
                let matcher = StereoMatcher::new(device, queue, width, height, left.format(), &params).unwrap();
                for frame in 0..5 {
                    let got = if frame % 2 == 0 {
                        matcher.compute_blocking(&left, &right)
                    } else {
                        pollster::block_on(matcher.compute(&left, &right))
                    };
                    assert_eq!(got.unwrap(), expected, "seed {seed}, frame {frame}");
                }
            });
        }
    });
}

fn stream(device: &wgpu::Device, queue: &wgpu::Queue, params: &Params, in_flight: usize) -> StereoStream {
    let matcher = StereoMatcher::new(device, queue, 64, 24, PixelFormat::Gray8, params).unwrap();
    StereoStream::new(matcher, in_flight).unwrap()
}

/// Every frame once, in order, with the bits of a single run; with changes of size and settings between frames in flight,
/// and pairs that are refused.
#[test]
fn a_stream_keeps_order_and_bits() {
    let Some((_, device, queue)) = support::device() else { return };
    let pairs: Vec<(Image, Image)> =
        (0..23).map(|n| support::pair(if n < 12 { 64 } else { 51 }, if n < 12 { 24 } else { 19 }, n)).collect();
    for in_flight in [1, 2, 3, 8] {
        let mut params = Params::sgm(24);
        let mut stream = stream(&device, &queue, &params, in_flight);
        let mut settings = Vec::new();
        let mut results = Vec::new();
        for (n, (left, right)) in pairs.iter().enumerate() {
            if n == 5 {
                (params.paths, params.confidence, params.right_map) = (Paths::Three, true, true);
                stream.set_params(&params).unwrap();
            }
            if n == 12 {
                assert!(matches!(stream.try_push(left, right), Err(Error::Image(_))), "another size");
                stream.resize(51, 19).unwrap();
            }
            let number = loop {
                assert!(stream.in_flight() <= stream.capacity());
                if let Some(number) = stream.try_push(left, right).unwrap() {
                    break number;
                }
                assert!(stream.in_flight() > 0, "full, and nothing is in flight");
                results.push(match n % 3 {
                    0 => stream.next_blocking().unwrap(),
                    1 => pollster::block_on(stream.next()).unwrap(),
                    _ => loop {
                        if let Some(frame) = stream.try_next() {
                            break frame;
                        }
                    },
                });
            };
            assert_eq!(number, n as u64);
            settings.push(params.clone());
        }
        results.extend(std::iter::from_fn(|| stream.next_blocking()));
        assert_eq!(results.len(), pairs.len());
        for (n, (frame, ((left, right), params))) in results.into_iter().zip(pairs.iter().zip(&settings)).enumerate() {
            assert_eq!(frame.number, n as u64);
            assert_eq!(frame.result.unwrap(), expected(left, right, params), "frame {n}, {in_flight} in flight");
        }
    }
}

/// A pair that comes too soon is dropped, and its place says so.
#[test]
fn a_dropped_frame_is_said() {
    let Some((_, device, queue)) = support::device() else { return };
    let params = Params::sgm(24);
    let mut stream = stream(&device, &queue, &params, 2);
    let pairs: Vec<(Image, Image)> = (0..6).map(|n| support::pair(64, 24, n)).collect();
    for (n, (left, right)) in pairs[..5].iter().enumerate() {
        assert_eq!(stream.push_or_drop(left, right).unwrap(), n as u64);
    }
    assert_eq!(stream.in_flight(), 2);
    for (n, (left, right)) in pairs[..5].iter().enumerate() {
        let frame = stream.next_blocking().unwrap();
        assert_eq!(frame.number, n as u64);
        match frame.result {
            Ok(matched) => assert!(n < 2 && matched == expected(left, right, &params), "frame {n}"),
            Err(Error::Dropped { in_flight, .. }) => assert!(n >= 2 && in_flight == 2, "frame {n}"),
            Err(error) => panic!("frame {n}: {error}"),
        }
    }
    assert!(stream.next_blocking().is_none());
    assert_eq!(stream.push_or_drop(&pairs[5].0, &pairs[5].1).unwrap(), 5);
    assert!(stream.next_blocking().unwrap().result.is_ok());
}

/// A device that is lost while frames are in flight is an error of these frames and of the next push; nothing hangs.
#[test]
fn a_lost_device_ends_the_frames_in_flight() {
    let Some((_, device, queue)) = support::device() else { return };
    let mut stream = stream(&device, &queue, &Params::sgm(24), 3);
    let (left, right) = support::pair(64, 24, 1);
    for _ in 0..3 {
        stream.try_push(&left, &right).unwrap().unwrap();
    }
    device.destroy();
    let results: Vec<_> = std::iter::from_fn(|| pollster::block_on(stream.next())).collect();
    assert_eq!(results.len(), 3);
    for frame in results {
        // What was done before the loss may still come.
        assert!(matches!(frame.result, Ok(_) | Err(Error::Lost(_))), "{:?}", frame.result);
    }
    assert!(matches!(stream.try_push(&left, &right), Err(Error::Lost(_))));
    assert!(matches!(pollster::block_on(stream.matcher().read()), Err(Error::Lost(_))));
}

/// The caller's own work on the device goes on when a matcher finds no room.
#[test]
fn too_little_memory_is_an_error_and_the_device_goes_on() {
    let Some((_, device, queue)) = support::device() else { return };
    let (left, right) = support::pair(64, 24, 1);
    let params = Params::sgm(24);
    let mut matcher = StereoMatcher::new(&device, &queue, 64, 24, left.format(), &params).unwrap();
    let sixteen = with(Params::sgm(2048), |p| p.paths = Paths::Sixteen);
    // Some hundred GiB.
    let error = matcher.set_params(&sixteen).and_then(|()| matcher.resize(16_000, 16_000)).unwrap_err();
    assert!(matches!(error, Error::OutOfMemory | Error::TooLarge { .. }), "{error:?}");
    matcher.set_params(&params).unwrap();
    matcher.resize(64, 24).unwrap();
    assert_eq!(matcher.compute_blocking(&left, &right).unwrap(), expected(&left, &right, &params));
}

/// Recorded, submitted by the caller, and then read.
#[test]
fn what_the_caller_submitted_is_read() {
    let Some((_, device, queue)) = support::device() else { return };
    let (left, right) = support::pair(31, 17, 4);
    let params = with(Params::sgm(16), |p| p.confidence = true);
    let matcher = StereoMatcher::new(&device, &queue, 31, 17, left.format(), &params).unwrap();
    matcher.upload(&left, &right).unwrap();
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    matcher.record(&mut encoder, &Inputs::Uploaded, &Outputs::default()).unwrap();
    queue.submit([encoder.finish()]);
    assert_eq!(matcher.read_blocking().unwrap(), expected(&left, &right, &params));
}

/// Pairs in the caller's textures, in those that were uploaded and of the host's, in turns: each has its own result, whatever is
/// written into the textures once it was pushed.
#[test]
fn a_stream_takes_pairs_from_textures() {
    for setup in [support::device(), support::bare_device()] {
        let Some((adapter, device, queue)) = setup else { return };
        let (width, height) = (61, 33);
        let mut params = Params::sgm(16);
        params.confidence = true;
        let matcher = support::matcher(&device, &queue, (width, height), PixelFormat::Gray8, &params).unwrap();
        let mut stream = StereoStream::new(matcher, 3).unwrap();
        let texture = |format, usage| support::texture(&device, (width, height), format, usage);
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let views = [(); 2].map(|()| texture(wgpu::TextureFormat::R8Unorm, usage));
        let target = texture(wgpu::TextureFormat::R32Float, wgpu::TextureUsages::RENDER_ATTACHMENT);
        let write = |texture: &wgpu::Texture, image: &Image| {
            let gpu_stereo::Pixels::Gray8(samples) = image.pixels() else { panic!("made from gray") };
            let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(width), rows_per_image: None };
            queue.write_texture(texture.as_image_copy(), samples, layout, texture.size());
        };
        let inputs = Inputs::textures(&views[0], &views[1]);
        let to = Outputs::default().disparity(&target);
        let mut taken = 0;
        let mut take = |stream: &mut StereoStream| {
            let frame = stream.next_blocking().unwrap();
            let (left, right) = support::pair(width, height, taken);
            assert_eq!(frame.number, taken);
            let case = format!("pair {taken} on {}", adapter.get_info().name);
            assert!(frame.result.unwrap() == expected(&left, &right, &params), "{case}");
            taken += 1;
        };
        for seed in 0..12 {
            let (left, right) = support::pair(width, height, seed);
            write(&views[0], &left);
            write(&views[1], &right);
            if stream.in_flight() == stream.capacity() {
                assert!(stream.try_push_inputs(&inputs, &to).unwrap().is_none());
                take(&mut stream);
            }
            let number = match seed % 3 {
                0 => stream.try_push(&left, &right).unwrap().unwrap(),
                1 => stream.try_push_inputs(&inputs, &to).unwrap().unwrap(),
                _ => {
                    stream.matcher().upload(&left, &right).unwrap();
                    stream.try_push_inputs(&Inputs::Uploaded, &Outputs::default()).unwrap().unwrap()
                }
            };
            assert_eq!(number, seed);
        }
        while stream.in_flight() > 0 {
            take(&mut stream);
        }

        // What does not fit has no number; what is too much is dropped.
        let wide = support::texture(&device, (width + 1, height), wgpu::TextureFormat::R8Unorm, usage);
        let error = stream.try_push_inputs(&Inputs::textures(&views[0], &wide), &to).unwrap_err();
        assert!(matches!(error, Error::Image(_)) && error.to_string().contains("62x33"), "{error}");
        let error = stream.push_inputs_or_drop(&inputs, &to.depth(&target)).unwrap_err();
        assert!(error.to_string().contains("Params::depth"), "{error}");
        assert_eq!(stream.in_flight(), 0);
        let numbers: Vec<u64> = (0..5).map(|_| stream.push_inputs_or_drop(&inputs, &to).unwrap()).collect();
        assert_eq!(numbers, [12, 13, 14, 15, 16]);
        let (left, right) = support::pair(width, height, 11);
        for number in numbers {
            let frame = stream.next_blocking().unwrap();
            assert_eq!(frame.number, number);
            match frame.result {
                Ok(matched) => assert!(number < 15 && matched == expected(&left, &right, &params), "pair {number}"),
                Err(error) => assert!(number >= 15 && matches!(error, Error::Dropped { .. }), "{error}"),
            }
        }
    }
}
