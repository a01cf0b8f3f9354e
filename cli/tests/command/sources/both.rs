//! Both views in one file: a picture that shows both, MPO and JPS, in every verb that takes pairs.
//!
//! On the CPU, so that no adapter is needed.

use crate::support::{pair, refuses, scene, shared, stderr, succeeds};
use image::codecs::jpeg::JpegEncoder;
use image::{DynamicImage, GenericImage as _, GrayImage, Luma};
use serde_json::Value;
use std::fs;
use tempfile::TempDir;

/// A run of one file.
fn alone<'a>(file: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&[file, "--disp", "16", "--backend", "cpu", "-q"], more].concat()
}

fn map(folder: &TempDir, args: &[&str]) -> Vec<u8> {
    succeeds(folder.path(), &[args, &["-o", "map.npy"]].concat());
    fs::read(folder.path().join("map.npy")).unwrap()
}

/// Both views in one picture, and how.
fn pictures([left, right]: &[GrayImage; 2]) -> [(&'static str, GrayImage); 6] {
    let (width, height) = left.dimensions();
    let beside = |first: &GrayImage, second: &GrayImage| {
        let mut both = GrayImage::new(2 * width, height);
        both.copy_from(first, 0, 0).unwrap();
        both.copy_from(second, width, 0).unwrap();
        both
    };
    let below = |first: &GrayImage, second: &GrayImage| {
        let mut both = GrayImage::new(width, 2 * height);
        both.copy_from(first, 0, 0).unwrap();
        both.copy_from(second, 0, height).unwrap();
        both
    };
    let woven = |first: &GrayImage, second: &GrayImage| {
        let pixel = |x, y: u32| *if y.is_multiple_of(2) { first } else { second }.get_pixel(x, y / 2);
        GrayImage::from_fn(width, 2 * height, pixel)
    };
    [
        ("sbs", beside(left, right)),
        ("sbs-swapped", beside(right, left)),
        ("tb", below(left, right)),
        ("tb-swapped", below(right, left)),
        ("interlaced", woven(left, right)),
        ("interlaced-swapped", woven(right, left)),
    ]
}

/// A folder with a pair of files, and the map of these.
fn with_map() -> (TempDir, Vec<u8>) {
    let folder = scene();
    let expected = map(&folder, &["left.png", "right.png", "--disp", "16", "--backend", "cpu", "-q"]);
    (folder, expected)
}

#[test]
fn a_picture_of_both_views_gives_the_map_of_two_files() {
    let (folder, expected) = with_map();
    let pair = pair(48, 30);
    for (how, picture) in pictures(&pair) {
        picture.save(folder.path().join("both.png")).unwrap();
        assert!(map(&folder, &alone("both.png", &["--split", how])) == expected, "{how}");
        let other = if let Some(how) = how.strip_suffix("-swapped") { how.into() } else { format!("{how}-swapped") };
        assert!(map(&folder, &alone("both.png", &["--split", &other, "--swap"])) == expected, "{how}");
        // 16 bits and colours.
        let deep = image::ImageBuffer::from_fn(picture.width(), picture.height(), |x, y| {
            Luma([u16::from(picture.get_pixel(x, y).0[0]) * 257])
        });
        deep.save(folder.path().join("both.png")).unwrap();
        assert!(map(&folder, &alone("both.png", &["--split", how, "--bits", "16"])) == expected, "{how}");
        DynamicImage::from(picture).into_rgba8().save(folder.path().join("both.png")).unwrap();
        assert!(map(&folder, &alone("both.png", &["--split", how])) == expected, "{how}");
    }
}

#[test]
fn every_verb_takes_one_file_a_pair() {
    let (folder, expected) = with_map();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("both")).unwrap();
    let [(_, picture), ..] = pictures(&pair(48, 30));
    picture.save(at("both/a.png")).unwrap();
    picture.save(at("both/b.png")).unwrap();
    fs::write(at("bare.csv"), "both/a.png\nboth/b.png\n").unwrap();
    fs::write(at("named.csv"), "left,name\nboth/a.png,x/a\nboth/b.png,x/b\n").unwrap();
    fs::write(at("lines.jsonl"), "{\"left\": \"both/a.png\"}\n{\"left\": \"both/b.png\"}\n").unwrap();
    let computed = ["--split", "sbs", "--disp", "16", "--backend", "cpu", "-q", "--format", "npy"];
    let runs: [(&[&str], &str); 7] = [
        (&["video", "both", "-o", "1"], "1/a.npy"),
        (&["video", "both/*.png", "-o", "2_%d.npy"], "2_1.npy"),
        (&["batch", "both", "-o", "3"], "3/b.npy"),
        (&["batch", "both/?.png", "-o", "4"], "4/b.npy"),
        (&["batch", "bare.csv", "-o", "5"], "5/b.npy"),
        (&["batch", "named.csv", "-o", "6"], "6/x/b.npy"),
        (&["batch", "lines.jsonl", "-o", "7"], "7/a.npy"),
    ];
    for (args, file) in runs {
        succeeds(folder.path(), &[args, &computed].concat());
        assert!(fs::read(at(file)).unwrap() == expected, "{args:?}");
    }
    // What is there is kept only if it was split in the same way.
    let again =
        |how| ["batch", "both", "-o", "3", "--split", how, "--disp", "16", "--backend", "cpu", "--resume", "--json"];
    let told = |args: &[&str]| -> Value { serde_json::from_slice(&succeeds(folder.path(), args).stdout).unwrap() };
    assert_eq!(told(&[&again("sbs")[..], &["--format", "npy"]].concat())["skipped"], 2);
    refuses(folder.path(), &again("tb"), &["made with other settings: split"]);

    let computed = ["--split", "sbs", "--disp", "16", "--backend", "cpu", "--json"];
    let valid = |args: &[&str], list: &str| told(&[args, &computed].concat())[list][0]["valid"].clone();
    let single =
        told(&["left.png", "right.png", "-o", "m.npy", "--disp", "16", "--backend", "cpu", "--json"])["valid"].clone();
    assert_eq!(valid(&["sweep", "both/a.png"], "variants"), single);
    assert_eq!(valid(&["compare", "both/a.png", "--variants", "balanced"], "variants"), single);
    fs::write(at("scenes.json"), r#"[{"set": "s", "scene": "a", "left": "both/a.png"}]"#).unwrap();
    assert_eq!(valid(&["bench", "scenes.json", "--layout", "manifest"], "scenes"), single);
}

#[test]
fn a_file_alone_that_does_not_say_how_is_refused_with_the_remedy() {
    let folder = scene();
    let remedy = ["is given alone", "give LEFT and RIGHT", "--split sbs", "sbs-swapped", "tb", "interlaced"];
    refuses(folder.path(), &alone("left.png", &[]), &remedy);
    refuses(folder.path(), &["sweep", "left.png", "--disp", "16", "--backend", "cpu"], &remedy);
    refuses(folder.path(), &alone("left.png", &["--split", "auto"]), &remedy);
    refuses(folder.path(), &alone("none.png", &[]), &["does not exist"]);
    GrayImage::new(15, 9).save(folder.path().join("odd.png")).unwrap();
    refuses(folder.path(), &alone("odd.png", &["--split", "sbs"]), &["\"odd.png\" is 15x9", "even number of columns"]);
    refuses(folder.path(), &alone("odd.png", &["--split", "tb"]), &["even number of rows"]);
    let two = ["left.png", "right.png", "--split", "sbs", "--disp", "16"];
    refuses(folder.path(), &two, &["--split is for one file", "\"right.png\"", "drop it"]);
    refuses(folder.path(), &alone("left.png", &["--split", "half"]), &["half", "sbs", "tb", "interlaced"]);
    let bench = ["bench", ".", "--layout", "middlebury", "--split", "sbs"];
    fs::create_dir_all(folder.path().join("trainingQ/a")).unwrap();
    fs::copy(folder.path().join("left.png"), folder.path().join("trainingQ/a/im0.png")).unwrap();
    refuses(folder.path(), &bench, &["--split is for images that hold both views", "--layout manifest"]);
    refuses(folder.path(), &["batch", "trainingQ", "-o", "m", "--disp", "16"], &["--split"]);
}

// MPO and JPS.

fn jpeg(image: &GrayImage) -> Vec<u8> {
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, 95).encode_image(image).unwrap();
    bytes
}

/// A JPEG file with one more segment behind its first one.
fn with_segment(jpeg: &[u8], marker: u8, content: &[u8]) -> Vec<u8> {
    let first = 4 + usize::from(u16::from_be_bytes([jpeg[4], jpeg[5]])) - 2 + 2;
    let length = (content.len() as u16 + 2).to_be_bytes();
    [&jpeg[..first], &[0xff, marker], &length, content, &jpeg[first..]].concat()
}

/// An MPO file of two JPEG files of this kind.
fn mpo(files: [&[u8]; 2], kind: u32) -> Vec<u8> {
    let index = |size: [u32; 2], place: u32| {
        let mut index = b"MPF\0MM\0\x2a\0\0\0\x08\0\x01".to_vec();
        index.extend([0xb0, 2, 0, 7, 0, 0, 0, 32, 0, 0, 0, 26, 0, 0, 0, 0]);
        for (size, place) in size.into_iter().zip([0, place]) {
            index.extend([kind, size, place, 0].map(u32::to_be_bytes).concat());
        }
        index
    };
    let length = with_segment(files[0], 0xe2, &index([0; 2], 0)).len() as u32;
    let header = 2 + 18 + 4 + 4; // SOI, JFIF, marker and length, "MPF\0"
    let index = index([length, files[1].len() as u32], length - header);
    [with_segment(files[0], 0xe2, &index), files[1].to_vec()].concat()
}

#[test]
fn an_mpo_holds_both_views() {
    let folder = scene();
    let at = |name: &str| folder.path().join(name);
    let [left, right] = pair(48, 30).map(|image| jpeg(&image));
    fs::write(at("l.jpg"), &left).unwrap();
    fs::write(at("r.jpg"), &right).unwrap();
    let expected = map(&folder, &["l.jpg", "r.jpg", "--disp", "16", "--backend", "cpu", "-q"]);
    fs::create_dir(at("mpo")).unwrap();
    fs::write(at("mpo/a.mpo"), mpo([&left, &right], 0x02_0002)).unwrap();
    assert!(map(&folder, &alone("mpo/a.mpo", &[])) == expected);
    fs::write(at("exchanged.jpg"), mpo([&right, &left], 0x02_0002)).unwrap();
    assert!(map(&folder, &alone("exchanged.jpg", &["--swap"])) == expected);
    fs::write(at("list.csv"), "mpo/a.mpo\n").unwrap();
    for (args, file) in [(["batch", "list.csv", "-o", "m"], "m/a.npy"), (["video", "mpo/*.mpo", "-o", "v"], "v/a.npy")]
    {
        succeeds(folder.path(), &[&args[..], &["--disp", "16", "--backend", "cpu", "-q", "--format", "npy"]].concat());
        assert!(fs::read(at(file)).unwrap() == expected, "{args:?}");
    }
    // As one of two files it is its first image, and that is said.
    let output = succeeds(folder.path(), &["mpo/a.mpo", "r.jpg", "--disp", "16", "--backend", "cpu", "-o", "m.npy"]);
    assert!(stderr(&output).contains("give it alone to match its two views"), "{}", stderr(&output));
    assert!(fs::read(at("m.npy")).unwrap() == expected);

    // A preview is no view; neither is an image of another size, or none.
    fs::write(at("preview.mpo"), mpo([&left, &jpeg(&GrayImage::new(8, 8))], 0x03_0000)).unwrap();
    refuses(folder.path(), &alone("preview.mpo", &[]), &["two views of an MPO file", "8x8", "one size"]);
    fs::write(at("preview.mpo"), mpo([&left, &right], 0x01_0001)).unwrap();
    refuses(folder.path(), &alone("preview.mpo", &[]), &["\"preview.mpo\" is an MPO file", "no two views"]);
    let whole = mpo([&left, &right], 0x02_0002);
    fs::write(at("cut.mpo"), &whole[..whole.len() - right.len()]).unwrap();
    refuses(folder.path(), &alone("cut.mpo", &[]), &["cut.mpo", "no JPEG begins", "copy it again"]);
    fs::write(at("cut.mpo"), &whole[..whole.len() - right.len() / 2]).unwrap();
    refuses(folder.path(), &alone("cut.mpo", &[]), &["cut.mpo", "cut short"]);
}

#[test]
fn a_jps_tells_how_it_shows_both_views() {
    let folder = scene();
    let pictures = pictures(&pair(48, 30));
    let expected = |how: &str, picture: &GrayImage| {
        fs::write(folder.path().join("plain.jpg"), jpeg(picture)).unwrap();
        map(&folder, &alone("plain.jpg", &["--split", how]))
    };
    let flags = [
        ("sbs", 4, 2),
        ("sbs-swapped", 0, 2),
        ("tb", 4, 3),
        ("tb-swapped", 0, 3),
        ("interlaced", 4, 1),
        ("interlaced-swapped", 0, 1),
    ];
    for ((how, picture), (same, flags, layout)) in pictures.iter().zip(flags) {
        assert_eq!(*how, same);
        let marker = [b"_JPSJPS_\0\x04".as_slice(), &[0, flags, layout, 1]].concat();
        fs::write(folder.path().join("a.jps"), with_segment(&jpeg(picture), 0xe3, &marker)).unwrap();
        assert!(map(&folder, &alone("a.jps", &[])) == expected(how, picture), "{how}");
    }
    // Without a marker it is for crossed eyes.
    fs::write(folder.path().join("b.JPS"), jpeg(&pictures[1].1)).unwrap();
    assert!(map(&folder, &alone("b.JPS", &[])) == expected("sbs-swapped", &pictures[1].1));
    let anaglyph = with_segment(&jpeg(&pictures[0].1), 0xe3, b"_JPSJPS_\0\x04\0\x04\x04\x01");
    fs::write(folder.path().join("a.jps"), anaglyph).unwrap();
    refuses(folder.path(), &alone("a.jps", &[]), &["a.jps", "anaglyph"]);
}

/// `sbs.png` and `lfs_pointer.png` of the reproducers.
#[test]
fn the_reproducers() {
    let Some(folder) = shared("cases", "sbs.png and lfs_pointer.png") else { return };
    let work = scene();
    for name in ["sbs.png", "l.png", "r.png", "lfs_pointer.png"] {
        fs::copy(folder.join(name), work.path().join(name)).unwrap();
    }
    refuses(work.path(), &alone("lfs_pointer.png", &["--split", "sbs"]), &["Git LFS pointer", "git lfs pull"]);
    refuses(work.path(), &alone("sbs.png", &[]), &["--split sbs"]);
    let both = map(&work, &["sbs.png", "--split", "sbs", "--disp", "32", "--backend", "cpu", "-q"]);
    assert!(both == map(&work, &["l.png", "r.png", "--disp", "32", "--backend", "cpu", "-q"]));
}
