//! The images of pairs and their masks, as the options say.

use super::pair::Pair;
use crate::args::InputArgs;
use crate::terminal::warnings;
use anyhow::Result;
use gpu_stereo::files::images::{self, Bits, ImagePair};
use gpu_stereo::files::masks::ReadMasks;
use gpu_stereo::reference::{self, Channel};
use gpu_stereo::{Image, Masks, Params};
use image::{Rgb, RgbImage};
use std::borrow::Cow;
use std::path::Path;

/// Reads a pair. The facts are those of the file that was given first, and of the other one.
pub fn read_pair(left: &Path, right: &Path, options: &InputArgs) -> Result<ImagePair> {
    if !options.swap {
        return Ok(images::read_pair(left, right, options.bits)?);
    }
    let mut pair = images::read_pair(right, left, options.bits)?;
    pair.facts.reverse();
    Ok(pair)
}

/// So many pairs of a sequence are tried for the first one.
pub const FIRST: usize = 8;

/// The options for all pairs of a sequence: the first pair that can be read decides.
pub fn as_first(options: &InputArgs, pairs: &[Pair]) -> InputArgs {
    let mut options = options.clone();
    let read = |pair: &Pair| read_pair(&pair.left, &pair.right, &options).ok();
    if options.bits == Bits::Auto
        && let Some(pair) = pairs.iter().find_map(read)
    {
        options.bits = Bits::OfFirst(pair.bits);
    }
    options
}

/// Masks, once it is reported why they may be wrong.
pub fn reported(read: ReadMasks) -> Option<Masks> {
    read.doubts.iter().for_each(|doubt| warnings::warn(doubt));
    read.masks
}

/// An image as it is matched with `params`: rectified, if they say so. `side`: 0 the left one.
pub fn rectified<'a>(image: &'a Image, params: &Params, side: usize) -> Result<Cow<'a, Image>> {
    Ok(match &params.rectify {
        Some(rectification) => Cow::Owned(reference::rectify(image, rectification, side)?),
        None => Cow::Borrowed(image),
    })
}

/// An image in 8 bits a channel.
pub fn drawn(image: &Image) -> RgbImage {
    let channels = [0, 1, 2].map(|sample| reference::gray(image, Channel::Sample(sample)).data);
    let mut pixels = 0..;
    let color = |i: usize| channels.each_ref().map(|channel| channel[i]);
    RgbImage::from_fn(image.width(), image.height(), |_, _| Rgb(pixels.next().map_or([0; 3], color)))
}
