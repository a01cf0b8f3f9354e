//! Recognises files that are not images, or hold several, and says what to do about them.

use super::one_file;
use crate::files::contents::in_shell;
use std::fs::File;
use std::io::Read as _;
use std::path::Path;

/// What the file at `path` is, if its kind is known, but not read as an image, and what makes an image of it.
pub fn foreign(path: &Path, bytes: &[u8]) -> Option<String> {
    let kind = foreign_kind(bytes)?;
    let named = path.with_extension("png");
    let out = if named == path { path.with_extension("converted.png") } else { named };
    let word = |word| match word {
        "IN" => in_shell(path),
        "OUT" => in_shell(&out),
        other => String::from(other),
    };
    Some(kind.split(' ').map(word).collect::<Vec<_>>().join(" "))
}

const VIDEO: &str = "a video, but an image is needed; give it to gpu-stereo video, which reads the frames by ffmpeg";

/// Whether a file is a video: by its content, or by its ending if that is of no image.
#[must_use]
pub fn is_video(path: &Path) -> bool {
    const ENDINGS: [&str; 14] =
        ["mp4", "mkv", "webm", "avi", "mov", "m4v", "mpg", "mpeg", "wmv", "flv", "ogv", "ts", "m2ts", "y4m"];
    let mut start = Vec::new();
    let read = |start: &mut Vec<u8>| File::open(path)?.take(1024).read_to_end(start);
    if !path.is_file() || read(&mut start).is_err() {
        return false;
    }
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    foreign_kind(&start) == Some(VIDEO) || ENDINGS.contains(&ending.as_str())
}

/// The same, with `IN` for the file and `OUT` for the image.
fn foreign_kind(bytes: &[u8]) -> Option<&'static str> {
    const RAW: &str = "a camera's raw file, but developed images are needed; convert it to 16-bit TIFF or PNG, for example with \
                       dcraw -T -6 or RawTherapee";
    const HEIC: &str =
        "a HEIC image, which is not read; convert it: heif-convert IN OUT (of libheif-examples), or magick IN OUT";
    const AVIF: &str =
        "an AVIF image, which is not read; convert it: avifdec IN OUT (of libavif-bin), or magick IN OUT";
    const JXL: &str = "a JPEG XL image, which is not read; convert it: djxl IN OUT (of libjxl-tools), or magick IN OUT";
    const JP2: &str = "a JPEG 2000 image, which is not read; convert it: opj_decompress -i IN -o OUT (of \
                       libopenjp2-tools), or magick IN OUT";
    const WEB: &str = "a web page, not an image (perhaps a site's error or log-in page); download the image itself";
    const DOCUMENT: &str = "a document, not an image; export its picture as PNG";
    const ARCHIVE: &str = "an archive, not an image; unpack it first";
    if let [_, _, _, length, b'f', b't', b'y', b'p', brand @ ..] = bytes {
        // Either may begin with the brand of all such files, and names its own among those that it is compatible with.
        let brands = brand.get(..usize::from(*length).saturating_sub(8)).unwrap_or(brand);
        let is_avif = || brands.chunks_exact(4).any(|brand| brand == b"avif");
        return Some(match brand.get(..4).unwrap_or_default() {
            b"mif1" | b"msf1" if is_avif() => AVIF,
            b"heic" | b"heix" | b"hevc" | b"hevx" | b"heim" | b"heis" | b"mif1" | b"msf1" => HEIC,
            b"avif" | b"avis" => AVIF,
            b"crx " => RAW,
            _ => VIDEO,
        });
    }
    let signatures: [(&[u8], &'static str); 26] = [
        (b"\x1a\x45\xdf\xa3", VIDEO),
        (b"OggS", VIDEO),
        (b"FLV\x01", VIDEO),
        (b"\x00\x00\x01\xba", VIDEO),
        (b"\x00\x00\x01\xb3", VIDEO),
        (b"YUV4MPEG2", VIDEO),
        (b"\x30\x26\xb2\x75", VIDEO),
        (b"FUJIFILMCCD-RAW", RAW),
        (b"IIRS", RAW),
        (b"IIRO", RAW),
        (b"IIU\0", RAW),
        (b"FOVb", RAW),
        (b"\0MRM", RAW),
        (b"\xff\x0a", JXL),
        (b"\0\0\0\x0cJXL ", JXL),
        (b"\0\0\0\x0cjP  ", JP2),
        (b"\xff\x4f\xff\x51", JP2),
        (b"8BPS", "a Photoshop file, which is not read; export it as PNG or TIFF"),
        (
            b"\x76\x2f\x31\x01",
            "an OpenEXR image of floating-point samples, which is not read; convert it to a 16-bit PNG",
        ),
        (
            b"Pf\n",
            "a map of floating-point samples (PFM), but an image of 8 or 16 bits is needed; give the images first",
        ),
        (b"\x93NUMPY", "a NumPy array, but an image is needed; save it as a PNG of 8 or 16 bits"),
        (b"%PDF", DOCUMENT),
        (b"PK\x03\x04", ARCHIVE),
        (b"\x1f\x8b", ARCHIVE),
        (b"7z\xbc\xaf", ARCHIVE),
        (b"\x28\xb5\x2f\xfd", ARCHIVE),
    ];
    if let Some((_, kind)) = signatures.iter().find(|(signature, _)| bytes.starts_with(signature)) {
        return Some(kind);
    }
    if bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"AVI ") {
        return Some(VIDEO);
    }
    if bytes.first() == Some(&0x47) && bytes.get(188) == Some(&0x47) {
        return Some(VIDEO);
    }
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(1024)]).to_ascii_lowercase();
    let head = head.trim_start_matches('\u{feff}').trim_start();
    match head {
        _ if head.starts_with("<!doctype html") || head.starts_with("<html") || head.contains("<html") => Some(WEB),
        _ if head.contains("<svg") => Some("a drawing (SVG), not an image of pixels; export it as PNG"),
        _ if head.starts_with("<?xml") || head.starts_with('{') => {
            Some("text, not an image (perhaps a server's error message); download or save the image itself")
        }
        _ => None,
    }
}

/// A TIFF that begins with a reduced image: a raw file with its preview, or a pyramid upside down.
pub fn begins_with_preview(bytes: &[u8]) -> bool {
    let canon = bytes.get(8..10) == Some(b"CR");
    canon
        || tiff(bytes).is_some_and(|tiff| {
            tiff.first_entry(254).is_some_and(|kind| kind & 1 == 1) || tiff.first_entry(50706).is_some()
        })
}

/// Whether a file has further images, which are not read.
pub fn has_more(bytes: &[u8]) -> bool {
    match bytes {
        [0xff, 0xd8, ..] => one_file::has_index(bytes),
        [0x89, b'P', b'N', b'G', ..] => {
            let mut rest = bytes.get(8..).unwrap_or_default();
            while let Some((length, after)) = rest.split_first_chunk::<4>() {
                if after.starts_with(b"acTL") {
                    // Frames of an animation.
                    return after.get(4..8).is_some_and(|frames| frames != [0, 0, 0, 1] && frames != [0; 4]);
                }
                if after.starts_with(b"IDAT") {
                    return false;
                }
                rest = after.get(u32::from_be_bytes(*length) as usize + 8..).unwrap_or_default();
            }
            false
        }
        [b'R', b'I', b'F', b'F', ..] => {
            bytes.get(12..16) == Some(b"VP8X") && bytes.get(20).is_some_and(|flags| flags & 2 != 0)
        }
        [b'G', b'I', b'F', ..] => gif_frames(bytes) > 1,
        _ => tiff(bytes).is_some_and(|tiff| tiff.has_second()),
    }
}

/// The images of a GIF file, two at most.
fn gif_frames(bytes: &[u8]) -> usize {
    let table = |flags: u8| if flags & 0x80 != 0 { 3 << ((flags & 7) + 1) } else { 0 };
    let mut at = 13 + bytes.get(10).map_or(0, |&flags| table(flags));
    let mut frames = 0;
    while frames < 2 {
        at = match bytes.get(at) {
            Some(0x2c) => {
                frames += 1;
                at + 11 + bytes.get(at + 9).map_or(0, |&flags| table(flags))
            }
            Some(0x21) => at + 2,
            _ => break,
        };
        while let Some(&length) = bytes.get(at) {
            at += 1 + usize::from(length);
            if length == 0 {
                break;
            }
        }
    }
    frames
}

/// The first list of entries of a TIFF file.
struct Tiff<'a> {
    bytes: &'a [u8],
    big: bool,
    first: usize,
    entries: usize,
}

fn tiff(bytes: &[u8]) -> Option<Tiff<'_>> {
    let big = match bytes {
        [b'I', b'I', 42, 0, ..] => false,
        [b'M', b'M', 0, 42, ..] => true,
        _ => return None,
    };
    let mut tiff = Tiff { bytes, big, first: 0, entries: 0 };
    tiff.first = tiff.number(4, 4)?;
    tiff.entries = tiff.number(tiff.first, 2)?;
    Some(tiff)
}

impl Tiff<'_> {
    fn number(&self, at: usize, size: usize) -> Option<usize> {
        let digits = self.bytes.get(at..at.checked_add(size)?)?.iter();
        let add = |number, &digit: &u8| number << 8 | usize::from(digit);
        Some(if self.big { digits.fold(0, add) } else { digits.rev().fold(0, add) })
    }

    /// The first value of an entry, a whole number of up to 32 bits.
    fn first_entry(&self, tag: usize) -> Option<usize> {
        let places = (0..self.entries).map(|i| self.first + 2 + 12 * i);
        let place = places
            .take_while(|place| place + 12 <= self.bytes.len())
            .find(|&place| self.number(place, 2) == Some(tag))?;
        let size = if self.number(place + 2, 2)? == 3 { 2 } else { 4 };
        self.number(place + 8, size)
    }

    fn has_second(&self) -> bool {
        self.number(self.first + 2 + 12 * self.entries, 4).is_some_and(|next| next != 0)
    }
}
