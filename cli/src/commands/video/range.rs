//! `--disp auto` of a video: the range that its first frames need, which is kept for all.

use super::source::Source;
use crate::args::{DeviceArgs, InputArgs, Range};
use crate::engine::compute::{ParamsBySize, RangeFinder, ends, joined};
use crate::terminal::warnings;
use anyhow::{Result, anyhow};
use gpu_stereo::Error;
use gpu_stereo::files::images::ImagePair;
use std::ops::RangeInclusive;

/// So many frames tell the range, of the first so many: videos may begin with black frames.
const FRAMES: usize = 4;
const LOOKED_AT: usize = 8;

/// Sets the range of the settings, if the options leave it to the frames. `held`: the disparities that all files can hold. Returns
/// how many frames told it.
pub fn find(
    rule: Range,
    (source, input): (&Source, &InputArgs),
    device: &DeviceArgs,
    held: Option<&RangeInclusive<i32>>,
    params: &mut ParamsBySize,
) -> Result<Option<usize>> {
    if !rule.is_found() {
        return Ok(None);
    }
    let mut finder = RangeFinder::new(device);
    let (mut all, mut frames, mut doubts, mut failure) = (None, 0, None, None);
    let mut see = |pair: &ImagePair| -> Result<bool> {
        let mut settings = (*params.of([pair.left.width(), pair.left.height()])?).clone();
        let coarse = finder.coarse([&pair.left, &pair.right], &settings)?;
        match coarse.set(rule, held, &mut settings) {
            Ok(doubt) => doubts = doubts.take().or(doubt),
            Err(error) => {
                failure.get_or_insert(error);
                return Ok(false);
            }
        }
        all = Some(all.map_or(ends(&settings), |all| joined(all, ends(&settings))));
        frames += 1;
        Ok(frames == FRAMES)
    };
    source.look_ahead(input, LOOKED_AT, &mut see)?;
    let Some(all) = all else {
        return Err(failure.unwrap_or_else(|| {
            let text =
                "none of the first frames can be read, so their range of disparities is not known; give --disp N";
            anyhow!(Error::Image(text.into()))
        }));
    };
    doubts.iter().for_each(|doubt| warnings::warn(doubt));
    params.set_range(all);
    Ok(Some(frames))
}
