use super::*;
use crate::files::damage::damaged;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
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
    let mut encoder = tiff::encoder::TiffEncoder::new(&mut tiff).unwrap();
    encoder.write_image::<tiff::encoder::colortype::Gray32Float>(2, 2, &[1.0, 2.0, f32::NAN, 3.0]).unwrap();
    let mut png = Cursor::new(Vec::new());
    image::ImageBuffer::<image::Luma<u16>, _>::from_raw(2, 2, vec![0_u16, 256, 300, 65535])
        .unwrap()
        .write_to(&mut png, ImageFormat::Png)
        .unwrap();
    let pgm = b"P5\n# made by hand\n3 2\n255\n\x00\x01\x02\x03\x04\x05".to_vec();
    vec![pfm, f4, u1, tiff.into_inner(), png.into_inner(), pgm]
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
        let error = parse(Path::new("many"), file, Encoding::default(), "--scale").unwrap_err();
        let told = format!("{error:#}");
        assert!(told.contains("20000x20000 pixels") && told.contains("at most 134217728"), "{told}");
    }
}

#[test]
fn nested_brackets_in_a_header_are_refused_at_once() {
    let header = format!("{{'descr': '<f4', 'fortran_order': {}, 'shape': (2, 3), }}", "[".repeat(60));
    let file = [&b"\x93NUMPY\x01\x00"[..], &(header.len() as u16).to_le_bytes(), header.as_bytes()].concat();
    let error = parse(Path::new("nested"), &file, Encoding::default(), "--scale").unwrap_err();
    assert!(format!("{error:#}").contains("62 brackets"), "{error:#}");
}

/// A second; GPU_STEREO_FUZZ_SECONDS says how long else.
#[test]
fn damaged_maps_are_refused_or_read_and_never_panic() {
    let seconds = std::env::var("GPU_STEREO_FUZZ_SECONDS").map_or(1, |text| text.parse().unwrap());
    let (end, seeds) = (Instant::now() + Duration::from_secs(seconds), seeds());
    let encodings = [(Some(2.0), None), (None, Some(386.2)), (None, None)];
    let encodings = encodings.map(|(scale, depth)| Encoding { scale, depth });
    for seed in &seeds {
        let map = parse(Path::new("seed"), seed, encodings[0], "--scale").unwrap();
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
        match std::panic::catch_unwind(|| parse(Path::new("damaged"), &bytes, encoding, "--scale")) {
            Ok(Ok(map)) => {
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
