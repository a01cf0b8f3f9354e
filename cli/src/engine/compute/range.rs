//! `--disp auto`: the range of disparities from a coarse match.

use super::engine;
use crate::args::{self, DeviceArgs, Range};
use anyhow::{Result, ensure};
use gpu_stereo::backend::{Engine, Shape};
use gpu_stereo::{DisparityMap, Image, Params, RangeSearch};
use std::ops::RangeInclusive;

/// Matches pairs coarsely, where they are computed. Those of one size and format share a matcher.
pub struct RangeFinder {
    device: DeviceArgs,
    ready: Option<Ready>,
}

/// What computes coarse pairs of one kind.
struct Ready {
    shape: Shape,
    params: Params,
    engine: Engine,
}

/// A pair that was matched coarsely.
pub struct Coarse {
    search: RangeSearch,
    map: DisparityMap,
}

impl RangeFinder {
    /// On the device that the options name.
    pub fn new(device: &DeviceArgs) -> Self {
        Self { device: device.clone(), ready: None }
    }

    /// Matches a pair coarsely, once it is rectified as the settings say.
    pub fn coarse(&mut self, [left, right]: [&Image; 2], params: &Params) -> Result<Coarse> {
        let search = RangeSearch::rectified(left, right, params.rectify.as_ref())?;
        let engine = self.engine(&search)?;
        let computed = engine::frames(engine, &search.left, &search.right, &search.params, false, None, &|_| ());
        if computed.is_err() {
            self.ready = None; // the device may be lost
        }
        Ok(Coarse { map: computed?.matched.map, search })
    }

    fn engine(&mut self, search: &RangeSearch) -> Result<&Engine> {
        let (shape, params) = (Shape::of(&search.left), &search.params);
        let fits = |ready: &Ready| ready.shape == shape && ready.params == *params;
        let ready = match self.ready.take().filter(fits) {
            Some(ready) => ready,
            None => {
                let engine = engine::open(&self.device, None, &search.left, params)?;
                Ready { shape, params: params.clone(), engine }
            }
        };
        Ok(&self.ready.insert(ready).engine)
    }
}

impl Coarse {
    /// Sets the range of the settings, if the options leave it to the pair. `held`: the disparities that all files can hold. What
    /// lies beyond them only to be on the safe side is not searched; more is refused where the files are written. Returns why the
    /// range is doubtful.
    pub fn set(&self, range: Range, held: Option<&RangeInclusive<i32>>, params: &mut Params) -> Result<Option<String>> {
        let Range::Found { min_is_given } = range else { return Ok(None) };
        let given = params.min_disparity;
        self.search.found(&self.map, params)?;
        let (mut first, mut last) = params.searched().into_inner();
        // Those that were found lie at least so far within the range.
        let margin = (last - first) / 32 + self.search.factor() as i32 / 2 + 1;
        if let Some(held) = held {
            let (least, most) = (*held.start(), *held.end());
            first = if (least - margin..least).contains(&first) { least.min(last) } else { first };
            last = if (most + 1..=most + margin).contains(&last) { most.max(first) } else { last };
        }
        if min_is_given {
            ensure!(
                given <= last,
                "--min-disp is {given}, but the disparities end at {last}; give a smaller one, or none"
            );
            first = given;
        }
        let mut count = (last - first + 1) as u32;
        if params.network.is_some() {
            // Networks search from 0 on, as many as a multiple of 16.
            first = if min_is_given { first } else { 0 };
            count = (last.max(0) as u32 + 1).next_multiple_of(16);
        }
        (params.min_disparity, params.disparities) = (first, count);
        params.validate().map_err(args::by_option)?;
        Ok((last < 0)
            .then(|| "all disparities are negative, as if LEFT and RIGHT were exchanged; exchange them".into()))
    }
}

/// The first and the last disparity that settings search.
pub fn ends(params: &Params) -> [i32; 2] {
    params.searched().into_inner().into()
}

/// The range that holds both.
pub fn joined(one: [i32; 2], other: [i32; 2]) -> [i32; 2] {
    [one[0].min(other[0]), one[1].max(other[1])]
}
