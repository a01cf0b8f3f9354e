//! Two image files, or one with both views, become two [`Image`]s of one size and one sample format.

use super::bits::{self, Bits};
use super::decoder::{decode, decoder, orientation};
use super::kinds;
use super::one_file::{self, Stated};
use super::split::{self, Split};
use crate::files::contents::read_file_with_facts;
use crate::files::error::{Context as _, Result, bail, ensure};
use crate::files::facts::Facts;
use crate::{Image, PixelFormat, Pixels};
use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder as _};
use std::path::Path;

/// A pair as it was read.
pub struct ImagePair {
    /// The left image.
    pub left: Image,
    /// The right image.
    pub right: Image,
    /// The bits that samples have.
    pub bits: u32,
    /// How each image was turned, as its file says.
    turned: [Orientation; 2],
    /// Why the images may be wrong, for warnings.
    pub doubts: Vec<String>,
    /// The facts of the left and of the right view's file, which show later whether they have changed; none of a frame.
    pub facts: Vec<Facts>,
}

impl ImagePair {
    /// The samples, where they are not what the file's format says.
    pub fn samples(&self) -> Option<String> {
        let deep = matches!(self.left.format(), PixelFormat::Gray16 | PixelFormat::Rgba16);
        (deep && self.bits < bits::ALL).then(|| format!("{} bits in 16", self.bits))
    }

    /// How the images were turned, if they were.
    pub fn turns(&self) -> Option<String> {
        let turn = |orientation| match orientation {
            Orientation::NoTransforms => "as stored",
            Orientation::Rotate90 => "by 90 degrees clockwise",
            Orientation::Rotate180 => "by 180 degrees",
            Orientation::Rotate270 => "by 90 degrees counterclockwise",
            Orientation::FlipHorizontal => "mirrored left to right",
            Orientation::FlipVertical => "mirrored top to bottom",
            Orientation::Rotate90FlipH | Orientation::Rotate270FlipH => "mirrored along a diagonal",
        };
        match self.turned {
            [Orientation::NoTransforms, Orientation::NoTransforms] => None,
            [left, right] if left == right => Some(format!("{} (EXIF)", turn(left))),
            [left, right] => Some(format!("left {}, right {} (EXIF)", turn(left), turn(right))),
        }
    }
}

/// Reads a pair.
///
/// # Errors
/// If a file cannot be read or decoded, or the two sizes differ.
pub fn read_pair(left: &Path, right: &Path, bits: Bits) -> Result<ImagePair> {
    let (left_file, left_facts) = read_file_with_facts(left, "an image")?;
    let (right_file, right_facts) = read_file_with_facts(right, "an image")?;
    let (images, turned) = decode_two([(left, &left_file), (right, &right_file)])?;
    let mut doubts = Vec::new();
    for (path, file) in [(left, &left_file), (right, &right_file)] {
        if kinds::has_more(file) {
            let remedy = if one_file::has_index(file) { "give it alone to match its two views, or " } else { "" };
            doubts.push(format!(
                "{path:?} holds several images, and the first one is read; {remedy}split it if another is meant"
            ));
        }
    }
    let pair = ImagePair::of(images, [left, right], bits)?;
    Ok(ImagePair { turned, doubts, facts: vec![left_facts, right_facts], ..pair })
}

/// Reads a pair from one file, whose two views are where `split` says.
///
/// # Errors
/// If the file cannot be read or decoded, does not say where its views are, or its views differ in size.
pub fn read_both(path: &Path, split: Split, bits: Bits) -> Result<ImagePair> {
    let (file, facts) = read_file_with_facts(path, "an image")?;
    let stated = if split == Split::Auto { one_file::stated(path, &file)? } else { Some(Stated::Split(split)) };
    let (images, turned) = match stated {
        Some(Stated::Files([left, right])) => {
            let views = [(path, &file[left]), (path, &file[right])];
            decode_two(views).with_context(|| "the two views of an MPO file")?
        }
        Some(Stated::Split(Split::Both { arrangement, swapped })) => {
            let mut decoder = decoder(path, &file)?;
            let turned = orientation(&mut decoder);
            let picture = decode(path, decoder)?;
            (split::views(&picture, arrangement, swapped, &format!("{path:?}"))?, [turned; 2])
        }
        _ => {
            decoder(path, &file)?; // what is no image at all has another remedy
            bail!(
                "{path:?} is given alone, but does not say that it holds two views, as MPO and JPS files do; give LEFT and RIGHT, or \
                 --split sbs if its left half is the left view, sbs-swapped if that is the right view, tb if its upper \
                 half is the left view, interlaced if its rows belong to both in turn"
            )
        }
    };
    let pair = ImagePair::of(images, [path, path], bits)?;
    Ok(ImagePair { turned, facts: vec![facts.clone(), facts], ..pair })
}

/// The views of a frame that shows both; `name` is what errors call it.
///
/// # Errors
/// If its size cannot be that of two views, or `split` does not say where they are.
pub fn split_frame(frame: &DynamicImage, split: Split, name: &str) -> Result<[DynamicImage; 2]> {
    let Split::Both { arrangement, swapped } = split else {
        bail!("{name} does not say where its views are; give --split sbs, tb or interlaced")
    };
    split::views(frame, arrangement, swapped, name)
}

/// Two images of one size, and how they were turned.
fn decode_two(files: [(&Path, &[u8]); 2]) -> Result<([DynamicImage; 2], [Orientation; 2])> {
    let [(left, left_file), (right, right_file)] = files;
    let mut decoders = (decoder(left, left_file)?, decoder(right, right_file)?);
    let turned = [orientation(&mut decoders.0), orientation(&mut decoders.1)];
    let sizes = [(decoders.0.dimensions(), turned[0]), (decoders.1.dimensions(), turned[1])].map(oriented);
    ensure_one_size(sizes, [left, right])?;
    drop(decoders); // they stay in their thread
    let decoded = |path, file| decode(path, decoder(path, file)?);
    let (left, right) = rayon::join(|| decoded(left, left_file), || decoded(right, right_file));
    Ok(([left?, right?], turned))
}

fn ensure_one_size(sizes: [(u32, u32); 2], [left, right]: [&Path; 2]) -> Result<()> {
    ensure!(
        sizes[0] == sizes[1],
        "{left:?} is {}x{} but {right:?} is {}x{}; both must have one size: crop or rectify them again",
        sizes[0].0,
        sizes[0].1,
        sizes[1].0,
        sizes[1].1
    );
    Ok(())
}

impl ImagePair {
    /// Two images as a pair: samples of 16 bits are stretched as `bits` says, and both are brought to one format.
    ///
    /// # Errors
    /// If the sizes differ, or a sample has more bits than were given.
    pub fn of(mut images: [DynamicImage; 2], paths: [&Path; 2], bits: Bits) -> Result<Self> {
        ensure_one_size(images.each_ref().map(|image| (image.width(), image.height())), paths)?;
        // Of an image of 8 bits the samples have 8, whatever the other one has.
        let largest = images.each_ref().map(bits::largest);
        let mut depth = 8;
        if let Some(most) = largest.into_iter().flatten().max() {
            let path = if largest[0] == Some(most) { paths[0] } else { paths[1] };
            depth = bits::of(bits, most, path)?;
            images.iter_mut().for_each(|image| bits::stretch(image, depth));
        }

        // The matcher takes one format for both; the poorer image is brought to the richer one's, which changes no gray value.
        let colour = images.iter().any(|image| image.color().has_color());
        let deep = images.iter().any(is_deep);
        let [left, right] = images;
        Ok(Self {
            left: to_image(left, colour, deep)?,
            right: to_image(right, colour, deep)?,
            bits: depth,
            turned: [Orientation::NoTransforms; 2],
            doubts: Vec::new(),
            facts: Vec::new(),
        })
    }
}

/// The size of an image that was turned.
fn oriented(((width, height), turned): ((u32, u32), Orientation)) -> (u32, u32) {
    match turned {
        Orientation::Rotate90 | Orientation::Rotate270 | Orientation::Rotate90FlipH | Orientation::Rotate270FlipH => {
            (height, width)
        }
        _ => (width, height),
    }
}

fn is_deep(image: &DynamicImage) -> bool {
    let color = image.color();
    color.bytes_per_pixel() > color.channel_count()
}

fn to_image(image: DynamicImage, colour: bool, deep: bool) -> Result<Image, crate::Error> {
    let (width, height) = (image.width(), image.height());
    let pixels = match (colour, deep) {
        (false, false) => Pixels::Gray8(image.into_luma8().into_raw()),
        (false, true) => Pixels::Gray16(image.into_luma16().into_raw()),
        (true, false) => Pixels::Rgba8(image.into_rgba8().into_raw()),
        (true, true) => Pixels::Rgba16(image.into_rgba16().into_raw()),
    };
    Image::new(width, height, pixels)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::{Channel, gray};
    use image::{GrayImage, Luma};

    #[test]
    fn promotion_changes_no_gray_value() {
        let image = GrayImage::from_fn(256, 1, |x, _| Luma([x as u8]));
        let plain = gray(&to_image(image.clone().into(), false, false).unwrap(), Channel::Luma);
        for (colour, deep) in [(false, true), (true, false), (true, true)] {
            let promoted = to_image(image.clone().into(), colour, deep).unwrap();
            assert_eq!(gray(&promoted, Channel::Luma), plain, "{colour} {deep}");
        }
    }
}
