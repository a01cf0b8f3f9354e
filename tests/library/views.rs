//! Images in the caller's memory: every format, with gaps between the rows, at odd addresses, give what the same samples give as an
//! [`Image`]; what is no image is refused.

use crate::support;
use gpu_stereo::cpu::CpuMatcher;
use gpu_stereo::{
    Error, Image, ImageView, Inputs, Matched, Outputs, Params, PixelFormat, Pixels, RangeSearch, StereoMatcher,
    StereoStream, ViewFormat, reference, wgpu,
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// An image's rows as another program keeps them: one byte off, `gap` bytes of something else behind each row but the last.
struct Foreign {
    width: u32,
    height: u32,
    format: ViewFormat,
    stride: usize,
    bytes: Vec<u8>,
}

impl Foreign {
    fn of(image: &Image, format: ViewFormat, gap: usize, random: &mut ChaCha8Rng) -> Self {
        let pixels: Vec<Vec<u8>> = match image.pixels() {
            Pixels::Gray8(all) => all.iter().map(|&sample| vec![sample]).collect(),
            Pixels::Gray16(all) => all.iter().map(|sample| sample.to_ne_bytes().to_vec()).collect(),
            Pixels::Rgba8(all) => all.chunks_exact(4).map(<[u8]>::to_vec).collect(),
            Pixels::Rgba16(all) => all
                .chunks_exact(4)
                .map(|pixel| pixel.iter().flat_map(|sample| sample.to_ne_bytes()).collect())
                .collect(),
            _ => panic!("another format"),
        };
        let row = image.width() as usize * format.bytes_per_pixel() as usize;
        let mut bytes = vec![random.random()];
        for pixel in &pixels {
            let column = (bytes.len() - 1) % (row + gap);
            if column == row {
                bytes.extend((0..gap).map(|_| random.random::<u8>()));
            }
            match format {
                ViewFormat::Rgb8 => bytes.extend(&pixel[..3]),
                ViewFormat::Bgr8 => bytes.extend([pixel[2], pixel[1], pixel[0]]),
                // The fourth sample is ignored.
                ViewFormat::Rgba8 => bytes.extend([pixel[0], pixel[1], pixel[2], random.random()]),
                ViewFormat::Bgra8 => bytes.extend([pixel[2], pixel[1], pixel[0], random.random()]),
                _ => bytes.extend(pixel),
            }
        }
        Self { width: image.width(), height: image.height(), format, stride: row + gap, bytes }
    }

    fn view(&self) -> ImageView<'_> {
        ImageView::new(self.width, self.height, self.format, self.stride, &self.bytes[1..]).unwrap()
    }
}

/// The image of `support::pair` that has the samples of a view's format.
fn in_format(image: &Image, format: ViewFormat) -> Image {
    let formats = [PixelFormat::Gray8, PixelFormat::Gray16, PixelFormat::Rgba8, PixelFormat::Rgba16];
    let place = formats.iter().position(|known| *known == format.pixel_format()).unwrap();
    support::as_format(image, place as u32)
}

type Device = (wgpu::Adapter, wgpu::Device, wgpu::Queue);

/// Everything that takes pairs.
fn maps_of(
    matcher: StereoMatcher,
    [left, right]: [ImageView<'_>; 2],
    (adapter, device, queue): &Device,
) -> Vec<Matched> {
    let mut maps = vec![matcher.compute_blocking(left, right).unwrap()];
    maps.push(pollster::block_on(matcher.compute(left, right)).unwrap());
    maps.push(matcher.compute_timed_blocking(left, right).unwrap().0);
    matcher.upload(left, right).unwrap();
    let mut encoder = device.create_command_encoder(&Default::default());
    matcher.record(&mut encoder, &Inputs::Uploaded, &Outputs::default()).unwrap();
    queue.submit([encoder.finish()]);
    maps.push(matcher.read_blocking().unwrap());
    let stages = matcher.check_blocking(left, right).unwrap();
    support::assert_equal(&stages, adapter, &(left, right));
    let mut stream = StereoStream::new(matcher, 2).unwrap();
    stream.try_push(left, right).unwrap();
    stream.push_or_drop(left, right).unwrap();
    maps.extend(std::iter::from_fn(|| stream.next_blocking()).map(|frame| frame.result.unwrap()));
    assert_eq!(maps.len(), 6);
    maps
}

#[test]
fn views_give_what_images_give() {
    let setup = support::device();
    let mut random = ChaCha8Rng::seed_from_u64(77);
    let mut colored = Params::bm(9);
    (colored.color_cost, colored.block) = (true, 3);
    let mut matched = Params::default_for(16);
    matched.right_view = gpu_stereo::RightView::Match;
    for (width, height) in [(37, 23), (64, 5), (1, 1), (3, 40)] {
        let (left, right) = support::pair(width, height, 7);
        for format in ViewFormat::ALL {
            let pair = [&left, &right].map(|image| in_format(image, format));
            // The right view in another order and with another gap, of the same matcher.
            let mut same = ViewFormat::ALL.into_iter().filter(|other| other.pixel_format() == format.pixel_format());
            let other = same.next_back().unwrap();
            let gaps = [random.random_range(0..20), random.random_range(0..300)];
            let case = format!("{width}x{height} {format:?} and {other:?}, gaps of {gaps:?}, seed 77");
            let foreign = [
                Foreign::of(&pair[0], format, gaps[0], &mut random),
                Foreign::of(&pair[1], other, gaps[1], &mut random),
            ];
            let views = [foreign[0].view(), foreign[1].view()];
            for params in [&Params::sgm(16), &colored, &matched] {
                let expected = reference::compute_all(&pair[0], &pair[1], params).unwrap();
                assert!(reference::compute_all(views[0], views[1], params).unwrap() == expected, "reference, {case}");
                let native = CpuMatcher::new(width, height, views[0].format(), params).unwrap();
                assert!(native.compute(views[0], views[1]).unwrap() == expected, "native, {case}");
                let checked = native.check(views[0], views[1]).unwrap();
                assert!(checked.len() > 3 && checked.iter().all(|stage| stage.mismatches == 0), "{checked:?}, {case}");
                let Some(setup) = &setup else { continue };
                let matcher = support::matcher(&setup.1, &setup.2, (width, height), views[0].format(), params).unwrap();
                for (i, map) in maps_of(matcher, views, setup).into_iter().enumerate() {
                    assert!(map == expected, "way {i}, {case}, {params:?}");
                }
            }
            if width > 30 {
                let [found, expected] =
                    [RangeSearch::new(views[0], views[1]).unwrap(), RangeSearch::new(&pair[0], &pair[1]).unwrap()];
                assert!(found.left.pixels() == expected.left.pixels() || format.pixel_format() == PixelFormat::Rgba8);
                assert_eq!(found.params, expected.params);
            }
        }
    }
}

/// Colours that are said to lie in another order give another map: the comparison above can fail.
#[test]
fn the_order_of_colours_matters() {
    let (left, right) = support::pair(48, 20, 7);
    let pair = [&left, &right].map(|image| in_format(image, ViewFormat::Rgb8));
    let expected = reference::compute_all(&pair[0], &pair[1], &Params::sgm(16)).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(78);
    let foreign = pair.each_ref().map(|image| Foreign::of(image, ViewFormat::Rgb8, 5, &mut random));
    let [left, right] = foreign.each_ref().map(|foreign| Foreign { format: ViewFormat::Bgr8, ..as_is(foreign) });
    assert!(reference::compute_all(left.view(), right.view(), &Params::sgm(16)).unwrap() != expected);
    let native = CpuMatcher::new(48, 20, PixelFormat::Rgba8, &Params::sgm(16)).unwrap();
    assert!(native.compute(left.view(), right.view()).unwrap() != expected);
}

fn as_is(foreign: &Foreign) -> Foreign {
    let Foreign { width, height, format, stride, ref bytes } = *foreign;
    Foreign { width, height, format, stride, bytes: bytes.clone() }
}

/// A part of a view is the image of these pixels, and shares its memory.
#[test]
fn a_part_is_an_image() {
    let (image, _) = support::pair(40, 30, 3);
    let mut random = ChaCha8Rng::seed_from_u64(79);
    for format in ViewFormat::ALL {
        let image = in_format(&image, format);
        let foreign = Foreign::of(&image, format, 7, &mut random);
        let part = foreign.view().crop(5, 9, 21, 13).unwrap();
        let of_image = ImageView::from(&image).crop(5, 9, 21, 13).unwrap();
        assert_eq!((part.width(), part.height(), part.view_format()), (21, 13, format));
        assert_eq!(part.row(3).as_ptr(), foreign.view().row(12)[5 * format.bytes_per_pixel() as usize..].as_ptr());
        let gray = |view: ImageView<'_>| reference::gray(view, reference::Channel::Luma).data;
        assert_eq!(gray(part), gray(of_image), "{format:?}, seed 79");
        assert_eq!(gray(part), gray(ImageView::from(&part.to_image())), "{format:?}, seed 79");
        let whole = ImageView::from(&image);
        assert_eq!(whole.to_image(), image);
        assert_eq!(whole.crop(0, 0, 40, 30).unwrap().to_image(), image);
    }
}

#[test]
fn what_is_no_view_is_refused() {
    let bytes = vec![0; 100];
    for (width, height, format, stride, parts) in [
        (0, 4, ViewFormat::Gray8, 10, ["0x4", "at least 1"]),
        (4, 0, ViewFormat::Gray8, 10, ["4x0", "at least 1"]),
        (10, 10, ViewFormat::Gray8, 9, ["stride of 9", "at least 10"]),
        (10, 1, ViewFormat::Bgr8, 29, ["stride of 29", "at least 30"]),
        (10, 11, ViewFormat::Gray8, 10, ["given 100 bytes", "at least 110"]),
        (10, 5, ViewFormat::Gray16, 21, ["given 100 bytes", "at least 104"]),
        (u32::MAX, u32::MAX, ViewFormat::Rgba16, usize::MAX, ["given 100 bytes", "4294967295x4294967295"]),
        (u32::MAX, 2, ViewFormat::Rgba16, 8, ["stride of 8", "34359738360"]),
    ] {
        let error = ImageView::new(width, height, format, stride, &bytes).unwrap_err();
        assert!(matches!(error, Error::Image(_)), "{error:?}");
        let text = error.to_string();
        assert!(parts.iter().all(|part| text.contains(part)) && text.contains("; give"), "{text}");
    }
    // The last row needs no gap behind it.
    let view = ImageView::new(10, 5, ViewFormat::Gray16, 20, &bytes).unwrap();
    assert!(ImageView::new(10, 4, ViewFormat::Gray8, 30, &bytes).is_ok());
    for (x, y, width, height) in
        [(0, 0, 0, 1), (0, 0, 1, 0), (1, 0, 10, 1), (0, 5, 1, 1), (u32::MAX, 0, 2, 1), (0, 1, 1, u32::MAX)]
    {
        let text = view.crop(x, y, width, height).unwrap_err().to_string();
        assert!(
            text.contains(&format!("{width}x{height} from column {x} and row {y}")) && text.contains("10x5"),
            "{text}"
        );
    }
    // A pair of two sizes, and a format that the matcher was not made for.
    let part = view.crop(0, 0, 9, 5).unwrap();
    let matcher = CpuMatcher::new(10, 5, PixelFormat::Gray8, &Params::sgm(4)).unwrap();
    let text = matcher.compute(view, part).unwrap_err().to_string();
    assert!(text.contains("10x5") && text.contains("9x5"), "{text}");
    let text = matcher.compute(view, view).unwrap_err().to_string();
    assert!(text.contains("10x5 in Gray16") && text.contains("made for 10x5 in Gray8"), "{text}");
}
