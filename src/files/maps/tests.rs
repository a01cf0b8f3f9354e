use super::*;
use crate::files::damage::damaged;
use ::exr::prelude::{
    AnyChannel, AnyChannels, Compression, FlatSamples, Layer, LayerAttributes, WritableImage as _, f16,
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::io::Cursor;
use std::time::{Duration, Instant};

/// Small good files of every format.
fn seeds() -> Vec<Vec<u8>> {
    let floats: Vec<u8> = [4.0_f32, f32::NAN, 1.5, 20.0, 7.0, 255.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let pfm = [b"Pf\n3 2\n-1.0\n", &floats[..]].concat();
    let npy = |header: &str, samples: &[u8]| {
        let header = format!("{header:<117}\n");
        [&b"\x93NUMPY\x01\x00"[..], &(header.len() as u16).to_le_bytes(), header.as_bytes(), samples].concat()
    };
    let f4 = npy("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }", &floats);
    let u1 = npy("{'descr': '|u1', 'fortran_order': True, 'shape': (3, 2), }", &[0, 1, 2, 3, 4, 5]);
    let mut tiff = Cursor::new(Vec::new());
    let mut encoder = ::tiff::encoder::TiffEncoder::new(&mut tiff).unwrap();
    encoder.write_image::<::tiff::encoder::colortype::Gray32Float>(2, 2, &[1.0, 2.0, f32::NAN, 3.0]).unwrap();
    let mut png = Cursor::new(Vec::new());
    image::ImageBuffer::<image::Luma<u16>, _>::from_raw(2, 2, vec![0_u16, 256, 300, 65535])
        .unwrap()
        .write_to(&mut png, ImageFormat::Png)
        .unwrap();
    let pgm = b"P5\n# made by hand\n3 2\n255\n\x00\x01\x02\x03\x04\x05".to_vec();
    let i2 = npy("{'descr': '<i2', 'fortran_order': False, 'shape': (1, 2, 2), }", &i16s(&[-16, 0, 8, 325]));
    let exr = |compression| exr_of(vec![("Y", FlatSamples::F32(vec![1.0, 2.0, 0.5, f32::NAN, 4.0, 3.0]))], compression);
    vec![
        pfm,
        f4,
        u1,
        tiff.into_inner(),
        png.into_inner(),
        pgm,
        i2,
        exr(Compression::Uncompressed),
        exr(Compression::ZIP16),
    ]
}

#[test]
fn a_small_file_that_declares_many_pixels_is_refused() {
    let mut tiff = seeds().swap_remove(3);
    let tag = |number: u16| [&number.to_le_bytes()[..], &[4, 0, 1, 0, 0, 0, 2, 0, 0, 0]].concat();
    for number in [256, 257] {
        let at = tiff.windows(12).position(|bytes| bytes == tag(number)).unwrap() + 8;
        tiff[at..at + 4].copy_from_slice(&20_000_u32.to_le_bytes());
    }
    for file in [&tiff[..], b"P5\n20000 20000\n255\n\0"] {
        let error = parse(Path::new("many"), file, Encoding::default(), EncodingOptions::ESTIMATE).unwrap_err();
        let told = format!("{error:#}");
        assert!(told.contains("20000x20000 pixels") && told.contains("at most 134217728"), "{told}");
    }
}

#[test]
fn nested_brackets_in_a_header_are_refused_at_once() {
    let header = format!("{{'descr': '<f4', 'fortran_order': {}, 'shape': (2, 3), }}", "[".repeat(60));
    let file = [&b"\x93NUMPY\x01\x00"[..], &(header.len() as u16).to_le_bytes(), header.as_bytes()].concat();
    let error = parse(Path::new("nested"), &file, Encoding::default(), EncodingOptions::ESTIMATE).unwrap_err();
    assert!(format!("{error:#}").contains("62 brackets"), "{error:#}");
}

/// A second; GPU_STEREO_FUZZ_SECONDS says how long else.
#[test]
fn damaged_maps_are_refused_or_read_and_never_panic() {
    let seconds = std::env::var("GPU_STEREO_FUZZ_SECONDS").map_or(1, |text| text.parse().unwrap());
    let (end, seeds) = (Instant::now() + Duration::from_secs(seconds), seeds());
    let encodings = [(Some(2.0), None), (None, Some(386.2)), (None, None)];
    let encodings = encodings.map(|(scale, depth)| Encoding { scale, depth, invalid: None });
    for seed in &seeds {
        let map = parse(Path::new("seed"), seed, encodings[0], EncodingOptions::ESTIMATE).unwrap().map;
        assert!(map.data().len() >= 4);
    }
    let (mut read, mut refused) = (0_u64, 0_u64);
    for number in 0.. {
        if Instant::now() > end {
            break;
        }
        let mut random = ChaCha8Rng::seed_from_u64(number);
        let mut bytes = damaged(&seeds[random.random_range(0..seeds.len())], &mut random, b" \n-(,#'\"");
        if bytes.is_empty() {
            bytes.push(b'P');
        }
        let encoding = encodings[random.random_range(0..3)];
        match std::panic::catch_unwind(|| parse(Path::new("damaged"), &bytes, encoding, EncodingOptions::ESTIMATE)) {
            Ok(Ok(MapFile { map, .. })) => {
                assert_eq!(map.data().len(), map.width() as usize * map.height() as usize, "{number}");
                read += 1;
            }
            Ok(Err(error)) => {
                let error = format!("{error:#}");
                assert!(error.len() < 1000, "{number}: {error}");
                refused += 1;
            }
            Err(_) => panic!("the damage of seed {number} panics: {bytes:?}"),
        }
    }
    assert!(read > 10 && refused > 10, "{read} read, {refused} refused");
}

/// An array of NumPy, of one byte order.
fn npy_of(kind: &str, shape: &str, samples: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    let header = format!("{header:<117}\n");
    [&b"\x93NUMPY\x01\x00"[..], &(header.len() as u16).to_le_bytes(), header.as_bytes(), samples].concat()
}

fn i16s(values: &[i16]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn told(bytes: &[u8], encoding: Encoding) -> (Vec<Option<f32>>, (u32, u32), Vec<String>) {
    let file =
        parse(Path::new("map"), bytes, encoding, EncodingOptions::TRUTH).unwrap_or_else(|error| panic!("{error}"));
    let values = file.map.data().iter().map(|v| v.is_finite().then_some(*v)).collect();
    (values, (file.map.width(), file.map.height()), file.doubts)
}

const PLAIN: Encoding = Encoding { scale: None, depth: None, invalid: None };

#[test]
fn maps_of_opencv_count_sixteenths_below_which_there_is_none() {
    let mut tiff = Cursor::new(Vec::new());
    let mut encoder = ::tiff::encoder::TiffEncoder::new(&mut tiff).unwrap();
    encoder.write_image::<::tiff::encoder::colortype::GrayI16>(2, 2, &[-16, 0, 128, 325]).unwrap();
    for file in [npy_of("<i2", "(2, 2)", &i16s(&[-16, 0, 128, 325])), tiff.into_inner()] {
        let (values, size, doubts) = told(&file, PLAIN);
        assert_eq!((values, size), (vec![None, Some(0.0), Some(8.0), Some(20.3125)], (2, 2)));
        assert!(doubts.len() == 1 && doubts[0].contains("16 a pixel, and -16 is no disparity"), "{doubts:?}");
        // What is given is not doubted, and replaces what is usual.
        let (values, _, doubts) = told(&file, Encoding { scale: Some(8.0), invalid: Some(128.0), ..PLAIN });
        assert_eq!((values, doubts.len()), (vec![Some(-2.0), Some(0.0), None, Some(40.625)], 0));
    }
    // A range from -32 px on: only the smallest value is none.
    let (values, ..) = told(&npy_of("<i2", "(1, 3)", &i16s(&[-528, -512, 8])), PLAIN);
    assert_eq!(values, [None, Some(-32.0), Some(0.5)]);
    // Without one below 0, or below 0 by another number, nothing tells what the values are.
    for (values, words) in [
        ([0, 128, 320, 1], &["give --gt-scale S", "OpenCV's matchers: 16"][..]),
        ([-1, 8, 20, 0], &["give --gt-scale S"]),
    ] {
        let error = parse(Path::new("map"), &npy_of("<i2", "(2, 2)", &i16s(&values)), PLAIN, EncodingOptions::TRUTH);
        let error = error.unwrap_err().to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    }
    let file = npy_of("<i2", "(2, 2)", &i16s(&[-1, 8, 20, 0]));
    let whole = Encoding { scale: Some(1.0), ..PLAIN };
    let error = parse(Path::new("map"), &file, whole, EncodingOptions::TRUTH).unwrap_err().to_string();
    assert!(error.contains("the whole number -1") && error.contains("give --gt-invalid -1"), "{error}");
    let (values, ..) = told(&file, Encoding { invalid: Some(-1.0), ..whole });
    assert_eq!(values, [None, Some(8.0), Some(20.0), None]);
}

#[test]
fn a_value_that_means_unknown_is_named_or_doubted() {
    let floats: Vec<f32> = (0..200).map(|i| if i < 50 { 0.0 } else { i as f32 }).collect();
    let file =
        |floats: &[f32]| npy_of("<f4", "(10, 20)", &floats.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>());
    let (values, _, doubts) = told(&file(&floats), PLAIN);
    assert!(values.iter().all(Option::is_some) && doubts.len() == 1, "{doubts:?}");
    assert!(doubts[0].contains("50 of 200 pixels") && doubts[0].ends_with("give --gt-invalid 0"), "{doubts:?}");
    let (values, _, doubts) = told(&file(&floats), Encoding { invalid: Some(0.0), ..PLAIN });
    assert_eq!((values.iter().filter(|v| v.is_none()).count(), doubts.len()), (50, 0));
    let below: Vec<f32> = floats.iter().map(|&v| if v == 0.0 { -999.9 } else { v }).collect();
    let (.., doubts) = told(&file(&below), PLAIN);
    assert!(doubts[0].contains("are -999.9"), "{doubts:?}");
    // As it was typed, not as 32 bits hold it.
    let (values, ..) = told(&file(&below), Encoding { invalid: Some(-999.9), ..PLAIN });
    assert_eq!(values.iter().filter(|v| v.is_none()).count(), 50);
    // A few zeros, and all of one value, are no reason to doubt.
    let few: Vec<f32> = (0..200).map(|i| i as f32).collect();
    assert!(told(&file(&few), PLAIN).2.is_empty() && told(&file(&[0.0; 200]), PLAIN).2.is_empty());
}

#[test]
fn arrays_may_have_sides_of_1_and_halves() {
    let halves = |order: fn(u16) -> [u8; 2]| [0x4800_u16, 0x4d00, 0x7e00, 0x3800].map(order).concat();
    let expected = vec![Some(8.0), Some(20.0), None, Some(0.5)];
    for (kind, order) in [("<f2", u16::to_le_bytes as fn(u16) -> [u8; 2]), (">f2", u16::to_be_bytes)] {
        for shape in ["(2, 2)", "(1, 2, 2)", "(1, 1, 2, 2)", "(2, 2, 1)", "(1, 2, 2, 1)"] {
            let (values, size, _) = told(&npy_of(kind, shape, &halves(order)), PLAIN);
            assert_eq!((values, size), (expected.clone(), (2, 2)), "{kind} {shape}");
        }
    }
    for shape in ["(4,)", "(2, 2, 2)", "(2, 1, 2)"] {
        let file = npy_of("<f2", shape, &halves(u16::to_le_bytes));
        let error = parse(Path::new("map"), &file, PLAIN, EncodingOptions::TRUTH).unwrap_err().to_string();
        assert!(error.contains("rows and columns are needed"), "{shape}: {error}");
    }
}

#[test]
fn big_tiffs_are_read() {
    let mut tiff = Cursor::new(Vec::new());
    let mut encoder = ::tiff::encoder::TiffEncoder::new_big(&mut tiff).unwrap();
    encoder.write_image::<::tiff::encoder::colortype::Gray32Float>(2, 1, &[8.5, f32::NAN]).unwrap();
    let tiff = tiff.into_inner();
    assert_eq!(tiff[2], 43);
    assert_eq!(told(&tiff, PLAIN).0, [Some(8.5), None]);
}

/// An OpenEXR file of 3 x 2 pixels.
fn exr_of(channels: Vec<(&str, FlatSamples)>, compression: Compression) -> Vec<u8> {
    let channels = channels.into_iter().map(|(name, samples)| AnyChannel::new(name, samples)).collect();
    let encoding = ::exr::prelude::Encoding { compression, ..Default::default() };
    let layer = Layer::new((3, 2), LayerAttributes::named("map"), encoding, AnyChannels::sort(channels));
    let mut bytes = Cursor::new(Vec::new());
    ::exr::prelude::Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

#[test]
fn one_channel_of_an_exr_is_read() {
    let values = vec![8.0_f32, f32::NAN, 20.25, f32::INFINITY, 0.5, 3.0];
    let f32s = || FlatSamples::F32(values.clone());
    let halves = FlatSamples::F16(values.iter().map(|&v| f16::from_f32(v)).collect());
    let zeros = || FlatSamples::F32(vec![0.0; 6]);
    let expected = [Some(8.0), None, Some(20.25), None, Some(0.5), Some(3.0)];
    for (channels, compression) in [
        (vec![("Y", f32s())], Compression::Uncompressed),
        (vec![("any", halves)], Compression::ZIP16),
        (vec![("R", f32s()), ("G", f32s()), ("B", f32s())], Compression::RLE),
        (vec![("A", zeros()), ("Z", f32s())], Compression::ZIP1),
        (vec![("R", zeros()), ("disparity", f32s())], Compression::PIZ),
    ] {
        let file = exr_of(channels, compression);
        let (values, size, _) = told(&file, PLAIN);
        assert!(size == (3, 2), "{size:?}");
        assert_eq!(values, expected, "{compression:?}");
    }
    let file = exr_of(vec![("U", zeros()), ("W", zeros())], Compression::Uncompressed);
    let error = parse(Path::new("map"), &file, PLAIN, EncodingOptions::TRUTH).unwrap_err().to_string();
    assert!(error.contains("it has the channels U, W"), "{error}");
}
