//! `--disp auto`: the range of disparities from a coarse match.

use super::engine;
use crate::args::{DeviceArgs, Range};
use crate::terminal::warnings;
use anyhow::{Result, ensure};
use gpu_stereo::{Image, Params, RangeSearch, reference};

/// Sets the range of the settings for a pair, if it is to be found. The coarse match runs where the pair is computed.
pub fn find(range: Range, device: &DeviceArgs, [left, right]: [&Image; 2], params: &mut Params) -> Result<()> {
    let Range::Found { min_is_given } = range else { return Ok(()) };
    let rectified = match &params.rectify {
        Some(lenses) => Some([reference::rectify(left, lenses, 0)?, reference::rectify(right, lenses, 1)?]),
        None => None,
    };
    let [left, right] = rectified.as_ref().map_or([left, right], |[left, right]| [left, right]);
    let search = RangeSearch::new(left, right)?;
    let engine = engine::open(device, None, &search.left, &search.params)?;
    let computed = engine::frames(&engine, &search.left, &search.right, &search.params, false, None, &|_| ())?;
    let min = params.min_disparity;
    search.found(&computed.matched.map, params)?;
    if min_is_given {
        let end = params.min_disparity + params.disparities as i32;
        ensure!(min < end, "--min-disp is {min}, but the disparities end at {}; give a smaller one, or none", end - 1);
        (params.min_disparity, params.disparities) = (min, (end - min) as u32);
    }
    params.validate()?;
    if params.min_disparity + (params.disparities as i32) <= 0 {
        warnings::warn("all disparities are negative, as if LEFT and RIGHT were exchanged; exchange them");
    }
    Ok(())
}
