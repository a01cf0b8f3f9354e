//! The definition: every stage in the plainest Rust that states its formula, without a device.
//!
//! The shaders are the schedule of this definition and equal it to the bit; docs/ALGORITHMS.md says the same in words.
//! Work is spread over rows by rayon, which changes no result. The stages take parameters that [`Params::validate`]
//! accepts, and each other's results: they check neither again.

mod block_match;
mod cost_columns;
mod features;
mod gray;
mod halve;
mod lr_check;
mod matching_cost;
mod median;
mod mi_histogram;
mod mi_table;
mod prefilter;
mod sgm_aggregate;
mod window_sums;
mod winner;

pub use block_match::{block_match, block_sums};
pub use cost_columns::{cost_columns, pixel_cost};
pub use features::{Features, features};
pub use gray::{Channel, deep_gray, depth_unit, gray};
pub use halve::{Round, halve, rounds};
pub use lr_check::lr_check;
pub use matching_cost::{matching_cost, matching_cost_scale};
pub use median::median;
pub use mi_histogram::mi_histogram;
pub use mi_table::{logarithm, mi_narrowing, mi_prior, mi_table};
pub use prefilter::prefilter;
pub use sgm_aggregate::{Direction, aggregate_direction, sgm_aggregate};
pub use window_sums::window_sum;
pub use winner::{Views, points_inside, winner};

use rayon::prelude::*;
use std::time::Instant;

use crate::{Cost, DisparityMap, Error, Image, Median, Method, Params, Prefilter, StageTime};

/// An image, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plane<T> {
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `data[y * width + x]`.
    pub data: Vec<T>,
}

impl<T: Copy + Into<i32> + Sync> Plane<T> {
    /// The pixel nearest to (x, y) that lies in the image: the image is continued by its border.
    pub fn clamped(&self, x: i64, y: i64) -> i32 {
        let x = x.clamp(0, self.width as i64 - 1) as usize;
        let y = y.clamp(0, self.height as i64 - 1) as usize;
        self.data[y * self.width + x].into()
    }

    /// An image of the same size, from a function of x and y.
    pub fn map<U: Send>(&self, value: impl Fn(i64, i64) -> U + Sync) -> Plane<U> {
        let pixel = |i: usize| value((i % self.width) as i64, (i / self.width) as i64);
        let data = (0..self.data.len()).into_par_iter().with_min_len(1 << 12).map(pixel).collect();
        Plane { width: self.width, height: self.height, data }
    }
}

/// A value for each pixel and disparity: `data[(y * width + x) * disparities + d]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Volume<T> {
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Disparities a pixel; index d stands for the disparity `min_disparity + d`.
    pub disparities: usize,
    /// The values, disparity fastest.
    pub data: Vec<T>,
}

impl<T: Copy + Default> Volume<T> {
    /// A volume of zeros.
    pub fn new(width: usize, height: usize, disparities: usize) -> Self {
        Self { width, height, disparities, data: vec![T::default(); width * height * disparities] }
    }

    /// Values a row of the image.
    pub fn row_len(&self) -> usize {
        self.width * self.disparities
    }
}

/// The whole chain on the CPU: what [`crate::StereoMatcher`] computes, from the definition.
///
/// # Errors
/// As [`Params::validate`], and [`Error::Image`] if the two sizes differ.
pub fn compute(left: &Image, right: &Image, params: &Params) -> Result<DisparityMap, Error> {
    Ok(compute_timed(left, right, params)?.0)
}

/// As [`compute`], with the time of each stage.
///
/// # Errors
/// As [`compute`].
pub fn compute_timed(left: &Image, right: &Image, params: &Params) -> Result<(DisparityMap, Vec<StageTime>), Error> {
    params.validate()?;
    crate::matcher::check_pair(left, right)?;
    let (width, height) = (left.width(), left.height());
    let mut clock = Clock { last: Instant::now(), times: Vec::new() };
    let (left, right) = clock.stage("gray", (images(left, params), images(right, params)));
    let (left, right) = clock.stage("prefilter", (left.prefiltered(params), right.prefiltered(params)));
    let mut pyramid = vec![clock.stage("features", (left.features(params), right.features(params)))];
    let rounds = rounds(width, height, params);
    for _ in 0..rounds[0].halvings {
        let (left, right) = &pyramid[pyramid.len() - 1];
        let halved = (halve(left), halve(right));
        pyramid.push(clock.stage("halve", halved));
    }
    let mut before: Option<(DisparityMap, u32)> = None;
    for Round { halvings, params } in &rounds {
        let (left, right) = &pyramid[*halvings as usize];
        let mut table = Vec::new();
        if params.cost == Cost::MutualInformation {
            let (map, halved) = match &before {
                Some((map, before)) => (Some(map), before - halvings),
                None => (None, 0),
            };
            let counts = clock.stage("mi_histogram", mi_histogram(left, right, map, halved));
            table = clock.stage("mi_table", mi_table(&counts, (left.width * left.height) as u64));
        }
        before = Some((matched(left, right, &table, params, &mut clock), *halvings));
    }
    let map = before.map_or_else(|| DisparityMap { width: 0, height: 0, data: Vec::new() }, |(map, _)| map);
    Ok((map, clock.times))
}

/// The map of a round, from the features that the cost compares, with the table of [`mi_table`] for the costs that have one.
fn matched(left: &Features, right: &Features, table: &[u8], params: &Params, clock: &mut Clock) -> DisparityMap {
    let columns = clock.stage("cost_columns", cost_columns(left, right, table, params));
    let Views { left, right } = match params.method {
        Method::Bm => clock.stage("block_match", block_match(&columns, params)),
        Method::Sgm => {
            let cost = clock.stage("matching_cost", matching_cost(&columns, params));
            drop(columns);
            let sum = clock.stage("sgm_aggregate", sgm_aggregate(&cost, params));
            clock.stage("winner", winner(&sum, params))
        }
    };
    let mut map = left;
    if let Some(max_difference) = params.lr_check {
        map = clock.stage("lr_check", lr_check(&map, &right, max_difference));
    }
    if params.median == Median::Three {
        map = clock.stage("median", median(&map));
    }
    map
}

/// An image as the chain takes it: luma, or with [`Params::color_cost`] red, green and blue.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Images {
    /// One, or three of one size.
    pub channels: Vec<Plane<u16>>,
    /// How much of a value stands for one of 256 levels.
    pub unit: i32,
}

/// The images that are prefiltered.
pub fn images(image: &Image, params: &Params) -> Images {
    let channels = match params.color_cost {
        true => [0, 1, 2].map(|sample| deep_gray(image, Channel::Sample(sample))).into(),
        false => vec![deep_gray(image, Channel::Luma)],
    };
    Images { channels, unit: depth_unit(image) }
}

impl Images {
    /// All of them prefiltered.
    pub fn prefiltered(&self, params: &Params) -> Self {
        let unit = if params.prefilter == Prefilter::None { self.unit } else { 1 };
        Self { channels: self.channels.iter().map(|image| prefilter(image, self.unit, params)).collect(), unit }
    }

    /// What the cost compares of them.
    pub fn features(&self, params: &Params) -> Features {
        features(&self.channels, self.unit, params)
    }
}

/// Takes the time from stage to stage.
struct Clock {
    last: Instant,
    times: Vec<StageTime>,
}

impl Clock {
    /// Notes the time since the stage before, in which `result` was computed.
    fn stage<T>(&mut self, name: &str, result: T) -> T {
        let now = Instant::now();
        let ms = now.duration_since(self.last).as_secs_f64() * 1e3;
        self.times.push(StageTime { name: name.into(), ms });
        self.last = now;
        result
    }
}
