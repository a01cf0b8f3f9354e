//! What must hold of the parsers of `gpu_stereo::files`, whatever they are given.

/// How the command prints a text.
#[allow(dead_code)]
#[path = "../../cli/src/terminal/text.rs"]
mod text;

use gpu_stereo::evaluation::FloatMap;
use gpu_stereo::files::Error;
use gpu_stereo::files::calibration::{Calibration, Fitted, KittiPair, LensModel, Reading, Scale, Source, Unit};
use gpu_stereo::files::encoders;
use gpu_stereo::files::frames::FrameReader;
use gpu_stereo::files::images::{self, Stated};
use gpu_stereo::files::lists::{self, Kind, Listed};
use gpu_stereo::files::maps::{self, Encoding, EncodingOptions};
use gpu_stereo::files::ros::{CameraInfo, Header, ImageMessage};
use gpu_stereo::files::weights::{Weights, encode};
use gpu_stereo::{Camera, Rectification};
use std::path::{Component, Path};

/// The command prints an error in one line, whatever text is in the file.
fn told(error: &Error) {
    let text = text::one_line(&format!("{error}"));
    assert!(!text.trim().is_empty());
    assert!(text.chars().count() <= text::MOST && !text.contains(text::must_be_escaped), "{text:?}");
}

/// A file of both views: what it says of them lies within it.
pub fn both(data: &[u8]) {
    match images::stated(Path::new("both.mpo"), data) {
        Ok(Some(Stated::Files(views))) => {
            assert!(views.into_iter().all(|view| data[view].starts_with(&[0xff, 0xd8])));
        }
        Ok(_) => {}
        Err(error) => told(&error),
    }
}

/// A stream of frames; the first byte selects whether they are raw, and how their bytes hold the pixels.
pub fn frames(data: &[u8]) {
    const RAW: [&str; 8] =
        ["", "3x2:gray", "2x2:gray16le", "1x3:bgr24", "3x3:yuv420p", "3x1:nv12", "3x2:yuyv", "1x1:rgba"];
    let Some((&selector, bytes)) = data.split_first() else { return };
    let raw = RAW[usize::from(selector) % RAW.len()].parse().ok();
    let mut reader = match FrameReader::open(bytes, raw) {
        Ok(reader) => reader,
        Err(error) => return told(&error),
    };
    assert!(reader.rate().is_none_or(|rate| rate.is_finite() && rate > 0.0));
    loop {
        match reader.next_frame() {
            Ok(Some(frame)) => assert!(frame.width() > 0 && frame.height() > 0),
            Ok(None) => return,
            Err(error) => return told(&error),
        }
    }
}

/// A message of ROS 2; the first byte selects its type.
pub fn message(data: &[u8]) {
    let Some((&selector, bytes)) = data.split_first() else { return };
    let read = match selector % 4 {
        0 => Header::read(bytes).map(drop),
        1 => ImageMessage::read(bytes).map(|image| assert!(image.picture.width() > 0 && image.picture.height() > 0)),
        2 => ImageMessage::read_compressed(bytes).map(drop),
        _ => CameraInfo::read(bytes).and_then(|info| CameraInfo::pair(&info, &info, selector & 4 != 0)).map(drop),
    };
    if let Err(error) = read {
        told(&error);
    }
}

/// A file that begins as one of `kinds`, as a map. The first byte selects the kind and what is asked beside the file.
pub fn map(kinds: &[&[u8]], data: &[u8]) {
    let Some((&selector, rest)) = data.split_first() else { return };
    let bytes = [kinds[usize::from(selector / 4) % kinds.len()], rest].concat();
    let encoding = match selector % 4 {
        0 => Encoding::default(),
        1 => Encoding { scale: Some(2.0), depth: None, invalid: Some(-1.0) },
        2 => Encoding { scale: None, depth: Some(386.2), invalid: None },
        _ => Encoding { scale: Some(1e-300), depth: Some(1e300), invalid: Some(0.0) },
    };
    match maps::parse(Path::new("map"), &bytes, encoding, EncodingOptions::TRUTH) {
        Ok(file) => map_is_sound(&file.map),
        Err(error) => told(&error),
    }
}

fn map_is_sound(map: &FloatMap) {
    let (width, height, data) = (map.width(), map.height(), map.data());
    assert!(width > 0 && height > 0);
    assert_eq!(data.len() as u64, u64::from(width) * u64::from(height));
    assert!(data.iter().all(|value| value.is_finite() || value.is_nan()));
    if data.len() > 1 << 12 {
        return;
    }
    // Written, it is read again as it was.
    let bits =
        |data: &[f32]| data.iter().map(|v| if v.is_nan() { None } else { Some(v.to_bits()) }).collect::<Vec<_>>();
    for encode in [encoders::pfm, encoders::npy, encoders::tiff] {
        let file = written(map, encode);
        let again = maps::parse(Path::new("again"), &file, Encoding::default(), EncodingOptions::TRUTH).expect("what was read").map;
        assert_eq!((again.width(), again.height()), (width, height));
        assert_eq!(bits(again.data()), bits(data));
    }
}

fn written(map: &FloatMap, encode: fn(u32, u32, &[f32]) -> gpu_stereo::files::Result<Vec<u8>>) -> Vec<u8> {
    encode(map.width(), map.height(), map.data()).expect("a map that was read")
}

/// A calibration of any kind; or of two files, between which a 0 stands. The first byte selects what is asked.
pub fn calibration(data: &[u8], two_files: bool) {
    let Some((&selector, rest)) = data.split_first() else { return };
    let unit = [None, Some(Unit::M), Some(Unit::Cm), Some(Unit::Mm)][usize::from(selector % 4)];
    let pair = [None, Some(KittiPair::Gray), Some(KittiPair::Color)][usize::from(selector / 4 % 3)];
    let lenses = selector / 12 % 2 == 1;
    let lens = [LensModel::Auto, LensModel::Pinhole, LensModel::Fisheye][usize::from(selector / 24 % 3)];
    let scale = [None, Some(Scale::ONE), "1/2".parse().ok()][usize::from(selector / 72 % 3)];
    let cameras = (lenses && scale.is_none()).then_some([0, 1]);
    let rectified_size = (lenses && unit.is_some()).then_some([320, 200]);
    let alpha = (lenses && unit == Some(Unit::Mm)).then_some(0.5);
    let vertical = selector % 32 == 31;
    let reading = Reading { unit, pair, cameras, lens, scale, lenses, alpha, vertical, rectified_size };
    let size = [[640, 480], [320, 240]][usize::from(selector / 144 % 2)];
    let parsed = if two_files {
        let end = rest.iter().position(|byte| *byte == 0).unwrap_or(rest.len());
        let right = rest.get(end + 1..).unwrap_or_default();
        Source::parse(&rest[..end]).and_then(|left| Ok((left, Some(Source::parse(right)?))))
    } else {
        Source::parse(rest).map(|left| (left, None))
    };
    let fit = |calibration: Calibration| calibration.fit(size[0], size[1]);
    match parsed.and_then(|(left, right)| Calibration::of(&left, right.as_ref(), reading)).and_then(fit) {
        Ok(Fitted { camera, lenses: found, .. }) => {
            let Camera { focal, baseline, doffs, cx, cy, .. } = camera;
            assert!([focal, baseline, doffs, cx, cy].iter().all(|value| value.is_finite()), "{camera:?}");
            assert!(focal > 0.0 && baseline > 0.0, "{camera:?}");
            camera.validate().expect("a calibration within the ranges of a camera");
            assert_eq!(found.is_some(), lenses);
            match found.map(|lenses| Rectification::new(5, 3, lenses)).transpose() {
                Ok(rectification) => {
                    let sides =
                        rectification.iter().flat_map(|rectification| [0, 1].map(|side| rectification.positions(side)));
                    for place in sides.flatten() {
                        assert!(
                            (-512..=256 * 5).contains(&place[0]) && (-512..=256 * 3).contains(&place[1]),
                            "{place:?}"
                        );
                    }
                }
                Err(error) => told(&Error::from(error)),
            }
        }
        Err(error) => told(&error),
    }
}

/// A calibration in an archive of NumPy's: arrays between which `|` stands, under the names of R and T's calibrations.
pub fn arrays(data: &[u8]) {
    let Some((&selector, rest)) = data.split_first() else { return };
    let names = ["mtx_l", "dist_l", "mtx_r", "dist_r", "R", "T", "imageSize"];
    let (mut body, mut directory, mut count) = (Vec::new(), Vec::new(), 0u16);
    for (name, array) in names.iter().zip(rest.split(|byte| *byte == b'|')) {
        let name = format!("{name}.npy");
        let place = (body.len() as u32).to_le_bytes();
        let mut fields = vec![0; 10];
        fields.extend([array.len() as u32; 2].iter().flat_map(|length| length.to_le_bytes()));
        fields.extend((name.len() as u16).to_le_bytes());
        body.extend([&b"PK\x03\x04\0\0\0\0"[..], &fields, &[0, 0], name.as_bytes(), array].concat());
        directory.extend([&b"PK\x01\x02\0\0\0\0\0\0"[..], &fields, &[0; 12], &place, name.as_bytes()].concat());
        count += 1;
    }
    let (start, length) = ((body.len() as u32).to_le_bytes(), (directory.len() as u32).to_le_bytes());
    let count = count.to_le_bytes();
    let end = [&b"PK\x05\x06\0\0\0\0"[..], &count, &count, &length, &start, &[0, 0]].concat();
    calibration(&[&[selector][..], &body, &directory, &end].concat(), false);
}

/// Weights of any format.
pub fn weights(data: &[u8]) {
    let weights = match Weights::parse(Path::new("weights"), data) {
        Ok(weights) => weights,
        Err(error) => return told(&error),
    };
    let values: usize = weights.tensors.values().map(|tensor| tensor.data().len()).sum();
    assert!(values <= data.len());
    assert!(weights.tensors.keys().eq(weights.elements.keys()));
    // Written, they are read again as they were. No other tensor may have the name of the file's own texts.
    if !weights.tensors.contains_key("__metadata__") {
        let file = encode(&weights.tensors).expect("what was read");
        let again = Weights::parse(Path::new("again"), &file).expect("what was written").tensors;
        assert!(again.keys().eq(weights.tensors.keys()));
        for (one, other) in again.values().zip(weights.tensors.values()) {
            assert_eq!(one.shape(), other.shape());
            assert!(one.data().iter().map(|v| v.to_bits()).eq(other.data().iter().map(|v| v.to_bits())));
        }
    }
    if let Err(error) = weights.network() {
        told(&error);
    }
}

/// A list of pairs.
pub fn list(data: &[u8], kind: Kind) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let all = match lists::parse(text, kind) {
        Ok(all) => all,
        Err(error) => {
            told(&error);
            assert!(format!("{error}").starts_with("line "), "{error}");
            return;
        }
    };
    for pair in &all {
        assert!(pair.left != Path::new("") && pair.right != Path::new(""));
        assert!(pair.name.iter().all(|name| stays_within(name)), "{:?}", pair.name);
    }
    assert!(all.windows(2).all(|pairs| pairs[0].line < pairs[1].line));
    match lists::names(&all) {
        Ok(names) => {
            assert_eq!(names.len(), all.len());
            assert!(names.iter().all(|name| stays_within(name)), "{names:?}");
        }
        Err(error) => told(&error),
    }
    // Written, it is read again as it was.
    assert_eq!(
        unnumbered(lists::parse(&json_lines(&all), Kind::JsonLines).expect("what was read")),
        unnumbered(all.clone())
    );
    // But for blanks around a field, which CSV leaves out.
    let trimmed = all.iter().flat_map(fields).flatten().all(|field| field == field.trim());
    if kind == Kind::Csv && trimmed {
        assert_eq!(unnumbered(lists::parse(&csv_rows(&all), kind).expect("what was read")), unnumbered(all));
    }
}

fn stays_within(name: &Path) -> bool {
    name != Path::new("") && name.components().all(|part| matches!(part, Component::Normal(_)))
}

fn unnumbered(mut all: Vec<Listed>) -> Vec<Listed> {
    all.iter_mut().for_each(|pair| pair.line = None);
    all
}

fn fields(pair: &Listed) -> [Option<&str>; 3] {
    [Some(&pair.left), Some(&pair.right), pair.name.as_ref()].map(|path| path.map(|path| path.to_str().expect("text")))
}

fn json_lines(all: &[Listed]) -> String {
    let line = |pair| {
        let [left, right, name] = fields(pair);
        serde_json::json!({"left": left, "right": right, "name": name}).to_string() + "\n"
    };
    all.iter().map(line).collect()
}

fn csv_rows(all: &[Listed]) -> String {
    let mut rows = csv::WriterBuilder::new().quote_style(csv::QuoteStyle::Always).from_writer(Vec::new());
    rows.write_record(["left", "right", "name"]).expect("a header");
    for pair in all {
        rows.write_record(fields(pair).map(Option::unwrap_or_default)).expect("a row");
    }
    String::from_utf8(rows.into_inner().expect("rows")).expect("text")
}
