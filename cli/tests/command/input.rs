//! What the command takes for an image: turned ones, samples of 10 bits in 16, and files that are none or pretend to be
//! huge.
//!
//! On the CPU, so that no adapter is needed.

use crate::support::{contents, is_one_line_error, on, pair, refuses, scene, stderr, stdout, succeeds, texture};
use image::codecs::{jpeg::JpegEncoder, png::PngEncoder, webp::WebPEncoder};
use image::metadata::Orientation;
use image::{DynamicImage, ExtendedColorType, GrayImage, ImageBuffer, ImageEncoder, Luma};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// The map of two images, as a file.
fn map(folder: &TempDir, left: &str, right: &str, more: &[&str]) -> Vec<u8> {
    succeeds(folder.path(), &on(left, right, &[more, &["-o", "map.npy"]].concat()));
    fs::read(folder.path().join("map.npy")).unwrap()
}

fn json(folder: &TempDir, args: &[&str]) -> Value {
    serde_json::from_slice(&succeeds(folder.path(), args).stdout).unwrap()
}

// Orientation.

/// What a file says of an image that has to be turned by `orientation` to stand upright.
fn exif(orientation: u8) -> Vec<u8> {
    let mut exif = b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0".to_vec();
    exif.extend([orientation, 0, 0, 0, 0, 0, 0, 0]);
    exif
}

/// The image as it is stored with that orientation.
fn stored(upright: &GrayImage, orientation: u8) -> GrayImage {
    let back = match orientation {
        6 => 8,
        8 => 6,
        other => other, // its own inverse
    };
    let mut image = DynamicImage::from(upright.clone());
    image.apply_orientation(Orientation::from_exif(back).unwrap());
    image.into_luma8()
}

fn encode(image: &GrayImage, mut encoder: impl ImageEncoder, orientation: u8, colour: bool) {
    encoder.set_exif_metadata(exif(orientation)).unwrap();
    let (width, height) = image.dimensions();
    if colour {
        let rgb = DynamicImage::from(image.clone()).into_rgb8();
        encoder.write_image(rgb.as_raw(), width, height, ExtendedColorType::Rgb8).unwrap();
    } else {
        encoder.write_image(image.as_raw(), width, height, ExtendedColorType::L8).unwrap();
    }
}

fn save_turned(path: &Path, upright: &GrayImage, orientation: u8) {
    let image = stored(upright, orientation);
    let mut bytes = Vec::new();
    match path.extension().unwrap().to_str().unwrap() {
        "png" => encode(&image, PngEncoder::new(&mut bytes), orientation, false),
        "webp" => encode(&image, WebPEncoder::new_lossless(&mut bytes), orientation, true),
        "jpg" => encode(&image, JpegEncoder::new_with_quality(&mut bytes, 100), orientation, false),
        "tif" => {
            let mut cursor = std::io::Cursor::new(&mut bytes);
            let mut encoder = tiff::encoder::TiffEncoder::new(&mut cursor).unwrap();
            let (width, height) = image.dimensions();
            let mut file = encoder.new_image::<tiff::encoder::colortype::Gray8>(width, height).unwrap();
            file.encoder().write_tag(tiff::tags::Tag::Orientation, u16::from(orientation)).unwrap();
            file.write_data(image.as_raw()).unwrap();
        }
        other => panic!("{other}"),
    }
    fs::write(path, bytes).unwrap();
}

#[test]
fn every_orientation_of_every_format_is_applied() {
    let folder = scene();
    let [left, right] = pair(48, 30);
    let upright = map(&folder, "left.png", "right.png", &[]);
    for ending in ["png", "webp", "tif"] {
        for orientation in 1..=8 {
            // The other image is turned otherwise.
            let names = [format!("l.{ending}"), format!("r.{ending}")];
            save_turned(&folder.path().join(&names[0]), &left, orientation);
            save_turned(&folder.path().join(&names[1]), &right, 9 - orientation);
            assert_eq!(map(&folder, &names[0], &names[1], &[]), upright, "{ending}, {orientation}");
        }
    }
    save_turned(&folder.path().join("l.jpg"), &left, 3);
    save_turned(&folder.path().join("r.jpg"), &right, 3);
    stored(&left, 3).save(folder.path().join("plain.png")).unwrap();
    let output = succeeds(folder.path(), &on("l.jpg", "r.jpg", &["-o", "jpg.npy"]));
    assert!(stdout(&output).contains("turned   by 180 degrees (EXIF)\n"), "{}", stdout(&output));
    assert_eq!(json(&folder, &on("l.jpg", "r.jpg", &["-o", "j.npy", "--json"]))["turned"], "by 180 degrees (EXIF)");
    // A size is that of the upright image.
    save_turned(&folder.path().join("l.png"), &left, 6);
    refuses(folder.path(), &on("l.png", "plain.jpg", &[]), &["plain.jpg"]);
    let told = json(&folder, &on("l.png", "right.png", &["-o", "j.npy", "--json"]));
    assert_eq!((&told["width"], &told["height"]), (&48.into(), &30.into()));
    assert_eq!(told["turned"], "left by 90 degrees clockwise, right as stored (EXIF)");
}

#[test]
fn frames_of_a_video_and_masks_are_turned_too() {
    let folder = scene();
    let [left, right] = pair(48, 30);
    for side in ["l", "r"] {
        fs::create_dir(folder.path().join(side)).unwrap();
    }
    save_turned(&folder.path().join("l/1.png"), &left, 8);
    save_turned(&folder.path().join("r/1.png"), &right, 8);
    let upright = map(&folder, "left.png", "right.png", &[]);
    for verb in ["video", "batch"] {
        let args = [verb, "l", "r", "-o", verb, "--disp", "16", "--backend", "cpu", "--format", "npy", "-q"];
        succeeds(folder.path(), &args);
        assert_eq!(fs::read(folder.path().join(verb).join("1.npy")).unwrap(), upright, "{verb}");
    }
    let mask = GrayImage::from_fn(48, 30, |x, _| Luma([if x < 20 { 255 } else { 0 }]));
    save_turned(&folder.path().join("mask.png"), &mask, 6);
    let score = ["eval", "map.npy", "map.npy", "--gt-mask", "mask.png", "--json"];
    assert!(json(&folder, &score)["evaluation"]["pixels"].as_u64().unwrap() <= 600);
}

// Bits.

/// Samples of the texture in so many bits.
fn in_bits(shift: u32, bits: u32, place: impl Fn(u32) -> u16) -> ImageBuffer<Luma<u16>, Vec<u16>> {
    ImageBuffer::from_fn(48, 30, |x, y| {
        let fine = u32::from(texture(x + shift, y)) << 8 | u32::from(texture(3 * x + 3 * shift + 7, y));
        Luma([place(fine >> (16 - bits))])
    })
}

#[test]
fn few_bits_in_16_give_the_map_of_the_same_picture_in_16() {
    let folder = scene();
    for (bits, told) in [(8, 8), (9, 10), (10, 10), (12, 12), (14, 14)] {
        let most = (1_u32 << told) - 1;
        for (name, shift) in [("l", 0), ("r", crate::support::SHIFT)] {
            let path = |kind: &str| folder.path().join(format!("{name}_{kind}.png"));
            in_bits(shift, bits, |v| v as u16).save(path("few")).unwrap();
            in_bits(shift, bits, |v| ((v * 65_535 + most / 2) / most) as u16).save(path("all")).unwrap();
        }
        for preset in ["balanced", "classic", "fast"] {
            let more = ["--preset", preset];
            let few = map(&folder, "l_few.png", "r_few.png", &more);
            let all = map(&folder, "l_all.png", "r_all.png", &[&more[..], &["--bits", "16"]].concat());
            assert_eq!(few, all, "{bits} bits, {preset}");
        }
        let run = on("l_few.png", "r_few.png", &["-o", "m.npy"]);
        assert!(stdout(&succeeds(folder.path(), &run)).contains(&format!("samples  {told} bits in 16\n")), "{bits}");
        assert_eq!(json(&folder, &[&run[..], &["--json"]].concat())["bits"], told);
        let given = map(&folder, "l_few.png", "r_few.png", &["--bits", &told.to_string()]);
        assert_eq!(given, map(&folder, "l_few.png", "r_few.png", &[]));
    }
    // One whose largest sample has 16 bits is as it was.
    let before = stdout(&succeeds(folder.path(), &on("l_all.png", "r_all.png", &["-o", "m.npy"])));
    assert!(!before.contains("samples"), "{before}");
    let told = json(&folder, &on("left.png", "right.png", &["-o", "m.npy", "--json"]));
    assert_eq!(told["bits"], 8);
}

#[test]
fn bits_that_do_not_hold_the_samples_are_refused() {
    let folder = scene();
    in_bits(0, 12, |v| v as u16).save(folder.path().join("l.png")).unwrap();
    in_bits(crate::support::SHIFT, 10, |v| v as u16).save(folder.path().join("r.png")).unwrap();
    refuses(folder.path(), &on("l.png", "r.png", &["--bits", "10"]), &["l.png", "--bits is 10", "--bits 12"]);
    for bits in ["7", "17", "0", "-1", "ten", ""] {
        refuses(folder.path(), &on("l.png", "r.png", &["--bits", bits]), &["--bits"]);
    }
    // Both are stretched alike, by what the larger one needs.
    assert_eq!(json(&folder, &on("r.png", "l.png", &["-o", "m.npy", "--json"]))["bits"], 12);
}

#[test]
fn the_first_frame_decides_for_a_video() {
    let folder = tempfile::tempdir().unwrap();
    for (side, shift) in [("l", 0), ("r", crate::support::SHIFT)] {
        fs::create_dir(folder.path().join(side)).unwrap();
        for (frame, bits) in [(1, 10), (2, 8), (3, 12)] {
            in_bits(shift, bits, |v| v as u16).save(folder.path().join(format!("{side}/{frame}.png"))).unwrap();
        }
    }
    let args = |out, more: &[&'static str]| {
        [&["video", "l", "r", "-o", out, "--disp", "16", "--backend", "cpu", "--format", "npy", "-q"], more].concat()
    };
    let output = crate::support::run(folder.path(), &args("maps", &[]));
    assert_eq!(output.status.code(), Some(1));
    let told = stderr(&output);
    assert!(told.contains("l/3.png") && told.contains("the first pair's samples have 10; give --bits 12"), "{told}");
    let dark = map(&folder, "l/2.png", "r/2.png", &["--bits", "10"]);
    assert_eq!(fs::read(folder.path().join("maps/2.npy")).unwrap(), dark);
    succeeds(folder.path(), &args("all", &["--bits", "12"]));
    // Maps of other bits are not resumed, nor those of exchanged views.
    refuses(folder.path(), &args("all", &["--resume"]), &["bits 12 there and not known now"]);
    refuses(
        folder.path(),
        &args("all", &["--resume", "--bits", "12", "--swap"]),
        &["swap not known there and true now"],
    );
}

#[test]
fn swap_is_the_other_order() {
    let folder = scene();
    let plain = map(&folder, "left.png", "right.png", &[]);
    assert_ne!(map(&folder, "right.png", "left.png", &[]), plain);
    assert_eq!(map(&folder, "right.png", "left.png", &["--swap"]), plain);
    for side in ["left", "right"] {
        fs::create_dir(folder.path().join(side)).unwrap();
        fs::copy(folder.path().join(format!("{side}.png")), folder.path().join(side).join("1.png")).unwrap();
    }
    for verb in ["video", "batch"] {
        let args =
            [verb, "right", "left", "-o", verb, "--disp", "16", "--backend", "cpu", "--format", "npy", "-q", "--swap"];
        succeeds(folder.path(), &args);
        assert_eq!(fs::read(folder.path().join(verb).join("1.npy")).unwrap(), plain, "{verb}");
    }
}

// What is no image.

#[test]
fn what_is_no_image_is_named_with_what_to_do() {
    let folder = scene();
    let lfs = format!("version https://git-lfs.github.com/spec/v1\noid sha256:{}\nsize 12345\n", "0".repeat(64));
    let ftyp = |brand: &str| [b"\0\0\0\x18ftyp", brand.as_bytes(), &[0; 40]].concat();
    let mut raw = b"II*\0\x08\0\0\0\x01\0\xfe\0\x04\0\x01\0\0\0\x01\0\0\0\0\0\0\0".to_vec();
    raw.extend([0; 64]);
    let files: [(&str, Vec<u8>, &[&str]); 18] = [
        ("lfs.png", lfs.into_bytes(), &["Git LFS pointer", "git lfs pull"]),
        ("annex.png", b"/annex/objects/SHA256E-s1--ab.png\n".to_vec(), &["git-annex pointer", "git annex get"]),
        ("page.png", b"\n<!DOCTYPE html><html><body>404".to_vec(), &["web page", "download"]),
        ("error.jpg", b"<?xml version=\"1.0\"?><Error><Code>AccessDenied".to_vec(), &["error message"]),
        ("phone.jpg", ftyp("heic"), &["HEIC", "heif-convert phone.jpg phone.png"]),
        ("a phone.heic", ftyp("mif1"), &["HEIC", "heif-convert 'a phone.heic' 'a phone.png'"]),
        ("phone.png", ftyp("avif"), &["AVIF", "avifdec phone.png phone.converted.png"]),
        ("phone.avif", ftyp("mif1avif"), &["AVIF", "avifdec phone.avif phone.png"]),
        ("map.jp2", b"\0\0\0\x0cjP  \r\n\x87\n".to_vec(), &["JPEG 2000", "opj_decompress -i map.jp2 -o map.png"]),
        ("code.j2k", b"\xff\x4f\xff\x51\0\0".to_vec(), &["JPEG 2000", "magick code.j2k code.png"]),
        ("film.png", ftyp("isom"), &["video", "ffmpeg", "gpu-stereo video"]),
        ("film.mkv", b"\x1a\x45\xdf\xa3aaaaaaaaaa".to_vec(), &["video"]),
        ("film.avi", b"RIFF\0\0\0\0AVI LIST".to_vec(), &["video"]),
        ("raw.cr3", ftyp("crx "), &["raw file"]),
        ("raw.nef", raw, &["raw file"]),
        ("map.pfm", b"Pf\n1 1\n-1\nabcd".to_vec(), &["PFM"]),
        ("map.npy", b"\x93NUMPY\x01\0".to_vec(), &["NumPy"]),
        ("empty.png", Vec::new(), &["is empty"]),
    ];
    for (name, bytes, words) in files {
        fs::write(folder.path().join(name), bytes).unwrap();
        refuses(folder.path(), &on(name, "right.png", &[]), &[&[name], words].concat());
        refuses(folder.path(), &on("left.png", name, &[]), &[&[name], words].concat());
    }
    let address = "https://example.org/a?b=c&d";
    refuses(folder.path(), &on(address, "right.png", &[]), &["curl -LO 'https://example.org/a?b=c&d'"]);
    refuses(
        folder.path(),
        &["video", "https://example.org/l.mp4", "right.png", "-o", "m", "--disp", "16"],
        &["curl -LO"],
    );
    fs::copy(folder.path().join("lfs.png"), folder.path().join("list.csv")).unwrap();
    refuses(folder.path(), &["batch", "list.csv", "-o", "m", "--disp", "16"], &["git lfs pull"]);
    // So is a truth that was not fetched.
    refuses(folder.path(), &on("left.png", "right.png", &["--gt", "lfs.png", "-o", "m.npy"]), &["git lfs pull"]);
}

#[test]
fn further_images_of_a_file_are_told() {
    let folder = scene();
    let [left, _] = pair(48, 30);
    let mut gif = Vec::new();
    {
        let mut encoder = image::codecs::gif::GifEncoder::new(&mut gif);
        for _ in 0..2 {
            encoder.encode_frame(image::Frame::new(DynamicImage::from(left.clone()).into_rgba8())).unwrap();
        }
    }
    fs::write(folder.path().join("two.gif"), gif).unwrap();
    let mut one = Vec::new();
    DynamicImage::from(left.clone())
        .into_rgba8()
        .write_to(&mut std::io::Cursor::new(&mut one), image::ImageFormat::Gif)
        .unwrap();
    fs::write(folder.path().join("one.gif"), one).unwrap();
    let mut pages = std::io::Cursor::new(Vec::new());
    let mut encoder = tiff::encoder::TiffEncoder::new(&mut pages).unwrap();
    for _ in 0..2 {
        encoder.write_image::<tiff::encoder::colortype::Gray8>(48, 30, left.as_raw()).unwrap();
    }
    fs::write(folder.path().join("two.tif"), pages.into_inner()).unwrap();
    for (name, more) in [("two.gif", true), ("one.gif", false), ("two.tif", true)] {
        let output = succeeds(folder.path(), &on(name, "right.png", &["-o", "m.npy", "--json"]));
        let told: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(stderr(&output).contains("holds several images"), more, "{name}");
        assert_eq!(told["warnings"].as_array().unwrap().len(), usize::from(more), "{name}");
    }
}

// Files that unpack to more than they should.

fn crc(bytes: &[u8]) -> [u8; 4] {
    let crc = bytes.iter().fold(!0_u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg()))
    });
    (!crc).to_be_bytes()
}

fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let named = [kind, data].concat();
    [&(data.len() as u32).to_be_bytes(), &named[..], &crc(&named)].concat()
}

/// A zlib stream of so many megabytes of zeros.
fn zeros(megabytes: usize) -> Vec<u8> {
    // One block with fixed codes: a literal 0, then lengths of 258 at distance 1, each in 13 bits.
    let mut bits: Vec<bool> = vec![true, true, false];
    let mut put = |code: u32, length: u32| bits.extend((0..length).rev().map(|i| code >> i & 1 == 1));
    put(0b0011_0000, 8);
    for _ in 0..(megabytes << 20) / 258 {
        put(0b1100_0101, 8); // length 258
        put(0, 5); // distance 1
    }
    put(0, 7);
    let bytes = bits.chunks(8).map(|bits| bits.iter().rev().fold(0_u8, |byte, &bit| byte << 1 | u8::from(bit)));
    [0x78, 0x01].into_iter().chain(bytes).chain([0; 4]).collect()
}

/// A run with 400 MB of address space at most, and its time. With more it would end otherwise than in order.
#[cfg(target_os = "linux")]
fn limited(folder: &Path, args: &[&str]) -> (Output, Duration) {
    let start = Instant::now();
    let mut shell = Command::new("sh");
    shell.args(["-c", "ulimit -v 400000; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_gpu-stereo")]);
    let output = shell.args(args).current_dir(folder).output().unwrap();
    (output, start.elapsed())
}

#[cfg(target_os = "linux")]
#[test]
fn small_files_do_not_unpack_to_much() {
    let folder = scene();
    let png = fs::read(folder.path().join("left.png")).unwrap();
    let (head, tail) = png.split_at(33); // signature and IHDR
    let iccp = |data: Vec<u8>| [head, &chunk(b"iCCP", &[b"p\0\0", &data[..]].concat()), tail].concat();
    fs::write(folder.path().join("profile.png"), iccp(zeros(256))).unwrap();
    // A profile that is too large is no reason to refuse the image, but it is not unpacked.
    let (output, time) = limited(folder.path(), &on("profile.png", "right.png", &["-o", "m.npy"]));
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(time < Duration::from_secs(10), "{time:?}");

    // Headers that declare much.
    let mut jpeg = Vec::new();
    JpegEncoder::new(&mut jpeg).encode_image(&GrayImage::new(8, 8)).unwrap();
    let frame = jpeg.windows(2).position(|pair| pair == [0xff, 0xc0]).unwrap();
    for (name, side) in [("large.jpg", 30_000_u16), ("fair.jpg", 11_000)] {
        let mut bomb = jpeg.clone();
        bomb[frame + 5..frame + 7].copy_from_slice(&side.to_be_bytes());
        bomb[frame + 7..frame + 9].copy_from_slice(&side.to_be_bytes());
        fs::write(folder.path().join(name), bomb).unwrap();
    }
    fs::write(folder.path().join("large.pgm"), "P5 11000 11000 255\nabc").unwrap();
    fs::write(folder.path().join("large.ppm"), "P3 11000 11000 255\n1 2 3").unwrap();
    let mut tif = std::io::Cursor::new(Vec::new());
    let mut encoder = tiff::encoder::TiffEncoder::new(&mut tif).unwrap();
    encoder.write_image::<tiff::encoder::colortype::Gray8>(8, 8, &[0; 64]).unwrap();
    let mut tif = tif.into_inner();
    let entries = u32::from_le_bytes(tif[4..8].try_into().unwrap()) as usize;
    for entry in 0..usize::from(u16::from_le_bytes(tif[entries..entries + 2].try_into().unwrap())) {
        let at = entries + 2 + 12 * entry;
        if matches!(u16::from_le_bytes([tif[at], tif[at + 1]]), 256 | 257 | 278) {
            tif[at + 2..at + 4].copy_from_slice(&4_u16.to_le_bytes());
            tif[at + 8..at + 12].copy_from_slice(&11_000_u32.to_le_bytes());
        }
    }
    fs::write(folder.path().join("large.tif"), tif).unwrap();
    let before = contents(folder.path());
    for name in ["large.jpg", "fair.jpg", "large.pgm", "large.ppm", "large.tif"] {
        let (output, time) = limited(folder.path(), &on(name, "right.png", &["-o", "m2.npy"]));
        is_one_line_error(&output, &[name]);
        assert!(time < Duration::from_secs(10), "{name}: {time:?}");
    }
    assert!(contents(folder.path()) == before);
}
