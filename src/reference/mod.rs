//! The definition: every stage in the plainest Rust that states its formula, without a device.
//!
//! The shaders are the schedule of this definition and equal it to the bit; docs/ALGORITHMS.md says the same in words.
//! Work is spread over rows by rayon, which changes no result. The stages take parameters that [`Params::validate`]
//! accepts, and each other's results: they check neither again.
//!
//! [`compute`], [`compute_all`], [`compute_timed`] and [`compute_traced`] follow semantic versioning as the rest of the
//! crate does. The functions of single stages and their types follow the definition: they may change in any release, and
//! are here to be read, and to be compared with.
//!
//! ```
//! use gpu_stereo::{Image, Params, Pixels, reference};
//!
//! let texture = |x: u32, y: u32| (x * x * 31 + x * y * 17 + y * 7) as u8;
//! let view = |shift| (0..32 * 8).map(|i| texture(i % 32 + shift, i / 32)).collect();
//! let left = Image::new(32, 8, Pixels::Gray8(view(0)))?;
//! let right = Image::new(32, 8, Pixels::Gray8(view(3)))?; // shows 3 pixels to the left what the left image shows
//! let map = reference::compute(&left, &right, &Params::sgm(16))?;
//! assert_eq!(map.get(20, 4), Some(3.0));
//! # Ok::<(), gpu_stereo::Error>(())
//! ```

mod cost;
mod filters;
mod images;
mod paths;
mod trace;
mod winner;

pub use cost::cost_columns::{cost_columns, pixel_cost};
pub use cost::features::{Features, features};
pub use cost::matching_cost::{matching_cost, matching_cost_scale};
pub use cost::mi_histogram::mi_histogram;
pub use cost::mi_table::{logarithm, mi_narrowing, mi_prior, mi_table};
pub use filters::confidence::{confidence, margin};
pub use filters::depth::depth;
pub use filters::fill::fill;
pub use filters::lr_check::lr_check;
pub use filters::median::median;
pub use filters::speckle::speckle;
pub use filters::texture::texture;
pub use filters::validity::{Content, validity};
pub(crate) use filters::weighted_median::{median_decay, median_spacing};
pub use filters::weighted_median::{median_weight, weighted_median};
pub(crate) use filters::wls::wls_bits;
pub use filters::wls::{wls, wls_couplings};
pub use images::gray::{Channel, deep_gray, depth_unit, gray};
pub(crate) use images::halve::largest_with_fewer_rounds;
pub use images::halve::{Round, halve, rounds};
pub use images::prefilter::prefilter;
pub use images::rectify::rectify;
pub use images::window_sums::window_sum;
pub use paths::penalties::penalties;
pub use paths::sgm_aggregate::{Direction, aggregate_direction, sgm_aggregate};
pub use winner::block_match::{block_match, block_sums};
pub use winner::block_statistics::{BlockStatistics, block_statistics};
pub use winner::mirror::{mirror, mirrored};
pub use winner::winner::{Views, points_inside, winner};

use rayon::prelude::*;
use trace::{Receiver, Trace};

use crate::{Cost, DisparityMap, Error, Fill, Image, Matched, Method, Params, Prefilter, StageTime};

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
    Ok(compute_all(left, right, params)?.map)
}

/// As [`compute`], with all else that the settings ask for.
///
/// # Errors
/// As [`compute`].
pub fn compute_all(left: &Image, right: &Image, params: &Params) -> Result<Matched, Error> {
    Ok(compute_timed(left, right, params)?.0)
}

/// As [`compute_all`], with the time of each stage.
///
/// # Errors
/// As [`compute`].
pub fn compute_timed(left: &Image, right: &Image, params: &Params) -> Result<(Matched, Vec<StageTime>), Error> {
    follow(left, right, params, None)
}

/// As [`compute_all`], and calls `receive` with the name and the bytes of the result of each stage, in the order in which
/// they are computed: a second match and each round of [`rounds`] repeat the names of their stages. docs/VECTORS.md
/// describes the bytes of each stage.
///
/// ```
/// use gpu_stereo::{Image, Params, Pixels, reference};
///
/// let image = Image::new(32, 8, Pixels::Gray8((0..=255).collect()))?;
/// let mut stages = Vec::new();
/// let mut receive = |stage: &str, bytes: &[u8]| stages.push((stage.to_string(), bytes.len()));
/// reference::compute_traced(&image, &image, &Params::sgm(16), &mut receive)?;
/// assert!(stages.contains(&("matching_cost".into(), 32 * 8 * 16)));
/// # Ok::<(), gpu_stereo::Error>(())
/// ```
///
/// # Errors
/// As [`compute`].
pub fn compute_traced(
    left: &Image,
    right: &Image,
    params: &Params,
    receive: &mut dyn FnMut(&str, &[u8]),
) -> Result<Matched, Error> {
    Ok(follow(left, right, params, Some(receive))?.0)
}

/// The whole chain.
fn follow(
    left: &Image,
    right: &Image,
    params: &Params,
    receiver: Option<Receiver<'_>>,
) -> Result<(Matched, Vec<StageTime>), Error> {
    params.validate()?;
    crate::gpu::matcher::check_pair(left, right)?;
    params.accepts(left.width(), left.height())?;
    let content = Content::new(params, left.width(), left.height());
    let content = content.as_ref();
    let mut trace = Trace::new(receiver);
    let rectified = match &params.rectify {
        Some(rectification) => {
            let pair = [rectify(left, rectification, 0)?, rectify(right, rectification, 1)?];
            Some(trace.stage("rectify", pair))
        }
        None => None,
    };
    if let Some(content) = content {
        trace.show("content", || content);
    }
    let [left, right] = rectified.as_ref().map_or([left, right], |[left, right]| [left, right]);
    let matched = match params.second_match() {
        Some(second) => {
            let content = content.map(Content::mirrored);
            let [left, right] = [mirrored(right)?, mirrored(left)?];
            let luma = gray(&left, Channel::Luma);
            Some(views(&left, &right, &luma, content.as_ref(), &second, &mut trace).left)
        }
        None => None,
    };
    let luma = gray(left, Channel::Luma);
    let Views { left, mut right, margins } = views(left, right, &luma, content, params, &mut trace);
    if let Some(matched) = matched {
        right = trace.stage("mirror", mirror(&matched));
    }
    if params.reads_right_view() {
        right = trace.valid(right, content, 1);
    }
    let mut map = trace.valid(left, content, 0);
    if params.texture > 0 {
        map = trace.stage("texture", texture(&map, &luma, params));
    }
    if let Some(max_difference) = params.lr_check {
        map = trace.stage("lr_check", lr_check(&map, &right, max_difference));
    }
    if params.speckle_window > 0 {
        map = trace.stage("speckle", speckle(&map, params.speckle_window, params.speckle_range));
    }
    if let Some(side) = params.median.side() {
        map = trace.stage("median", median(&map, side));
        map = trace.valid(map, content, 0);
    }
    if params.fill != Fill::None {
        map = trace.stage("fill", fill(&map, &right, params));
        map = trace.valid(map, content, 0);
    }
    if let Some(radius) = params.weighted_median {
        map = trace.stage("weighted_median", weighted_median(&map, &luma, radius, params));
        map = trace.valid(map, content, 0);
    }
    if let Some(settings) = &params.wls {
        map = trace.stage("wls", wls(&map, &luma, settings, params));
        map = trace.valid(map, content, 0);
    }
    let confidence = params.confidence.then(|| trace.stage("confidence", confidence(&map, &margins)));
    let depth = params.depth.as_ref().map(|camera| trace.stage("depth", depth(&map, camera)));
    Ok((Matched { map, right: params.right_map.then_some(right), confidence, depth }, trace.times))
}

/// From the images, of which `luma` is that of the left one, to the winner of both views.
fn views(
    left: &Image,
    right: &Image,
    luma: &Plane<u8>,
    content: Option<&Content>,
    params: &Params,
    trace: &mut Trace<'_>,
) -> Views {
    let adaptive = params.adaptive_p2 && params.method == Method::Sgm;
    let ([left, right], _) = trace.stage("gray", ([left, right].map(|image| images(image, params)), luma));
    let penalties = adaptive.then(|| trace.stage("penalties", penalties(luma, params)));
    if params.prefilter == Prefilter::Normalized {
        trace.show("window_sums", || [&left, &right].map(|images| images.window_sums(params.prefilter_window)));
    }
    let [left, right] = trace.stage("prefilter", [left.prefiltered(params), right.prefiltered(params)]);
    if params.cost == Cost::ZeroMeanSad {
        trace.show("window_sums", || [&left, &right].map(|images| images.window_sums(params.block)));
    }
    let sides = trace.stage("features", [left.features(params), right.features(params)]);
    let table = trace.table(&sides, content, params);
    trace.winner(&sides, &table, penalties.as_ref(), params)
}

/// What matches cost in the last round of [`rounds`], for a cost that has a table; else nothing. `content`: where the pair
/// has it, `None` for everywhere.
pub fn cost_table(sides: &[Features; 2], content: Option<&Content>, params: &Params) -> Vec<u8> {
    Trace::new(None).table(sides, content, params)
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

    /// The sums over windows of `side` x `side` pixels of all of them.
    pub fn window_sums(&self, side: u32) -> Vec<Plane<u32>> {
        self.channels.iter().map(|image| image.map(|x, y| window_sum(image, side, x, y) as u32)).collect()
    }

    /// What the cost compares of them.
    pub fn features(&self, params: &Params) -> Features {
        features(&self.channels, self.unit, params)
    }
}

impl Trace<'_> {
    /// [`cost_table`].
    fn table(&mut self, sides: &[Features; 2], content: Option<&Content>, params: &Params) -> Vec<u8> {
        if params.cost != Cost::MutualInformation {
            return Vec::new();
        }
        let rounds = rounds(sides[0].width as u32, sides[0].height as u32, params);
        let mut pyramid = vec![sides.clone()];
        for _ in 0..rounds[0].halvings {
            let halved = pyramid[pyramid.len() - 1].each_ref().map(halve);
            pyramid.push(self.stage("halve", halved));
        }
        let mut table = self.round(&pyramid[rounds[0].halvings as usize], None, 0);
        for (before, here) in rounds.iter().zip(&rounds[1..]) {
            let views = self.winner(&pyramid[before.halvings as usize], &table, None, &before.params);
            let content = content.map(|content| content.halved(before.halvings));
            let right = self.valid(views.right, content.as_ref(), 1);
            let mut map = self.valid(views.left, content.as_ref(), 0);
            if let Some(max_difference) = before.params.lr_check {
                map = self.stage("lr_check", lr_check(&map, &right, max_difference));
            }
            table = self.round(&pyramid[here.halvings as usize], Some(&map), before.halvings - here.halvings);
        }
        table
    }

    /// The table of a round, by the map of the round before.
    fn round(&mut self, [left, right]: &[Features; 2], map: Option<&DisparityMap>, halvings: u32) -> Vec<u8> {
        let counts = self.stage("mi_histogram", mi_histogram(left, right, map, halvings));
        self.stage("mi_table", mi_table(&counts, (left.width * left.height) as u64))
    }

    /// From what the cost compares to the winner of both views.
    fn winner(
        &mut self,
        [left, right]: &[Features; 2],
        table: &[u8],
        penalties: Option<&Volume<u8>>,
        params: &Params,
    ) -> Views {
        let columns = self.stage("cost_columns", cost_columns(left, right, table, params));
        self.show("block_sums", || (0..columns.height).map(|y| block_sums(&columns, y, params)).collect::<Vec<_>>());
        match params.method {
            Method::Bm => {
                let correlates = params.cost == Cost::Ncc;
                let statistics =
                    correlates.then(|| self.stage("block_statistics", block_statistics(left, right, params)));
                self.stage("block_match", block_match(&columns, statistics.as_ref(), params))
            }
            Method::Sgm => {
                let cost = self.stage("matching_cost", matching_cost(&columns, params));
                drop(columns);
                let sum = self.stage("sgm_aggregate", sgm_aggregate(&cost, penalties, params));
                self.stage("winner", winner(&sum, params))
            }
        }
    }

    /// Stage `validity`, where not all pixels have content.
    fn valid(&mut self, map: DisparityMap, content: Option<&Content>, side: usize) -> DisparityMap {
        match content {
            Some(content) => self.stage("validity", validity(&map, content, side)),
            None => map,
        }
    }
}
