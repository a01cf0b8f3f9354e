//! The images of pairs and their masks, as the options say.

use super::pair::Pair;
use super::pairs;
use crate::args::InputArgs;
use crate::terminal::warnings;
use anyhow::{Result, bail, ensure};
use gpu_stereo::backend::upright;
use gpu_stereo::files::images::{self, Bits, ImagePair, Split};
use gpu_stereo::files::masks::ReadMasks;
use gpu_stereo::reference::{self, Channel};
use gpu_stereo::{Image, Masks, Params};
use image::{Rgb, RgbImage};
use std::borrow::Cow;
use std::path::Path;

/// Reads a pair. The facts are those of the file that was given first, and of the other one. A pair with one file twice is one
/// that holds both views, if `options` says how.
pub fn read_pair(left: &Path, right: &Path, options: &InputArgs) -> Result<ImagePair> {
    let mut pair = match options.split {
        Some(split) if left == right => images::read_both(left, split, options.bits)?,
        None | Some(Split::Auto) => {
            let [left, right] = if options.swap { [right, left] } else { [left, right] };
            let mut pair = images::read_pair(left, right, options.bits)?;
            if options.swap {
                pair.facts.reverse();
            }
            return Ok(pair);
        }
        Some(_) => bail!("--split is for one file that holds both views, but {left:?} and {right:?} are two; drop it"),
    };
    if options.swap {
        std::mem::swap(&mut pair.left, &mut pair.right);
    }
    Ok(pair)
}

/// The pair that one or two names mean, and how it is read: a name alone is a file that holds both views.
pub fn given(left: &Path, right: Option<&Path>, options: &InputArgs) -> Result<(Pair, InputArgs)> {
    let both = |split| InputArgs { split, ..options.clone() };
    match right {
        None => Ok((Pair::in_one(left), both(options.split.or(Some(Split::Auto))))),
        Some(right) => {
            ensure!(
                options.split.is_none(),
                "--split is for one file that holds both views, but {left:?} and {right:?} are two; drop it, or drop one of \
                 them"
            );
            Ok((Pair { left: left.into(), right: right.into() }, both(None)))
        }
    }
}

/// The numbered pairs of one folder, pattern or glob, whose files hold both views each. If none of the first ones can be read, it
/// is told before any work how to say where the views are.
pub fn find_in_one(given: &Path, options: &InputArgs) -> Result<Vec<(u64, Pair)>> {
    let pairs = pairs::find_in_one(given)?;
    if let Some(Split::Auto) = options.split {
        let mut first = pairs.iter().take(FIRST).map(|(_, pair)| read_pair(&pair.left, &pair.right, options));
        if let Some(Err(error)) = first.next()
            && !first.any(|read| read.is_ok())
        {
            return Err(error);
        }
    }
    Ok(pairs)
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

/// An image as its map shows it: rectified, if `params` say so, but never turned. `side`: 0 the left one.
pub fn rectified<'a>(image: &'a Image, params: &Params, side: usize) -> Result<Cow<'a, Image>> {
    Ok(match &params.rectify {
        Some(rectification) => {
            let rectified = reference::rectify(image, rectification, side)?;
            Cow::Owned(if rectification.is_turned() { upright(&rectified, rectification)? } else { rectified })
        }
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
