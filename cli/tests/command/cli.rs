//! The command as a user meets it: the built program on small images, its files, its words and its exit codes.
//!
//! Everything runs on the CPU, so that no adapter is needed; where adapters matter the tests say so.

use crate::support::{
    SHIFT, command, contents, is_one_line_error, not_tested, on, pair, refuses, run, scene, stderr, stdout, succeeds,
    texture,
};
use gpu_stereo::{Params, Preset};
use image::{DynamicImage, GrayImage, ImageBuffer, ImageFormat, Luma, Rgb, Rgba};
use serde_json::Value;
use std::ffi::OsStr;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use tempfile::TempDir;

// Independent readers of what the command writes: disparity in pixels, rows from the top, NaN invalid.

fn read_kitti(path: &Path) -> Vec<f32> {
    let DynamicImage::ImageLuma16(image) = image::open(path).unwrap() else { panic!("not 16-bit gray") };
    image.into_raw().into_iter().map(|v| if v == 0 { f32::NAN } else { f32::from(v) / 256.0 }).collect()
}

fn read_pfm(path: &Path, width: usize, height: usize) -> Vec<f32> {
    let bytes = fs::read(path).unwrap();
    let header = format!("Pf\n{width} {height}\n-1.0\n");
    let samples = bytes.strip_prefix(header.as_bytes()).unwrap();
    assert_eq!(samples.len(), 4 * width * height);
    let rows = samples.chunks_exact(4 * width).rev(); // from the bottom
    rows.flat_map(little_endian).map(|v| if v == f32::INFINITY { f32::NAN } else { v }).collect()
}

fn read_npy(path: &Path, width: usize, height: usize) -> Vec<f32> {
    let bytes = fs::read(path).unwrap();
    assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
    let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = std::str::from_utf8(&bytes[10..10 + length]).unwrap().replace(' ', "");
    assert!(header.contains("'descr':'<f4'") && header.contains("'fortran_order':False"), "{header}");
    assert!(header.contains(&format!("'shape':({height},{width}")), "{header}");
    let samples = &bytes[10 + length..];
    assert_eq!(samples.len(), 4 * width * height);
    little_endian(samples).collect()
}

fn read_tiff(path: &Path) -> Vec<f32> {
    let mut decoder = tiff::decoder::Decoder::new(fs::File::open(path).unwrap()).unwrap();
    let tiff::decoder::DecodingResult::F32(samples) = decoder.read_image().unwrap() else { panic!("not 32-bit float") };
    samples
}

fn little_endian(bytes: &[u8]) -> impl Iterator<Item = f32> {
    bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
}

fn bits(samples: &[f32]) -> Vec<Option<u32>> {
    samples.iter().map(|v| (!v.is_nan()).then(|| v.to_bits())).collect()
}

/// The share of pixels within 1/2 px of `disparity`.
fn share_of(samples: &[f32], disparity: f32) -> f64 {
    samples.iter().filter(|&&v| (v - disparity).abs() < 0.5).count() as f64 / samples.len() as f64
}

// What it writes.

#[test]
fn every_format_holds_the_same_map() {
    let folder = scene();
    let at = |name: &str| folder.path().join(name);
    let names = ["a.png", "b.pfm", "c.npy", "d.tif", "e.TIFF", "f.PNG"];
    let mut args = on("left.png", "right.png", &["--color", "picture.png"]);
    names.iter().for_each(|name| args.extend(["-o", name]));
    let output = succeeds(folder.path(), &args);
    assert!(stdout(&output).contains("a.png, b.pfm, c.npy, d.tif, e.TIFF, f.PNG, picture.png"), "{}", stdout(&output));

    let map = read_npy(&at("c.npy"), 48, 30);
    assert!(share_of(&map, SHIFT as f32) > 0.7);
    assert!(map.iter().any(|v| v.is_nan()), "the left border sees nothing");
    assert_eq!(bits(&map), bits(&read_pfm(&at("b.pfm"), 48, 30)));
    assert_eq!(bits(&map), bits(&read_tiff(&at("d.tif"))));
    assert_eq!(bits(&map), bits(&read_tiff(&at("e.TIFF"))));
    assert_eq!(bits(&map), bits(&read_kitti(&at("a.png")))); // 1/16 px is exact in 1/256
    assert_eq!(bits(&map), bits(&read_kitti(&at("f.PNG"))));

    let DynamicImage::ImageRgb8(picture) = image::open(at("picture.png")).unwrap() else { panic!("not 8-bit RGB") };
    assert_eq!(picture.dimensions(), (48, 30));
    for (pixel, value) in picture.pixels().zip(&map) {
        assert_eq!(pixel.0 == [0; 3], value.is_nan(), "black is invalid and nothing else");
    }
    assert!(!at("disparity.png").exists() && !at("disparity_color.png").exists());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2 + names.len() + 1, "temporary files are gone");
}

#[test]
fn without_outputs_the_default_files_are_written() {
    let folder = scene();
    let output = succeeds(folder.path(), &on("left.png", "right.png", &[]));
    assert_eq!(stderr(&output), "");
    assert!(share_of(&read_kitti(&folder.path().join("disparity.png")), SHIFT as f32) > 0.7);
    assert!(image::open(folder.path().join("disparity_color.png")).is_ok());
    for told in ["CPU with ", "48 x 30", "16 disparities, 0 to 15 px", " ms", "disparity.png, disparity_color.png"] {
        assert!(stdout(&output).contains(told), "{told:?} is not in {}", stdout(&output));
    }
}

#[test]
fn color_alone_writes_the_picture_alone() {
    let folder = scene();
    succeeds(folder.path(), &on("left.png", "right.png", &["--color", "c.png"]));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3);
}

#[test]
fn the_mask_is_255_where_there_is_a_disparity() {
    let folder = scene();
    succeeds(folder.path(), &on("left.png", "right.png", &["--mask", "mask.png"]));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3, "the mask alone");
    succeeds(folder.path(), &on("left.png", "right.png", &["-o", "map.npy"]));
    let map = read_npy(&folder.path().join("map.npy"), 48, 30);
    let DynamicImage::ImageLuma8(mask) = image::open(folder.path().join("mask.png")).unwrap() else { panic!() };
    assert_eq!(mask.dimensions(), (48, 30));
    assert!(mask.into_raw().iter().zip(&map).all(|(&mask, value)| mask == if value.is_nan() { 0 } else { 255 }));
    assert!(map.iter().any(|v| v.is_nan()) && map.iter().any(|v| !v.is_nan()));
}

#[test]
fn the_confidence_is_0_where_there_is_no_disparity() {
    let folder = noisy();
    for method in ["sgm", "bm"] {
        let files = ["--method", method, "--confidence", "c.png", "--mask", "mask.png", "-o", "m.npy"];
        succeeds(folder.path(), &on("left.png", "right.png", &files));
        let read = |name: &str| match image::open(folder.path().join(name)).unwrap() {
            DynamicImage::ImageLuma8(image) if image.dimensions() == (48, 30) => image.into_raw(),
            other => panic!("{name} is {:?} of {}x{}", other.color(), other.width(), other.height()),
        };
        let (confidence, mask) = (read("c.png"), read("mask.png"));
        assert!(confidence.iter().zip(&mask).all(|(&confidence, &mask)| (confidence > 0) == (mask > 0)));
        let known: std::collections::BTreeSet<_> = confidence.iter().collect();
        assert!(known.len() > 10, "{method}: {known:?}");
        // It changes nothing about the map.
        let with = fs::read(folder.path().join("m.npy")).unwrap();
        assert!(map(&folder, &format!("--method {method}")) == with, "{method}");
    }
}

#[test]
fn a_valid_disparity_of_0_is_not_the_invalid_0() {
    let folder = scene();
    succeeds(folder.path(), &on("left.png", "left.png", &["--subpixel", "off", "-o", "zero.png"]));
    let DynamicImage::ImageLuma16(image) = image::open(folder.path().join("zero.png")).unwrap() else { panic!() };
    let ones = image.pixels().filter(|pixel| pixel.0 == [1]).count();
    assert!(ones * 10 > image.pixels().len() * 9, "{ones}");
}

#[test]
fn negative_disparities_go_to_formats_that_hold_them() {
    let folder = scene();
    let range = ["--min-disp", "-12"];
    let output = succeeds(folder.path(), &on("right.png", "left.png", &range));
    assert!(stderr(&output).starts_with("note: ") && stderr(&output).contains("disparity.tif"), "{}", stderr(&output));
    assert!(share_of(&read_tiff(&folder.path().join("disparity.tif")), -(SHIFT as f32)) > 0.7);
    assert!(!folder.path().join("disparity.png").exists());

    // The KITTI format cannot hold them; and then the good file beside it is not written, either.
    let args = on("right.png", "left.png", &[&range[..], &["-o", "x.npy", "-o", "x.png"]].concat());
    refuses(folder.path(), &args, &["x.png", "px", "0 to 255.9375", ".pfm", ".npy", ".tif"]);
}

#[test]
fn a_range_beyond_255_goes_to_a_format_that_holds_it() {
    let folder = scene();
    let args = ["left.png", "right.png", "--disp", "257", "--backend", "cpu"];
    assert!(stderr(&succeeds(folder.path(), &args)).contains("disparity.tif"));
    assert!(folder.path().join("disparity.tif").exists() && !folder.path().join("disparity.png").exists());
}

#[test]
fn a_second_run_replaces_and_repeats_to_the_byte() {
    let folder = scene();
    fs::write(folder.path().join("d.png"), "old").unwrap();
    succeeds(folder.path(), &on("left.png", "right.png", &["-o", "d.png"]));
    let first = contents(folder.path());
    succeeds(folder.path(), &on("left.png", "right.png", &["-o", "d.png"]));
    assert!(contents(folder.path()) == first);
    assert!(read_kitti(&folder.path().join("d.png")).len() == 48 * 30);
}

#[cfg(unix)]
#[test]
fn written_files_have_the_permissions_of_ordinary_files() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = scene();
    succeeds(folder.path(), &on("left.png", "right.png", &[]));
    let mode = |name: &str| fs::metadata(folder.path().join(name)).unwrap().permissions().mode();
    assert_eq!(mode("disparity.png"), mode("left.png"));
    assert_eq!(mode("disparity_color.png"), mode("left.png"));
}

#[cfg(unix)]
#[test]
fn a_link_stays_a_link() {
    let folder = scene();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("store")).unwrap();
    fs::write(at("store/real.png"), "old").unwrap();
    std::os::unix::fs::symlink("store/real.png", at("link.png")).unwrap();
    succeeds(folder.path(), &on("left.png", "right.png", &["-o", "link.png"]));
    assert!(fs::symlink_metadata(at("link.png")).unwrap().is_symlink());
    assert_eq!(read_kitti(&at("store/real.png")).len(), 48 * 30);
    refuses(folder.path(), &on("left.png", "right.png", &["-o", "link.png", "-o", "store/real.png"]), &["twice"]);
}

// What it reads.

#[test]
fn every_input_format_gives_the_map() {
    let folder = scene();
    let [left, right] = pair(48, 30);
    let lossless = [
        ("png", ImageFormat::Png),
        ("pgm", ImageFormat::Pnm),
        ("tif", ImageFormat::Tiff),
        ("bmp", ImageFormat::Bmp),
        ("webp", ImageFormat::WebP),
        ("tga", ImageFormat::Tga),
        ("unknown-ending", ImageFormat::Png), // the content tells
    ];
    succeeds(folder.path(), &on("left.png", "right.png", &["-o", "expected.npy"]));
    let expected = fs::read(folder.path().join("expected.npy")).unwrap();
    for (ending, format) in lossless {
        let names = ["l", "r"].map(|side| format!("{side}.{ending}"));
        for (image, name) in [&left, &right].into_iter().zip(&names) {
            let image = DynamicImage::from(image.clone());
            let image = if format == ImageFormat::WebP { image.to_rgb8().into() } else { image };
            image.save_with_format(folder.path().join(name), format).unwrap();
        }
        succeeds(folder.path(), &on(&names[0], &names[1], &["-o", "got.npy"]));
        assert!(fs::read(folder.path().join("got.npy")).unwrap() == expected, "{ending}");
    }
    left.save(folder.path().join("l.jpg")).unwrap();
    right.save(folder.path().join("r.jpg")).unwrap();
    succeeds(folder.path(), &on("l.jpg", "r.jpg", &["-o", "got.npy"]));
    assert!(share_of(&read_npy(&folder.path().join("got.npy"), 48, 30), SHIFT as f32) > 0.6);
}

#[test]
fn depth_colour_and_alpha_change_nothing_and_may_differ_between_the_images() {
    let folder = scene();
    type OnePixel = fn(u8) -> DynamicImage;
    let kinds: [(&str, OnePixel); 6] = [
        ("gray8", |v| GrayImage::from_pixel(1, 1, Luma([v])).into()),
        ("gray16", |v| ImageBuffer::from_pixel(1, 1, Luma([u16::from(v) * 257])).into()),
        ("rgb8", |v| ImageBuffer::from_pixel(1, 1, Rgb([v; 3])).into()),
        ("rgb16", |v| ImageBuffer::from_pixel(1, 1, Rgb([u16::from(v) * 257; 3])).into()),
        ("rgba8", |v| ImageBuffer::from_pixel(1, 1, Rgba([v, v, v, 7])).into()),
        ("rgba16", |v| ImageBuffer::from_pixel(1, 1, Rgba([u16::from(v) * 257; 4])).into()),
    ];
    for (side, image) in ["l", "r"].into_iter().zip(pair(48, 30)) {
        for (kind, pixel) in kinds {
            let mut whole = pixel(0).resize_exact(48, 30, image::imageops::FilterType::Nearest);
            for (x, y, value) in image.enumerate_pixels() {
                image::imageops::replace(&mut whole, &pixel(value.0[0]), x.into(), y.into());
            }
            // `replace` goes through 8 bits, which is all that the texture has.
            whole.save(folder.path().join(format!("{side}-{kind}.png"))).unwrap();
        }
    }
    succeeds(folder.path(), &on("left.png", "right.png", &["-o", "expected.npy"]));
    let expected = fs::read(folder.path().join("expected.npy")).unwrap();
    for (left, _) in kinds {
        for (right, _) in kinds {
            let names = [format!("l-{left}.png"), format!("r-{right}.png")];
            succeeds(folder.path(), &on(&names[0], &names[1], &["-o", "got.npy"]));
            assert!(fs::read(folder.path().join("got.npy")).unwrap() == expected, "{left} {right}");
        }
    }
}

#[test]
fn images_of_one_pixel_and_ranges_wider_than_the_image() {
    let folder = scene();
    for (width, height) in [(1, 1), (1, 9), (9, 1), (3, 2)] {
        let image = GrayImage::from_fn(width, height, |x, y| Luma([texture(x, y)]));
        image.save(folder.path().join("small.png")).unwrap();
        for method in ["sgm", "bm"] {
            let more = ["--method", method, "-o", "got.png", "-o", "got.npy"];
            succeeds(folder.path(), &on("small.png", "small.png", &more));
            assert_eq!(read_kitti(&folder.path().join("got.png")).len(), (width * height) as usize);
        }
    }
}

#[test]
fn paths_may_hold_spaces_and_any_letters() {
    let folder = scene();
    let inner = folder.path().join("Straße 立体");
    fs::create_dir(&inner).unwrap();
    fs::copy(folder.path().join("left.png"), inner.join("links ←.png")).unwrap();
    let output = succeeds(
        folder.path(),
        &on("Straße 立体/links ←.png", "right.png", &["-o", "Straße 立体/karte ü.png", "--json"]),
    );
    let told: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(told["outputs"], serde_json::json!(["Straße 立体/karte ü.png"]));
    assert!(inner.join("karte ü.png").exists());
}

#[cfg(target_os = "linux")]
#[test]
fn paths_need_not_be_unicode() {
    use std::os::unix::ffi::OsStrExt as _;
    let folder = scene();
    let name = OsStr::from_bytes(b"left-\xff.png");
    fs::copy(folder.path().join("left.png"), folder.path().join(name)).unwrap();
    let args = [name, OsStr::new("right.png"), OsStr::new("--disp"), OsStr::new("16")];
    let more = ["--backend", "cpu", "--json", "-o"].map(OsStr::new);
    let args = [&args[..], &more[..], &[OsStr::from_bytes(b"\xfe.png")]].concat();
    let output = succeeds(folder.path(), &args);
    assert!(serde_json::from_slice::<Value>(&output.stdout).is_ok());
    assert!(folder.path().join(OsStr::from_bytes(b"\xfe.png")).exists());
}

// What it refuses.

#[test]
fn bad_images() {
    let folder = scene();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("folder")).unwrap();
    fs::write(at("empty.png"), "").unwrap();
    fs::write(at("text.png"), "This is not an image.\n").unwrap();
    fs::write(at("text.tga"), "This is not an image.\n").unwrap();
    fs::write(at("signature.png"), b"\x89PNG\r\n\x1a\n").unwrap();
    GrayImage::new(47, 30).save(at("narrow.png")).unwrap();
    ImageBuffer::from_pixel(48, 30, Rgb([0.5_f32; 3])).save(at("float.tif")).unwrap();
    fs::write(at("no-pixels.pgm"), "P5 0 0 255\n").unwrap();
    let rows: [(&str, &[&str]); 9] = [
        ("missing.png", &["missing.png", "does not exist"]),
        ("folder", &["folder", "is a folder"]),
        ("empty.png", &["empty.png", "is empty"]),
        ("text.png", &["text.png", "not an image", "PNG, JPEG"]),
        ("text.tga", &["text.tga"]),
        ("signature.png", &["signature.png", "cut short"]),
        ("narrow.png", &["47x30", "48x30", "one size"]),
        ("float.tif", &["float.tif", "floating-point", "16-bit"]),
        ("no-pixels.pgm", &["no-pixels.pgm"]),
    ];
    for (name, words) in rows {
        refuses(folder.path(), &on(name, "right.png", &["-o", "out.png"]), words);
        refuses(folder.path(), &on("left.png", name, &["-o", "out.png"]), words);
        refuses(folder.path(), &on("left.png", name, &["--json"]), words);
    }
    refuses(folder.path(), &on("left.png/x.png", "right.png", &[]), &["left.png/x.png"]);
    refuses(folder.path(), &on("two\nlines.png", "right.png", &[]), &[r"two\nlines.png", "does not exist"]);
    refuses(folder.path(), &on(&"long".repeat(2000), "right.png", &[]), &["cannot be read"]);
}

#[cfg(unix)]
#[test]
fn an_image_that_is_no_regular_file_is_refused_at_once() {
    let folder = scene();
    assert!(Command::new("mkfifo").arg(folder.path().join("pipe.png")).status().unwrap().success());
    refuses(folder.path(), &on("pipe.png", "right.png", &[]), &["pipe.png", "not a regular file"]);
    refuses(folder.path(), &on("left.png", "pipe.png", &[]), &["pipe.png", "not a regular file"]);
    refuses(folder.path(), &on("/dev/zero", "right.png", &[]), &["/dev/zero", "not a regular file"]);
    refuses(folder.path(), &on("left.png", "right.png", &["-o", "pipe.png"]), &["pipe.png", "not a regular file"]);
}

#[test]
fn truncated_images() {
    let folder = scene();
    let [left, _] = pair(48, 30);
    let color = DynamicImage::from(left.clone()).to_rgb8();
    for ending in ["png", "jpg", "pgm", "tif", "bmp", "webp", "tga", "gif", "qoi"] {
        let path = folder.path().join(format!("cut.{ending}"));
        if matches!(ending, "png" | "pgm" | "tif" | "bmp" | "jpg" | "tga") {
            left.save(&path).unwrap();
        } else {
            color.save(&path).unwrap();
        }
        let whole = fs::read(&path).unwrap();
        let name = format!("cut.{ending}");
        succeeds(folder.path(), &on(&name, "right.png", &["-o", "whole.npy"]));
        fs::remove_file(folder.path().join("whole.npy")).unwrap();
        for share in [1, 10, 50, 90, 98] {
            fs::write(&path, &whole[..whole.len() * share / 100]).unwrap();
            refuses(folder.path(), &on(&name, "right.png", &["-o", "out.png"]), &[&name]);
        }
        if matches!(ending, "png" | "jpg") {
            for missing in 1..=12 {
                fs::write(&path, &whole[..whole.len() - missing]).unwrap();
                refuses(folder.path(), &on(&name, "right.png", &[]), &[&name]);
            }
            fs::write(&path, [&whole[..], b"trailing bytes are common \xff\xda"].concat()).unwrap();
            succeeds(folder.path(), &on(&name, "right.png", &["-o", "out.npy"]));
        }
    }
}

#[test]
fn damaged_images() {
    let folder = scene();
    let whole = fs::read(folder.path().join("left.png")).unwrap();
    for position in (8..whole.len()).step_by(37) {
        let mut damaged = whole.clone();
        damaged[position] ^= 0x5a;
        fs::write(folder.path().join("damaged.png"), damaged).unwrap();
        // A flipped bit in a chunk that does not matter may pass. Nothing may crash.
        let output = run(folder.path(), &on("damaged.png", "right.png", &["-o", "out.npy"]));
        if output.status.code() != Some(0) {
            is_one_line_error(&output, &["damaged.png"]);
        }
    }
}

#[test]
fn images_that_declare_an_absurd_size() {
    let folder = scene();
    // A PNG header of 60000 x 60000 with a right checksum, no data.
    let mut header = b"IHDR\x00\x00\xea\x60\x00\x00\xea\x60\x08\x06\x00\x00\x00".to_vec();
    let crc = header.iter().fold(!0_u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg()))
    });
    header.extend((!crc).to_be_bytes());
    let end = b"\x00\x00\x00\x00IDAT\x35\xaf\x06\x1e\x00\x00\x00\x00IEND\xae\x42\x60\x82";
    let png = [b"\x89PNG\r\n\x1a\n\x00\x00\x00\x0d", &header[..], end].concat();
    fs::write(folder.path().join("bomb.png"), png).unwrap();
    refuses(folder.path(), &on("bomb.png", "right.png", &[]), &["bomb.png", "60000x60000"]);
    refuses(folder.path(), &on("bomb.png", "bomb.png", &[]), &["bomb.png"]);

    fs::write(folder.path().join("bomb.pgm"), "P5 4000000000 4000000000 255\nabc").unwrap();
    refuses(folder.path(), &on("bomb.pgm", "right.png", &[]), &["bomb.pgm"]);
    let mut bmp = Vec::new();
    pair(48, 30)[0].write_to(&mut std::io::Cursor::new(&mut bmp), ImageFormat::Bmp).unwrap();
    bmp[18..22].copy_from_slice(&60000_u32.to_le_bytes());
    bmp[22..26].copy_from_slice(&60000_u32.to_le_bytes());
    fs::write(folder.path().join("bomb.bmp"), bmp).unwrap();
    refuses(folder.path(), &on("bomb.bmp", "right.png", &[]), &["bomb.bmp"]);
    // A file that is too large itself, though it takes no space.
    let huge = fs::File::create(folder.path().join("huge.bin")).unwrap();
    huge.set_len(1 << 40).unwrap();
    let output = run(folder.path(), &on("huge.bin", "right.png", &[]));
    is_one_line_error(&output, &["huge.bin", "1099511627776 bytes"]);
}

#[test]
fn bad_parameters() {
    let folder = scene();
    let rows: &[(&[&str], &[&str])] = &[
        (&["--disp", "0"], &["--disp is 0,", "1 to 2048"]),
        (&["--disp", "-5"], &["--disp is -5,", "1 to 2048"]),
        (&["--disp=-5"], &["--disp is -5,"]),
        (&["--disp", "2049"], &["--disp is 2049,", "1 to 2048"]),
        (&["--disp", "99999999999999999999"], &["--disp is 99999999999999999999,", "1 to 2048"]),
        (&["--disp", "4294967297"], &["--disp is 4294967297,"]),
        (&["--disp", "nan"], &["nan", "--disp", "whole number"]),
        (&["--disp", "16.5"], &["16.5", "--disp", "whole number"]),
        (&["--disp", ""], &["--disp is empty,", "whole number"]),
        (&["--disp", "1\n6"], &[r"--disp is 1\n6,", "whole number"]),
        (&["--disp", "16", "--disp", "17"], &["--disp"]),
        (&["--disp", "64", "--min-disp", "2000"], &["--disp is 64,", "1 to 48"]),
        (&["--disp", "16", "--min-disp", "-2048"], &["--min-disp is -2048,", "-2047 to 2047"]),
        (&["--disp", "16", "--min-disp", "-99999999999999999999"], &["--min-disp is -99999999999999999999,"]),
        (&["--disp", "16", "--min-disp", "inf"], &["inf", "--min-disp", "whole number"]),
        (&["--disp", "16", "--block", "4"], &["--block is 4,", "odd", "1 to 51"]),
        (&["--disp", "16", "--block", "0"], &["--block is 0,"]),
        (&["--disp", "16", "--block", "-3"], &["--block is -3,"]),
        (&["--disp", "16", "--block", "53"], &["--block is 53,"]),
        (&["--disp", "16", "--p1", "50", "--p2", "10"], &["--p1 is 50,", "p2, which is 10"]),
        (&["--disp", "16", "--p2", "5"], &["5", "p1"]),
        (&["--disp", "16", "--p2", "128"], &["--p2 is 128,"]),
        (&["--disp", "16", "--p1", "-1"], &["--p1 is -1,"]),
        (&["--disp", "16", "--prefilter-cap", "0"], &["--prefilter-cap is 0,", "1 to 39"]),
        (&["--disp", "16", "--prefilter", "gauss"], &["--prefilter is gauss,", "xsobel, sobel, normalized, none"]),
        (&["--disp", "16", "--prefilter-window", "2"], &["--prefilter-window is 2,", "odd", "3 to 51"]),
        (&["--disp", "16", "--prefilter-window", "1"], &["--prefilter-window is 1,"]),
        (
            &["--disp", "16", "--preset", "best"],
            &["--preset is best,", "classic, fast, balanced, strict, dense, accurate"],
        ),
        (&["--disp", "16", "--preset", "fast", "--preset", "fast"], &["--preset"]),
        (
            &["--disp", "16", "--cost", "l2"],
            &["--cost is l2,", "sad, ssd, zsad, bt, bt-gray, sad-xy, census, census-sobel"],
        ),
        (&["--disp", "16", "--cost", "SAD"], &["--cost is SAD,"]),
        (&["--disp", "16", "--cost", "ncc"], &["--cost is ncc,", "method sgm", "take method bm"]),
        (
            &["--disp", "16", "--cost", "ncc", "--method", "bm", "--block", "21"],
            &["--block is 21,", "odd and from 3 to 19 with cost ncc"],
        ),
        (&["--disp", "16", "--color-cost", "on", "--cost", "census"], &["--color-cost is on,", "off with cost census"]),
        (&["--disp", "16", "--color-cost", "yes"], &["--color-cost is yes,", "on, off"]),
        (&["--disp", "16", "--census", "3x3"], &["--census is 3x3,", "5x5, 7x7, 9x7, cs9x7"]),
        (&["--disp", "16", "--ad-weight", "65"], &["--ad-weight is 65,", "0 to 64"]),
        (&["--disp", "16", "--learned-weight", "65"], &["--learned-weight is 65,", "0 to 64"]),
        (&["--disp", "16", "--p2-step", "256"], &["--p2-step is 256,", "from 1 to 255"]),
        (&["--disp", "16", "--ad-weight", "0", "--census-weight", "0"], &["--ad-weight is 0,", "census-weight is 0"]),
        (&["--disp", "16", "--cost", "sad-xy", "--prefilter-cap", "64"], &["--prefilter-cap is 64,", "1 to 63"]),
        (&["--disp", "16", "--census-weight", "-1"], &["--census-weight is -1,", "0 to 64"]),
        (&["--disp", "16", "--adaptive-p1", "1"], &["--adaptive-p1 is 1,", "on, off"]),
        (&["--disp", "16", "--adaptive-p2", "1"], &["--adaptive-p2 is 1,", "on, off"]),
        (&["--disp", "16", "--texture", "-4"], &["--texture is -4,", "0 (off)"]),
        (&["--disp", "16", "--texture", "some"], &["--texture is some,", "a whole number or off"]),
        (&["--disp", "16", "--subpixel", "maybe"], &["--subpixel is maybe,", "parabola, equiangular, off"]),
        (&["--disp", "16", "--right-view", "left"], &["--right-view is left,", "diagonal, match"]),
        (&["--disp", "16", "--speckle-window", "-1"], &["--speckle-window is -1,", "0 (off)"]),
        (&["--disp", "16", "--speckle-window", "on"], &["--speckle-window is on,", "a whole number or off"]),
        (&["--disp", "16", "--speckle-range", "off"], &["--speckle-range is off,", "a whole number"]),
        (&["--disp", "16", "--speckle-range", "5000"], &["--speckle-range is 5000,", "0 to 4095"]),
        (
            &["--disp", "16", "--fill", "all"],
            &["--fill is all,", "none, background, rays, weighted-rays, hirschmuller"],
        ),
        (&["--disp", "16", "--weighted-median", "16"], &["--weighted-median is 16,", "1 to 15"]),
        (&["--disp", "16", "--weighted-median", "0"], &["--weighted-median is 0,", "off"]),
        (&["--disp", "16", "--weighted-median-sigma", "256"], &["--weighted-median-sigma is 256,", "1 to 255"]),
        (&["--disp", "16", "--wls", "8000"], &["--wls is 8000,", "on, off"]),
        (&["--disp", "16", "--wls-lambda", "2e6"], &["--wls-lambda is 2e6,", "from 0 to 1000000"]),
        (&["--disp", "16", "--wls-lambda", "-1e3"], &["--wls-lambda is -1e3,"]),
        (&["--disp", "16", "--wls-sigma", "nan"], &["--wls-sigma is nan,"]),
        (&["--disp", "16", "--wls-sigma", "1,5"], &["--wls-sigma is 1,5,", "a number or off"]),
        (&["--disp", "16", "--shader-checks", "maybe"], &["--shader-checks is maybe,", "on, off"]),
        (&["--disp", "16", "--memory-check", "maybe"], &["--memory-check is maybe,", "on, off"]),
        (&["--disp", "16", "--opencv-rules", "maybe"], &["--opencv-rules is maybe,", "on, off"]),
        (&["--disp", "16", "--schedule", "late"], &["--schedule is late,", "auto, per-thread, per-subgroup"]),
        (&["--disp", "16", "--uniqueness", "100"], &["--uniqueness is 100,", "99"]),
        (&["--disp", "16", "--lr-check", "-1"], &["--lr-check is -1,", "off"]),
        (&["--disp", "16", "--lr-check", "on"], &["on", "--lr-check", "off"]),
        (&["--disp", "16", "--lr-check", "99999999999999999999"], &["--lr-check is 99999999999999999999,", "4095 px"]),
        (&["--disp", "16", "--paths", "6"], &["--paths is 6,", "3, 4, 5, 8, 16"]),
        (&["--disp", "16", "--median", "4"], &["--median is 4,", "3, 5, off"]),
        (&["--disp", "16", "--method", "magic"], &["--method is magic,", "sgm, bm, bp, psmnet"]),
        (&["--disp", "16", "--smoothness", "cubic"], &["--smoothness is cubic,", "linear, quadratic, potts"]),
        (&["--disp", "16", "--smoothness-weight", "128"], &["--smoothness-weight is 128,", "0 to 127"]),
        (&["--disp", "16", "--smoothness-truncation", "-1"], &["--smoothness-truncation is -1,", "0 to 127"]),
        (&["--disp", "16", "--smoothness-edge", "0"], &["--smoothness-edge is 0,", "off or from 1 to 255"]),
        (&["--disp", "16", "--bp-levels", "11"], &["--bp-levels is 11,", "1 to 10"]),
        (&["--disp", "16", "--bp-iterations", "0"], &["--bp-iterations is 0,", "1 to 1000"]),
        (&["--disp", "16", "--passes", "3"], &["--passes is 3,", "1 or 2"]),
        (&["--disp", "16", "--bp-reweighting", "17"], &["--bp-reweighting is 17,", "4 to 16"]),
        (&["--disp", "16", "--align-corners", "1"], &["--align-corners is 1,", "on, off"]),
        (&["--disp", "40", "--method", "psmnet"], &["--disp is 40,", "a multiple of 16 up to 512 with method psmnet"]),
        (&["--disp", "528", "--method", "psmnet"], &["--disp is 528,", "up to 512"]),
        (&["--disp", "16", "--method", "psmnet", "--min-disp", "8"], &["--min-disp is 8,", "0 with method psmnet"]),
        (
            &["--disp", "16", "--method", "psmnet", "--lr-check", "1", "--right-view", "diagonal"],
            &["--right-view is diagonal,", "match with method psmnet"],
        ),
        (&["--disp", "16", "--repeat", "0"], &["--repeat is 0,", "from 1"]),
        (&["--disp", "16", "--frobnicate"], &["--frobnicate", "--help"]),
    ];
    for (args, words) in rows {
        let args = [&["left.png", "right.png", "--backend", "cpu"], *args].concat();
        refuses(folder.path(), &args, words);
    }
    for option in Params::OPTIONS {
        let name = format!("--{}", option.name);
        let tried = |(args, _): &(&[&str], &[&str])| args.iter().skip(2).any(|arg| **arg == name);
        assert!(option.name == "disp" || rows.iter().any(tried), "--{} is refused nothing", option.name);
    }
    // Parameters are judged before the images are looked at.
    refuses(folder.path(), &["no.png", "none.png", "--disp", "0"], &["--disp is 0"]);
    refuses(folder.path(), &["left.png", "right.png"], &["--disp <N>", "--help"]);
    refuses(folder.path(), &["left.png", "--disp", "16", "--backend", "cpu"], &["given alone", "--split sbs"]);
    refuses::<&str>(folder.path(), &[], &["<LEFT>", "--help"]);
    refuses(folder.path(), &["left.png", "right.png", "third.png", "--disp", "16"], &["third.png", "--help"]);
}

#[test]
fn bad_outputs() {
    let folder = scene();
    fs::create_dir(folder.path().join("folder.png")).unwrap();
    let long = format!("{}.png", "n".repeat(300));
    let rows: &[(&[&str], &[&str])] = &[
        (&["-o", "nowhere/out.png"], &["nowhere", "does not exist"]),
        (&["--color", "nowhere/out.png"], &["nowhere", "does not exist"]),
        (&["-o", "left.png/out.png"], &["left.png", "out.png"]),
        (&["-o", "folder.png"], &["folder.png", "is a folder"]),
        (&["-o", "out.xyz"], &["out.xyz", ".xyz", ".png, .pfm, .npy, .tif"]),
        (&["-o", "out"], &["out", "no ending", ".png, .pfm, .npy, .tif"]),
        (&["-o", "."], &["no ending"]),
        (&["-o", ""], &["--output"]),
        (&["--color", "out.jpg"], &["--color", "out.jpg", ".png"]),
        (&["-o", "out.png", "-o", "./out.png"], &["out.png", "twice"]),
        (&["-o", "out.png", "--color", "out.png"], &["out.png", "twice"]),
        (&["--mask", "out.pfm"], &["--mask", "out.pfm", ".png"]),
        (&["--mask", "nowhere/out.png"], &["nowhere", "does not exist"]),
        (&["--mask", "out.png", "-o", "out.png"], &["out.png", "twice"]),
        (&["--color", "out.png", "--mask", "./out.png"], &["out.png", "twice"]),
        (&["--mask", "left.png"], &["left.png", "input"]),
        (&["--confidence", "out.npy"], &["--confidence", "out.npy", ".png"]),
        (&["--confidence", "out.png", "--mask", "out.png"], &["out.png", "twice"]),
        (&["--confidence", "right.png"], &["right.png", "input"]),
        (&["-o", "left.png"], &["left.png", "input"]),
        (&["-o", &long], &["cannot be written"]),
    ];
    for (more, words) in rows {
        refuses(folder.path(), &on("left.png", "right.png", more), words);
    }
    // The default names, too.
    fs::rename(folder.path().join("left.png"), folder.path().join("disparity.png")).unwrap();
    refuses(folder.path(), &on("disparity.png", "right.png", &[]), &["disparity.png", "input"]);
    // Outputs are judged before the images are looked at.
    refuses(folder.path(), &on("no.png", "none.png", &["-o", "out.xyz"]), &[".xyz"]);
}

#[cfg(unix)]
#[test]
fn read_only_places() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = scene();
    let closed = folder.path().join("closed");
    fs::create_dir(&closed).unwrap();
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o555)).unwrap();
    refuses(folder.path(), &on("left.png", "right.png", &["-o", "closed/out.png"]), &["closed/out.png", "read-only"]);
    fs::write(folder.path().join("kept.png"), "precious").unwrap();
    fs::set_permissions(folder.path().join("kept.png"), fs::Permissions::from_mode(0o444)).unwrap();
    refuses(folder.path(), &on("left.png", "right.png", &["-o", "kept.png"]), &["kept.png", "read-only"]);
    if cfg!(target_os = "linux") {
        refuses(folder.path(), &on("left.png", "right.png", &["-o", "/proc/out.png"]), &["/proc/out.png"]);
    }
}

#[test]
fn a_failing_run_keeps_the_old_output() {
    let folder = scene();
    succeeds(folder.path(), &on("left.png", "right.png", &["-o", "good.png", "--color", "good_color.png"]));
    let outputs = ["-o", "good.png", "--color", "good_color.png"];
    refuses(folder.path(), &on("left.png", "missing.png", &outputs), &["missing.png"]);
    refuses(
        folder.path(),
        &on("right.png", "left.png", &[&outputs[..], &["--min-disp", "-12"]].concat()),
        &["good.png"],
    );
}

#[test]
fn options_that_contradict_each_other() {
    let folder = scene();
    let reference = ["left.png", "right.png", "--disp", "16", "--backend", "reference"];
    refuses(folder.path(), &[&reference[..], &["--check"]].concat(), &["--check", "--backend is reference"]);
    refuses(folder.path(), &[&reference[..], &["--adapter", "0"]].concat(), &["--adapter", "--backend reference"]);
    refuses(folder.path(), &on("left.png", "right.png", &["--adapter", "0"]), &["--adapter", "--backend cpu"]);
    let shaders = ["--dump-shaders", "shaders"];
    refuses(folder.path(), &on("left.png", "right.png", &shaders), &["--dump-shaders", "--backend is cpu"]);
    assert!(!folder.path().join("shaders").exists());
}

// Studies.

/// `sweep` or `compare` on the scene, without an adapter.
fn study<'a>(name: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&[name, "left.png", "right.png", "--backend", "cpu"], more].concat()
}

fn picture(path: &Path) -> image::RgbImage {
    image::open(path).unwrap().into_rgb8()
}

/// Whether some part of the sheet is this picture, drawn this wide.
fn shows(sheet: &image::RgbImage, part: &image::RgbImage, width: u32) -> bool {
    let height = (part.height() * width).div_ceil(part.width());
    let part = image::imageops::resize(part, width, height, image::imageops::FilterType::Nearest);
    let corners = (0..sheet.height() - height).flat_map(|y| (0..sheet.width() - width).map(move |x| (x, y)));
    let equal =
        |(left, top): (u32, u32)| part.enumerate_pixels().all(|(x, y, p)| sheet.get_pixel(left + x, top + y) == p);
    corners.into_iter().any(equal)
}

#[test]
fn a_sweep_is_one_sheet_of_the_maps_that_single_runs_give() {
    let folder = scene();
    let at = |name: &str| picture(&folder.path().join(name));
    let axes = ["--block", "3,7", "--disp", "8,12,16", "--method", "bm", "--tile-width", "96"];
    let output = succeeds(folder.path(), &study("sweep", &[&axes[..], &["-o", "sheet.png"]].concat()));
    let sheet = at("sheet.png");
    // Three columns of 144 px (room for the labels) below the left image.
    assert_eq!(sheet.width(), 3 * (144 + 8) + 8);
    assert!((3 * 60..600).contains(&sheet.height()), "{}", sheet.height());
    let left = image::open(folder.path().join("left.png")).unwrap().into_rgb8();
    assert!(shows(&sheet, &left, 96));
    for block in ["3", "7"] {
        // The colours span all ranges, so only the widest one is a single run's picture.
        let single = ["--disp", "16", "--block", block, "--method", "bm", "--backend", "cpu", "--color", "one.png"];
        succeeds(folder.path(), &[&["left.png", "right.png"], &single[..]].concat());
        assert!(shows(&sheet, &at("one.png"), 96), "block {block}");
        for disp in ["8", "12", "16"] {
            let label = format!("block {block}, disp {disp}");
            assert!(stdout(&output).contains(&format!("| {label}")), "{}", stdout(&output));
            assert!(stderr(&output).contains(&format!("/6  {label}: ")), "{}", stderr(&output));
        }
    }
    assert!(stdout(&output).starts_with("| settings "), "{}", stdout(&output));
    assert_eq!((stdout(&output).lines().count(), stderr(&output).lines().count()), (2 + 6, 6));
    // Below each tile something is written: the block's first row of tiles begins at the same height.
    let dark = |x: u32, width: u32| {
        let rows = sheet.height() - 30..sheet.height();
        rows.flat_map(|y| (x..x + width).map(move |x| (x, y)))
            .filter(|&(x, y)| sheet.get_pixel(x, y).0 == [0; 3])
            .count()
    };
    (0..3).for_each(|column| assert!(dark(8 + column * 152, 144) > 30, "the last row has labels"));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 4, "temporary files are gone");
}

#[test]
fn a_comparison_of_variants_and_its_json() {
    let folder = scene();
    let variants = ["--variants", "sad,bm", "preset=classic+median=off+paths=8", "sad+disp=12", "--disp", "16"];
    let output = succeeds(folder.path(), &study("compare", &[&variants[..], &["--json", "--repeat", "2"]].concat()));
    let told: Value = serde_json::from_slice(&output.stdout).unwrap();
    let fields: Vec<_> = told.as_object().unwrap().keys().map(String::as_str).collect();
    assert_eq!(fields, ["adapter", "backend", "driver", "width", "height", "variants", "warnings", "outputs"]);
    assert_eq!((&told["backend"], &told["outputs"]), (&"cpu".into(), &serde_json::json!(["compare.png"])));
    let variants = told["variants"].as_array().unwrap();
    let labels: Vec<_> = variants.iter().map(|variant| variant["label"].as_str().unwrap()).collect();
    assert_eq!(labels, ["cost sad", "method bm", "preset classic, median off, paths 8", "cost sad, disp 12"]);
    let settings = serde_json::json!({"disp": "16", "preset": "classic", "median": "off", "paths": "8"});
    assert_eq!(variants[2]["settings"], settings);
    assert_eq!((&variants[2]["disparities"], &variants[3]["disparities"]), (&16.into(), &12.into()));
    for variant in variants {
        assert!(variant["frame_ms"]["min"].as_f64().unwrap() > 0.0);
        let valid = variant["valid"].as_f64().unwrap();
        assert!((0.5..=1.0).contains(&valid), "{valid}");
    }
    // The same as single runs say.
    let single = succeeds(folder.path(), &on("left.png", "right.png", &["--json", "--method", "bm"]));
    let single: Value = serde_json::from_slice(&single.stdout).unwrap();
    assert_eq!(variants[1]["valid"], single["valid"]);
    assert!(single["energy"]["sum"].as_u64() > Some(0) && variants[1]["energy"] == single["energy"]);
    // Four maps and the left image, 240 px wide, since the images are small; a JPEG of the same size.
    let sheet = picture(&folder.path().join("compare.png"));
    assert_eq!(sheet.width(), 3 * (240 + 8) + 8);
    let args = study("compare", &["--disp", "16", "--variants", "sad", "bm", "sad", "bm", "-q", "-o", "c.jpg"]);
    let output = succeeds(folder.path(), &args);
    assert_eq!((stdout(&output), stderr(&output)), (String::new(), String::new()));
    assert_eq!(picture(&folder.path().join("c.jpg")).width(), sheet.width());
}

#[test]
fn studies_that_cannot_be() {
    let folder = scene();
    let many = (1..=40).map(|n| n.to_string()).collect::<Vec<_>>().join(",");
    let sweeps: [(&[&str], &[&str]); 13] = [
        (&["--block", "3,5"], &["--disp <N>", "--help"]),
        (&["--disp", "8,0"], &["--disp is 0,", "from 1"]),
        (&["--disp", "8,,16"], &["--disp is empty,", "a whole number"]),
        (&["--disp", "8,x"], &["--disp is x,", "a whole number"]),
        (&["--disp", "8", "--block", "3,4,5"], &["--block is 4,", "odd"]),
        (&["--disp", "8", "--method", "bm,magic"], &["--method is magic,", "sgm, bm"]),
        (&["--disp", &many, "--p2", &many], &["1600 combinations", "1000", "fewer"]),
        (&["--disp", "8", "--tile-width", "15"], &["--tile-width is 15,", "16 to 4096"]),
        (&["--disp", "8,9,10,11", "--tile-width", "4096"], &["4 maps", "10000 a side", "--tile-width", "4096"]),
        (&["--disp", "8", "--repeat", "0"], &["--repeat is 0,", "from 1"]),
        (&["--disp", "8", "--adapter", "0"], &["--adapter", "--backend cpu"]),
        (&["--disp", "8", "-o", "sheet.npy"], &["sheet.npy", ".png or .jpg"]),
        (&["--disp", "8", "-o", "left.png"], &["left.png", "input"]),
    ];
    for (more, words) in sweeps {
        refuses(folder.path(), &study("sweep", more), words);
    }
    let comparisons: [(&[&str], &[&str]); 9] = [
        (&["--disp", "8"], &["--variants", "--help"]),
        (&["--variants", "sad"], &["--disp <N>", "--help"]),
        (&["--disp", "8", "--variants", "sad,magic"], &["\"magic\"", "preset", "cost", "OPTION=VALUE"]),
        (&["--disp", "8", "--variants", "block"], &["\"block\"", "OPTION=VALUE"]),
        (&["--disp", "8", "--variants", "sad+"], &["\"sad+\"", "OPTION=VALUE"]),
        (&["--disp", "8", "--variants", "sad+block=4"], &["\"sad+block=4\"", "--block is 4,", "odd"]),
        (&["--disp", "8", "--variants", "frobnicate=4"], &["\"frobnicate=4\"", "\"frobnicate\"", "median"]),
        (&["--disp", "8", "--variants", "cost=best"], &["--cost is best,", "sad, ssd"]),
        (&["--disp", "8,9", "--variants", "sad"], &["--disp is 8,9,", "a whole number"]),
    ];
    for (more, words) in comparisons {
        refuses(folder.path(), &study("compare", more), words);
    }
    refuses(folder.path(), &["sweep", "left.png", "none.png", "--disp", "8"], &["none.png", "does not exist"]);
    refuses(folder.path(), &["sweep", "left.png", "--disp", "8"], &["given alone"]);
    refuses(folder.path(), &["--json", "sweep", "left.png", "right.png", "--disp", "8"], &["before them"]);
    // A range that no option alone gets wrong.
    refuses(folder.path(), &study("sweep", &["--disp", "8", "--p1", "9,20", "--p2", "10,30"]), &["--p1 is 20,", "10"]);
}

#[test]
fn images_may_have_the_names_of_studies() {
    let folder = scene();
    fs::copy(folder.path().join("left.png"), folder.path().join("sweep")).unwrap();
    fs::copy(folder.path().join("right.png"), folder.path().join("compare")).unwrap();
    succeeds(folder.path(), &on("./sweep", "compare", &[]));
    succeeds(folder.path(), &["sweep", "sweep", "compare", "--disp", "16", "--backend", "cpu"]);
    assert!(folder.path().join("sweep.png").exists());
}

#[test]
fn options_that_change_nothing_in_a_study_are_told_once() {
    let folder = scene();
    let notes = |args: &[&str]| stderr(&succeeds(folder.path(), &study("sweep", &[args, &["-q"]].concat())));
    assert_eq!(
        notes(&["--disp", "8,9", "--method", "bm", "--paths", "3,8"]),
        "note: --paths has no effect with --method bm\n"
    );
    assert_eq!(notes(&["--disp", "8", "--method", "bm,sgm", "--paths", "3"]), "");
}

// What it says.

#[test]
fn json_has_exactly_the_promised_fields() {
    let folder = scene();
    let output = succeeds(folder.path(), &on("left.png", "right.png", &["--json", "--min-disp", "-2", "-o", "d.npy"]));
    assert_eq!(stderr(&output), "");
    let told: Value = serde_json::from_slice(&output.stdout).unwrap();
    let fields: Vec<_> = told.as_object().unwrap().keys().map(String::as_str).collect();
    assert_eq!(
        fields,
        [
            "adapter",
            "backend",
            "driver",
            "width",
            "height",
            "bits",
            "turned",
            "min_disparity",
            "disparities",
            "valid",
            "frame_ms",
            "first_frame_ms",
            "stages",
            "energy",
            "peak_device_bytes",
            "warnings",
            "outputs"
        ]
    );
    assert!(told["adapter"].is_string() && told["driver"].is_string());
    assert_eq!(told["backend"], "cpu");
    assert_eq!((&told["width"], &told["height"]), (&48.into(), &30.into()));
    assert_eq!((&told["min_disparity"], &told["disparities"]), (&(-2).into(), &16.into()));
    assert_eq!(told["peak_device_bytes"], 0);
    assert_eq!(told["warnings"], serde_json::json!([]));
    assert_eq!(told["outputs"], serde_json::json!(["d.npy"]));
    let map = read_npy(&folder.path().join("d.npy"), 48, 30);
    let valid = map.iter().filter(|v| !v.is_nan()).count() as f64 / map.len() as f64;
    assert!((told["valid"].as_f64().unwrap() - valid).abs() < 1e-9);
    let frame = told["frame_ms"].as_object().unwrap();
    assert_eq!(frame.keys().collect::<Vec<_>>(), ["median", "min"]);
    assert!(frame["min"].as_f64().unwrap() > 0.0 && frame["median"].as_f64() >= frame["min"].as_f64());
    assert!(told["first_frame_ms"].as_f64().unwrap() > 0.0);
    let stages = told["stages"].as_array().unwrap();
    assert!(!stages.is_empty());
    for stage in stages {
        assert!(stage["name"].is_string() && stage["ms"].as_f64().unwrap() >= 0.0);
    }
}

/// The energy of every method, in `--json` and beside `--timings` alone; the options of the smoothness count for it, and are
/// reported where it is not told.
#[test]
fn the_energy_is_told_of_every_method() {
    let folder = scene();
    let told = |more: &str| {
        let args: Vec<_> = more.split(' ').chain(["--json", "--block", "3"]).collect();
        let output = succeeds(folder.path(), &on("left.png", "right.png", &args));
        assert_eq!(stderr(&output), "", "{more}");
        let told: Value = serde_json::from_slice(&output.stdout).unwrap();
        let energy = told["energy"].as_object().unwrap();
        assert_eq!(energy.keys().collect::<Vec<_>>(), ["data", "smoothness", "sum"]);
        let [data, smoothness, sum] = ["data", "smoothness", "sum"].map(|part| energy[part].as_u64().unwrap());
        assert_eq!(data + smoothness, sum);
        (data, smoothness)
    };
    let flat = "--smoothness-truncation 0";
    for method in ["--preset classic --method sgm", "--preset classic --method bm", "--preset classic --method bp"] {
        let (data, smoothness) = told(method);
        assert!(data > 0 && smoothness > 0, "{method}: {data}, {smoothness}");
        let (same, none) = told(&format!("{method} {flat}"));
        assert!(none == 0 && (same == data || method.ends_with("bp")), "{method}: {same}, {none}");
        let doubled = told(&format!("{method} --smoothness potts --smoothness-truncation 1"));
        assert!(doubled.1 > 0 && doubled.1 < smoothness, "{method}: {doubled:?}");
    }
    let args = |more: &'static str| more.split(' ').collect::<Vec<_>>();
    let output = succeeds(folder.path(), &on("left.png", "right.png", &args("--timings -q --smoothness potts")));
    let (text, lines) = (stdout(&output), stdout(&output).lines().count());
    let last = text.lines().next_back().unwrap();
    assert!(lines > 5 && last.starts_with("energy   ") && last.contains(" (data ") && last.ends_with(')'), "{text}");
    assert_eq!(stderr(&output), "");
    let output = succeeds(folder.path(), &on("left.png", "right.png", &args("--smoothness potts")));
    assert!(!stdout(&output).contains("energy"), "{}", stdout(&output));
    assert_eq!(stderr(&output), "note: --smoothness has no effect with --method sgm\n");
}

#[test]
fn timings_are_a_table_and_quiet_silences_the_summary_alone() {
    let folder = scene();
    let more = ["--timings", "--repeat", "3"];
    let output = succeeds(folder.path(), &on("left.png", "right.png", &more));
    for told in ["adapter", "| stage", "ms", "share", "| transfers and host", "| total"] {
        assert!(stdout(&output).contains(told), "{told:?} is not in {}", stdout(&output));
    }
    let output = succeeds(folder.path(), &on("left.png", "right.png", &[&more[..], &["-q"]].concat()));
    assert!(stdout(&output).starts_with("| stage"), "{}", stdout(&output));
    let output = succeeds(folder.path(), &on("left.png", "right.png", &["-q"]));
    assert_eq!((stdout(&output), stderr(&output)), (String::new(), String::new()));
}

#[test]
fn options_that_change_nothing_are_told() {
    let folder = scene();
    for (more, other) in [
        ("--paths 8 --method bm", "method bm"),
        ("--p1 3 --method bm", "method bm"),
        ("--p2 100 --method bm", "method bm"),
        ("--adaptive-p1 on --method bm", "method bm"),
        ("--adaptive-p2 on --method bm", "method bm"),
        ("--passes 2 --method bm", "method bm"),
        ("--p2-step 6 --adaptive-p2 off", "adaptive-p2 off"),
        ("--prefilter-cap 15 --prefilter none", "prefilter none"),
        ("--prefilter-window 15", "prefilter xsobel"),
        ("--census 5x5", "cost sad"),
        ("--ad-weight 5", "cost sad"),
        ("--census-weight 5", "cost sad"),
        ("--learned-weight 5", "cost sad"),
        ("--speckle-range 1 --speckle-window off", "speckle-window off"),
        ("--weighted-median-sigma 9", "weighted-median off"),
        ("--wls-lambda 900 --wls off", "wls off"),
        ("--wls-sigma 1.1 --wls off", "wls off"),
    ] {
        let args: Vec<_> = more.split(' ').chain(["--preset", "classic"]).collect();
        let output = succeeds(folder.path(), &on("left.png", "right.png", &args));
        assert_eq!(stderr(&output), format!("note: {} has no effect with --{other}\n", args[0]));
    }
    let busy = "--prefilter-cap 9 --speckle-range 1 --paths 3 --block 3 --preset classic \
                --prefilter normalized --prefilter-window 7";
    let busy = succeeds(folder.path(), &on("left.png", "right.png", &busy.split(' ').collect::<Vec<_>>()));
    assert_eq!(stderr(&busy), "");
}

/// A folder with a pair that has enough noise that every option matters.
fn noisy() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (side, (image, seed)) in ["left", "right"].into_iter().zip(pair(48, 30).into_iter().zip([11, 77])) {
        let noisy = GrayImage::from_fn(48, 30, |x, y| {
            let noise = i32::from(texture(2 * x + seed, 2 * y)) / 3 - 42;
            Luma([(i32::from(image.get_pixel(x, y).0[0]) + noise).clamp(0, 255) as u8])
        });
        noisy.save(folder.path().join(format!("{side}.png"))).unwrap();
    }
    folder
}

/// The map of a pair with some options, as a file.
fn map(folder: &TempDir, options: &str) -> Vec<u8> {
    let options: Vec<_> = options.split_whitespace().chain(["-o", "m.npy"]).collect();
    succeeds(folder.path(), &on("left.png", "right.png", &options));
    fs::read(folder.path().join("m.npy")).unwrap()
}

#[test]
fn every_option_reaches_the_matcher() {
    let folder = noisy();
    // The speckle filter would remove all that the noise leaves.
    let map = |more: &str| map(&folder, &format!("--preset classic --speckle-window off {more}"));
    let plain = map("");
    for changed in [
        "--min-disp 1",
        "--method bm",
        "--paths 3",
        "--paths 8",
        "--block 7",
        "--prefilter sobel",
        "--prefilter none",
        "--prefilter normalized",
        "--prefilter-cap 3",
        "--cost ssd",
        "--cost zsad",
        "--cost bt",
        "--cost sad-xy",
        "--cost census",
        "--cost census-sobel",
        "--cost ad-census",
        "--p1 0",
        "--p2 127",
        "--uniqueness 40",
        "--lr-check 0",
        "--lr-check off",
        "--median off",
        "--subpixel off",
    ] {
        assert!(map(changed) != plain, "{changed}");
    }
    for same in
        ["--uniqueness 10", "--subpixel on", "--schedule per-thread", "--schedule per-subgroup", "--shader-checks on"]
    {
        assert!(map(same) == plain, "{same}");
    }
    assert!(map("--uniqueness off") == map("--uniqueness 0"));
    for [one, other] in [
        ["--prefilter normalized", "--prefilter normalized --prefilter-window 5"],
        ["--cost sad-xy", "--cost sad-xy --prefilter-cap 9"],
        ["--cost census", "--cost census --census 5x5"],
        ["--cost census --census 7x7", "--cost census --census cs9x7"],
        ["--cost ad-census", "--cost ad-census --ad-weight 50"],
        ["--cost ad-census", "--cost ad-census --census-weight 3"],
        ["--cost learned", "--cost learned-census"],
        ["--cost learned-census", "--cost learned-census --learned-weight 9"],
    ] {
        assert!(map(one) != map(other), "{other}");
    }
}

#[test]
fn the_help_and_the_readme_tell_the_defaults() {
    let folder = noisy();
    let help = stdout(&succeeds(folder.path(), &["-h"])).split_whitespace().collect::<Vec<_>>().join(" ");
    let default = |name: &str| -> String {
        let described = help.split_once(&format!(" --{name} <")).unwrap().1;
        described.split_once("[default: ").unwrap().1.split_once(']').unwrap().0.into()
    };
    let options = || Params::OPTIONS.iter().map(|option| option.name).filter(|name| *name != "disp");
    let readme = include_str!("../../../README.md").replace("\\|", "/");
    for name in options().chain(["preset", "backend"]) {
        let row = readme.lines().find(|line| line.starts_with(&format!("| `--{name} "))).expect(name);
        assert_eq!(row.split('|').nth(3).unwrap().trim(), default(name), "README.md, --{name}");
    }
    for (method, other) in [("sgm", "bm"), ("bm", "sgm")] {
        let mut spelled_out = String::new();
        for name in options().filter(|name| *name != "method") {
            let of_methods = default(name);
            let own = of_methods.split(", ").find(|of| !of.starts_with(other)).unwrap();
            spelled_out += &format!(" --{name} {}", own.trim_start_matches(method).trim());
        }
        let method = format!("--method {method}");
        assert!(map(&folder, &format!("{method} {spelled_out}")) == map(&folder, &method), "{method} {spelled_out}");
    }
}

#[test]
fn single_options_override_a_preset_in_any_order() {
    let folder = noisy();
    let map = |more: &str| map(&folder, more);
    let balanced = map("--preset balanced");
    assert!(map("") == map(&format!("--preset {}", Preset::default())));
    assert!(map("--preset fast") != balanced);
    assert!(map("--preset fast --paths 4") == map("--paths 4 --preset fast"));
    assert!(map("--preset fast --paths 4") != map("--preset fast"));
    assert!(map("--preset strict --right-view diagonal --speckle-window 100") == balanced);
    assert!(map("--preset fast --method bm") == map("--method bm --preset fast --paths 8"), "bm has no paths");
    for (preset, _) in Preset::NAMES {
        let told = succeeds(folder.path(), &on("left.png", "right.png", &["--preset", preset, "-o", "m.npy"]));
        assert_eq!(stderr(&told), "", "a preset says nothing of its own options");
    }
}

#[test]
fn help_and_version() {
    let folder = scene();
    let help = succeeds(folder.path(), &["--help"]);
    let settings = Params::OPTIONS.iter().map(|option| format!("--{} <{}>", option.name, option.placeholder));
    let words = Params::OPTIONS.iter().filter(|option| !option.placeholder.contains('|')).flat_map(|o| o.values);
    let described = words.map(|(word, _)| format!("- {word}:"));
    for told in settings.chain(described) {
        assert!(stdout(&help).contains(&told), "{told}");
    }
    let headings =
        ["Arguments", "Options", "Input", "Matching cost", "Aggregation", "After the winner", "Device", "Output"];
    let mut rest = stdout(&help);
    for heading in headings {
        rest = rest.split_once(&format!("\n{heading}:\n")).unwrap_or_else(|| panic!("{heading}")).1.to_owned();
    }
    for option in [
        "--preset",
        "--backend",
        "--adapter",
        "--list-adapters",
        "-o",
        "--color",
        "--mask",
        "--confidence",
        "--check",
        "--timings",
        "--repeat",
        "--dump-shaders",
        "--json",
        "-q",
        "sweep",
        "compare",
        "video",
        "Examples:",
        "Exit codes:",
    ] {
        assert!(stdout(&help).contains(option), "{option}");
    }
    assert!(stdout(&help).lines().all(|line| line.chars().count() <= 120));
    let version = succeeds(folder.path(), &["--version"]);
    assert_eq!(stdout(&version), concat!("gpu-stereo ", env!("CARGO_PKG_VERSION"), "\n"));
}

/// The kernels of the run and no others, each valid alone, in a folder that has nothing else.
#[test]
fn shaders_are_written_into_a_folder_of_their_own() {
    let folder = scene();
    if succeeds(folder.path(), &["--list-adapters", "--json"]).stdout.starts_with(b"[]") {
        assert!(std::env::var_os("GPU_STEREO_NO_ADAPTER").is_some(), "no adapter was found");
        not_tested("there is no adapter, and GPU_STEREO_NO_ADAPTER is set");
        return;
    }
    let pair =
        ["left.png", "right.png", "--disp", "16", "--preset", "classic", "--speckle-window", "0", "-o", "map.npy"];
    for (schedule, cost) in [("per-thread", "matching_cost_small"), ("per-subgroup", "matching_cost_parallel")] {
        succeeds(folder.path(), &[&pair[..], &["--schedule", schedule, "--dump-shaders", schedule]].concat());
        let mut names = Vec::new();
        for file in fs::read_dir(folder.path().join(schedule)).unwrap().map(|file| file.unwrap()) {
            let name = file.file_name().into_string().unwrap();
            let text = fs::read_to_string(file.path()).unwrap();
            let module = gpu_stereo::wgpu::naga::front::wgsl::parse_str(&text).unwrap();
            assert_eq!(module.entry_points.len(), 1, "{name}");
            names.push(name.strip_suffix(".wgsl").unwrap().to_owned());
        }
        names.sort();
        assert_eq!(names, ["gray", "lr_check", cost, "median", "prefilter", "sgm_aggregate", "winner"]);
    }
    let again = [&pair[..], &["--dump-shaders", "per-thread"]].concat();
    refuses(folder.path(), &again, &["--dump-shaders is \"per-thread\"", "not empty", "new or an empty folder"]);
    let again = [&pair[..], &["--dump-shaders", "left.png"]].concat();
    refuses(folder.path(), &again, &["--dump-shaders is \"left.png\"", "is a file"]);
}

#[test]
fn a_reader_that_leaves_is_no_error() {
    let folder = scene();
    for args in [on("left.png", "right.png", &["--json"]), on("left.png", "right.png", &[]), vec!["--help"]] {
        let mut child = command(folder.path());
        let mut child = child.args(args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!((output.status.code(), stderr(&output)), (Some(0), String::new()));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_stdout_is_an_error() {
    let folder = scene();
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = command(folder.path()).args(on("left.png", "right.png", &[])).stdout(full).output().unwrap();
    is_one_line_error(&output, &["stdout"]);
}

#[test]
fn the_gallery_shows_every_picture_and_they_are_small() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    let page = fs::read_to_string(docs.join("GALLERY.md")).unwrap();
    let links = page.split("](").skip(1).filter_map(|part| part.split_once(')'));
    let shown: Vec<_> = links.map(|(name, _)| name).filter(|name| name.starts_with("images/gallery/")).collect();
    assert!(shown.len() > 10);
    let pictures = contents(&docs.join("images/gallery"));
    assert_eq!(pictures.len(), shown.len());
    for name in shown {
        assert!(pictures.contains_key(&docs.join(name)), "{name}");
    }
    assert!(pictures.values().map(Vec::len).sum::<usize>() < 1_600_000);
}

// Adapters: these hold with and without one.

#[test]
fn adapters_are_listed_without_images() {
    let folder = scene();
    let output = succeeds(folder.path(), &["--list-adapters"]);
    let header: Vec<_> = stdout(&output).lines().next().unwrap().split('|').map(|s| s.trim().to_owned()).collect();
    assert_eq!(header, ["", "index", "name", "backend", "driver", "kind", ""]);
    let output = succeeds(folder.path(), &["--list-adapters", "--json"]);
    let listed: Value = serde_json::from_slice(&output.stdout).unwrap();
    for (index, adapter) in listed.as_array().unwrap().iter().enumerate() {
        assert_eq!(adapter["index"], index);
        assert!(adapter["name"].is_string() && adapter["backend"].is_string() && adapter["kind"].is_string());
    }
}

#[test]
fn an_unknown_adapter() {
    let folder = scene();
    for name in ["no such adapter", "4000000000", ""] {
        let args = ["left.png", "right.png", "--disp", "16", "--adapter", name];
        refuses(folder.path(), &args, &["--adapter is", name]);
    }
}

/// Vulkan is told of no driver, and nothing else gives adapters here.
#[cfg(target_os = "linux")]
#[test]
fn without_any_adapter_the_cpu_computes_and_says_so() {
    let folder = scene();
    let bare = |args: &[&str]| {
        let mut command = command(folder.path());
        command.env("VK_DRIVER_FILES", "/nonexistent").env("VK_ICD_FILENAMES", "/nonexistent");
        command.args(["left.png", "right.png", "--disp", "16"]).args(args).output().unwrap()
    };
    is_one_line_error(&bare(&["--backend", "gpu"]), &["--backend is gpu", "no usable adapter"]);
    is_one_line_error(&bare(&["--dump-shaders", "s"]), &["--dump-shaders", "no usable adapter"]);
    is_one_line_error(&bare(&["--adapter", "0"]), &["--adapter is \"0\"", "no adapter"]);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);

    let output = bare(&["-o", "auto.npy"]);
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(stderr(&output).lines().count(), 1);
    assert!(stderr(&output).contains("computing on the CPU"), "{}", stderr(&output));
    assert!(stdout(&output).contains("adapter  CPU with "), "{}", stdout(&output));
    for backend in ["cpu", "reference"] {
        let map = format!("{backend}.npy");
        succeeds(folder.path(), &["left.png", "right.png", "--disp", "16", "--backend", backend, "-o", &map]);
    }
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert!(read("auto.npy") == read("cpu.npy") && read("auto.npy") == read("reference.npy"));
    // The comparison with the reference needs no adapter.
    let output = bare(&["--check", "-q"]);
    assert_eq!(output.status.code(), Some(0));
    assert!(stdout(&output).contains("| matching_cost ") && stdout(&output).contains("| maps "), "{}", stdout(&output));
}
