//! Files that hold both views and say so: MPO (several JPEG files behind each other, with an index; CIPA DC-007) and JPS (one JPEG
//! whose marker tells the arrangement).

use super::split::{Arrangement, Split};
use crate::files::error::{Context as _, Error, Result, ensure, error};
use std::ops::Range;
use std::path::Path;

/// What a file says of its two views.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Stated {
    /// The bytes of the left and of the right view, each a JPEG file.
    Files([Range<usize>; 2]),
    /// One picture shows both.
    Split(Split),
}

/// What the file at `path` says of its two views; `None` if it says nothing.
///
/// # Errors
/// If it has an index of several images, but no two that can be views of one scene.
pub fn stated(path: &Path, bytes: &[u8]) -> Result<Option<Stated>> {
    if let Some(index) = index(bytes) {
        return two_views(&index, bytes)
            .with_context(|| format!("{path:?} is an MPO file"))
            .map(|views| Some(Stated::Files(views)));
    }
    if let Some(marker) = jps_marker(bytes) {
        return marker.with_context(|| format!("{path:?} is a JPS file")).map(|split| Some(Stated::Split(split)));
    }
    // Without a marker both are for crossed eyes.
    let crossed = ["jps", "pns"].iter().any(|ending| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending)));
    Ok(crossed.then_some(Stated::Split(Split::both(Arrangement::SideBySide, true))))
}

/// The segments of a JPEG file before its scan: marker, place and content.
fn segments(bytes: &[u8]) -> impl Iterator<Item = (u8, usize, &[u8])> {
    let mut at = if bytes.starts_with(&[0xff, 0xd8]) { 2 } else { bytes.len() };
    std::iter::from_fn(move || {
        while bytes.get(at..at + 2) == Some(&[0xff, 0xff]) {
            at += 1; // padding
        }
        let [0xff, marker, high, low] = *bytes.get(at..)?.first_chunk::<4>()? else { return None };
        let length = usize::from(u16::from_be_bytes([high, low]));
        if marker == 0xda || length < 2 {
            return None;
        }
        let segment = (marker, at + 4, bytes.get(at + 4..at + 2 + length)?);
        at += 2 + length;
        Some(segment)
    })
}

/// An image of an MPO file by its index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Indexed {
    /// The lower 24 bits of its attributes.
    kind: u32,
    start: usize,
    length: usize,
}

/// A view of a scene from several places, "multi-frame image (disparity)".
const DISPARITY: u32 = 0x02_0002;

impl Indexed {
    /// Neither a preview of another image nor a part of a panorama.
    fn may_be_view(&self) -> bool {
        ![0x01_0001, 0x01_0002, 0x02_0001].contains(&self.kind)
    }
}

/// Whether a JPEG file holds several images by an index.
pub fn has_index(bytes: &[u8]) -> bool {
    index(bytes).is_some()
}

/// The directories of a file that is one of several: numbers by their tags.
struct Directories<'a> {
    tiff: &'a [u8],
    /// Where they begin in the file.
    at: usize,
    big: bool,
}

/// The tag of the table of all images.
const TABLE: usize = 0xb002;
/// The tag of an image's number among those of one scene.
const NUMBER: usize = 0xb101;

impl<'a> Directories<'a> {
    fn of(jpeg: &'a [u8]) -> Option<Self> {
        let (_, at, segment) =
            segments(jpeg).find(|(marker, _, segment)| *marker == 0xe2 && segment.starts_with(b"MPF\0"))?;
        let tiff = &segment[4..];
        let big = match tiff.first_chunk::<4>()? {
            [b'I', b'I', 42, 0] => false,
            [b'M', b'M', 0, 42] => true,
            _ => return None,
        };
        Some(Self { tiff, at: at + 4, big })
    }

    fn two(&self, at: usize) -> Option<usize> {
        let digits = *self.tiff.get(at..)?.first_chunk::<2>()?;
        Some(usize::from(if self.big { u16::from_be_bytes(digits) } else { u16::from_le_bytes(digits) }))
    }

    fn four(&self, at: usize) -> Option<u32> {
        let digits = *self.tiff.get(at..)?.first_chunk::<4>()?;
        Some(if self.big { u32::from_be_bytes(digits) } else { u32::from_le_bytes(digits) })
    }

    /// The place of a tag's entry, in the first directory that has it: that of the index, that of the image.
    fn entry(&self, tag: usize) -> Option<usize> {
        let mut list = self.four(4)? as usize;
        for _ in 0..2 {
            let end = list.saturating_add(2 + 12 * self.two(list)?);
            let mut places = (list.saturating_add(2)..end).step_by(12).take_while(|&place| place < self.tiff.len());
            if let Some(place) = places.find(|&place| self.two(place) == Some(tag)) {
                return Some(place);
            }
            list = self.four(end).filter(|&next| next > 0)? as usize;
        }
        None
    }
}

/// The images of a JPEG file by its index, if it has one with two images at least.
fn index(bytes: &[u8]) -> Option<Vec<Indexed>> {
    let all = Directories::of(bytes)?;
    let entry = all.entry(TABLE)?;
    let (size, first) = (all.four(entry + 4)? as usize, all.four(entry + 8)? as usize);
    // Of 16 bytes each; the place of the first image is 0, those of the others count from the index's own header.
    let image = |number: usize| -> Option<Indexed> {
        let entry = first.checked_add(16 * number)?;
        let place = all.four(entry.checked_add(8)?)? as usize;
        let start = if place == 0 { 0 } else { place.checked_add(all.at)? };
        Some(Indexed { kind: all.four(entry)? & 0xff_ffff, start, length: all.four(entry + 4)? as usize })
    };
    let images: Vec<_> = (0..size / 16).map_while(image).collect();
    (images.len() >= 2).then_some(images)
}

/// The number of an image among those of a scene, which are counted from the left viewpoint to the right one.
fn number(jpeg: &[u8]) -> Option<u32> {
    let all = Directories::of(jpeg)?;
    all.four(all.entry(NUMBER)? + 8)
}

/// The left and the right one. Images of different viewpoints lie in the order of their numbers, from left to right, unless their own
/// numbers say another order.
fn two_views(images: &[Indexed], bytes: &[u8]) -> Result<[Range<usize>; 2]> {
    let mut views: Vec<_> = images.iter().filter(|image| image.kind == DISPARITY).collect();
    if views.len() < 2 {
        views = images.iter().filter(|image| image.may_be_view()).collect();
    }
    ensure!(
        views.len() >= 2,
        "its {} images are no two views of one scene, but previews or parts of a panorama; give the left and the right image",
        images.len()
    );
    let place = |view: &Indexed| -> Result<Range<usize>> {
        let range = view.start..view.start.saturating_add(view.length).min(bytes.len());
        ensure!(
            bytes.get(range.clone()).is_some_and(|view| view.starts_with(&[0xff, 0xd8])),
            "its index points to byte {}, where no JPEG begins; it is damaged or was cut short: copy it again",
            view.start
        );
        Ok(range)
    };
    let views = [place(views[0])?, place(views[1])?];
    let [first, second] = views.each_ref().map(|view| number(&bytes[view.clone()]));
    let [left, right] = views;
    Ok(if first.zip(second).is_some_and(|(first, second)| second < first) { [right, left] } else { [left, right] })
}

/// What the marker of a JPS file says: APP3 with a descriptor of separation, flags, layout and media type, a byte each.
fn jps_marker(bytes: &[u8]) -> Option<Result<Split>> {
    let (.., segment) =
        segments(bytes).find(|(marker, _, segment)| *marker == 0xe3 && segment.starts_with(b"_JPSJPS_"))?;
    let [_, flags, layout, media] = *segment.get(10..)?.first_chunk::<4>()?;
    let swapped = flags & 4 == 0; // "left field first"
    let arrangement = match (media, layout) {
        (1, 1) => Arrangement::Interlaced,
        (1, 2) => Arrangement::SideBySide,
        (1, 3) => Arrangement::TopBottom,
        _ => return Some(Err(not_two(media, layout))),
    };
    Some(Ok(Split::both(arrangement, swapped)))
}

fn not_two(media: u8, layout: u8) -> Error {
    let what = if media == 1 && layout == 4 { "an anaglyph, which mixes both views" } else { "a single view" };
    error!("its marker says that it is {what}; give both views, or say by --split how they lie")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A JPEG without a scan, with these segments.
    fn jpeg(segments: &[(u8, &[u8])]) -> Vec<u8> {
        let mut bytes = vec![0xff, 0xd8];
        for (marker, content) in segments {
            bytes.extend([0xff, *marker]);
            bytes.extend((content.len() as u16 + 2).to_be_bytes());
            bytes.extend(*content);
        }
        bytes.extend([0xff, 0xda, 0, 2, 0xff, 0xd9]);
        bytes
    }

    fn jps(flags: u8, layout: u8, media: u8) -> Result<Option<Stated>> {
        let marker = [b"_JPSJPS_\0\x04".as_slice(), &[0, flags, layout, media]].concat();
        stated(Path::new("p.jps"), &jpeg(&[(0xe0, b"JFIF\0"), (0xe3, &marker)]))
    }

    #[test]
    fn the_marker_of_a_jps_tells_the_arrangement() {
        let split = |arrangement, swapped| Some(Stated::Split(Split::both(arrangement, swapped)));
        assert_eq!(jps(4, 2, 1).unwrap(), split(Arrangement::SideBySide, false));
        assert_eq!(jps(0, 2, 1).unwrap(), split(Arrangement::SideBySide, true));
        assert_eq!(jps(4, 3, 1).unwrap(), split(Arrangement::TopBottom, false));
        assert_eq!(jps(5, 1, 1).unwrap(), split(Arrangement::Interlaced, false));
        assert!(jps(4, 4, 1).unwrap_err().to_string().contains("anaglyph"));
        assert!(jps(4, 2, 0).unwrap_err().to_string().contains("single view"));
        // Without a marker the name tells; of any other name nothing is known.
        let plain = jpeg(&[]);
        assert_eq!(stated(Path::new("P.JPS"), &plain).unwrap(), split(Arrangement::SideBySide, true));
        assert_eq!(stated(Path::new("p.jpg"), &plain).unwrap(), None);
    }

    /// An MPO of images of these kinds, each a JPEG of 8 bytes behind the first.
    fn mpo(big: bool, kinds: &[u32]) -> Vec<u8> {
        let two = |v: u16| if big { v.to_be_bytes() } else { v.to_le_bytes() };
        let four = |v: u32| if big { v.to_be_bytes() } else { v.to_le_bytes() };
        let table = 8 + 2 + 12 + 4;
        let length = 2 + 4 + 4 + table + 16 * kinds.len() + 6; // of the first file
        let mut tiff = if big { b"MM\0\x2a".to_vec() } else { b"II\x2a\0".to_vec() };
        tiff.extend(four(8));
        tiff.extend(two(1));
        tiff.extend([two(0xb002), two(7)].concat());
        tiff.extend([four(16 * kinds.len() as u32), four(table as u32), four(0)].concat());
        for (number, kind) in (0_u32..).zip(kinds) {
            let (size, place) =
                if number == 0 { (length as u32, 0) } else { (8, length as u32 + 8 * (number - 1) - 10) };
            tiff.extend([four(*kind), four(size), four(place), four(0)].concat());
        }
        let mut bytes = jpeg(&[(0xe2, &[b"MPF\0", &tiff[..]].concat())]);
        assert_eq!(bytes.len(), length);
        (1..kinds.len()).for_each(|_| bytes.extend([0xff, 0xd8, 0xff, 0xda, 0, 2, 0xff, 0xd9]));
        bytes
    }

    #[test]
    fn the_index_of_an_mpo_tells_the_views() {
        for big in [false, true] {
            let of = |kinds: &[u32]| {
                let bytes = mpo(big, kinds);
                stated(Path::new("p.mpo"), &bytes).map(|stated| (stated, bytes.len()))
            };
            let (stated, length) = of(&[DISPARITY, DISPARITY]).unwrap();
            assert_eq!(stated, Some(Stated::Files([0..length - 8, length - 8..length])));
            // Previews lie between the views.
            let (stated, length) = of(&[DISPARITY, 0x01_0001, DISPARITY]).unwrap();
            assert_eq!(stated, Some(Stated::Files([0..length - 16, length - 8..length])));
            let (stated, length) = of(&[0x03_0000, 0]).unwrap();
            assert_eq!(stated, Some(Stated::Files([0..length - 8, length - 8..length])));
            assert!(of(&[0x03_0000, 0x01_0001]).unwrap_err().to_string().contains("no two views"));
        }
    }

    /// What an image says of itself: its number, behind the index if it has one.
    fn numbered(number: u32) -> Vec<u8> {
        let directory =
            [&1_u16.to_be_bytes()[..], &0xb101_u16.to_be_bytes(), &[0, 4, 0, 0, 0, 1], &number.to_be_bytes(), &[0; 4]];
        let tiff = [b"MM\0\x2a", &8_u32.to_be_bytes()[..], &directory.concat()].concat();
        jpeg(&[(0xe2, &[b"MPF\0", &tiff[..]].concat())])
    }

    #[test]
    fn the_numbers_of_views_tell_their_order() {
        for (numbers, swapped) in [([1, 2], false), ([2, 1], true), ([3, 3], false)] {
            let second = numbered(numbers[1]);
            assert_eq!(number(&second), Some(numbers[1]));
            // The index of the first file is followed by its own directory.
            let own = &numbered(numbers[0])[2 + 4 + 4 + 8..][..2 + 12 + 4];
            let (table, own_at) = (8 + 2 + 12 + 4 + 18, 8 + 2 + 12 + 4);
            let length = 2 + 4 + 4 + table + 32 + 6;
            let mut tiff = [b"MM\0\x2a", &8_u32.to_be_bytes()[..], &[0, 1, 0xb0, 0x02, 0, 7]].concat();
            tiff.extend([32_u32, table as u32, own_at as u32].map(u32::to_be_bytes).concat());
            tiff.extend(own);
            for entry in [[DISPARITY, length as u32, 0, 0], [DISPARITY, second.len() as u32, length as u32 - 10, 0]] {
                tiff.extend(entry.map(u32::to_be_bytes).concat());
            }
            let mut bytes = jpeg(&[(0xe2, &[b"MPF\0", &tiff[..]].concat())]);
            assert_eq!((bytes.len(), number(&bytes)), (length, Some(numbers[0])));
            bytes.extend(&second);
            let (first, second) = (0..length, length..bytes.len());
            let views = if swapped { [second, first] } else { [first, second] };
            assert_eq!(stated(Path::new("p.mpo"), &bytes).unwrap(), Some(Stated::Files(views)), "{numbers:?}");
        }
    }

    #[test]
    fn a_damaged_index_is_no_panic() {
        let whole = mpo(false, &[DISPARITY, DISPARITY]);
        for length in 0..whole.len() {
            let _ = stated(Path::new("p.mpo"), &whole[..length]);
        }
        for at in 0..whole.len() {
            for value in [0, 1, 0x7f, 0xff] {
                let mut bytes = whole.clone();
                bytes[at] = value;
                let _ = stated(Path::new("p.mpo"), &bytes);
            }
        }
        let cut = &whole[..whole.len() - 8];
        assert!(stated(Path::new("p.mpo"), cut).unwrap_err().to_string().contains("no JPEG begins"));
    }
}
