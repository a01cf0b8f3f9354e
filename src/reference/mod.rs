//! The definition: every stage in the plainest Rust that states its formula, without a device.
//!
//! The shaders are the schedule of this definition and equal it to the bit; docs/ALGORITHMS.md says the same in words.
//! A network ([`network()`]) is defined in doubles; only what follows its disparities is equal to the bit. Work is spread over
//! rows by rayon, which changes no result. The stages take parameters that [`Params::validate`](crate::Params::validate)
//! accepts, and each other's results: neither is checked again.
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

mod beliefs;
mod chain;
mod channels;
mod cost;
mod energy;
mod features;
mod filters;
mod images;
mod needs;
mod network;
mod paths;
mod plane;
mod stages;
mod trace;
mod winner;

pub use beliefs::coarse_cost::{LARGEST_TERM, coarse_cost};
pub use beliefs::messages::{Messages, beliefs, messages, shares};
#[cfg(feature = "cpu")]
pub(crate) use chain::follow;
pub use chain::{compute, compute_all, compute_timed, compute_traced};
pub use channels::{Images, images};
pub use cost::cost_columns::{cost_columns, pixel_cost};
pub use cost::descriptors::descriptors;
pub use cost::matching_cost::{matching_cost, matching_cost_scale};
pub use cost::mi_histogram::mi_histogram;
pub use cost::mi_table::{logarithm, mi_narrowing, mi_prior, mi_table};
pub use energy::energy;
pub use features::feature_layer::{FeatureValues, feature_layer};
pub use features::feature_statistics::{FeatureStatistics, feature_input, feature_statistics};
pub use features::features::{feature_values, features, features_of};
pub use filters::*;
pub use images::gray::{Channel, deep_gray, depth_unit, gray};
pub use images::halve::{Round, halve, rounds};
pub(crate) use images::halve::{halved, largest_with_fewer_rounds};
pub use images::prefilter::prefilter;
pub use images::rectify::rectify;
pub use images::window_sums::window_sum;
pub use needs::ensure_memory;
pub(crate) use network::{Report, stage};
pub use network::{
    Values, average_pool, conv3d_transposed, convolution, cropped, disparity_regression, feature_volume, neighbours,
    network, network_input, operation, round_disparities, upsample,
};
pub use paths::penalties::penalties;
pub use paths::second_cost::second_cost;
pub use paths::sgm_aggregate::{Direction, aggregate_direction, sgm_aggregate};
pub use plane::{Descriptors, Plane, Volume};
#[cfg(feature = "cpu")]
pub use stages::cost_table;
pub(crate) use stages::{Stages, views_of};
#[cfg(feature = "cpu")]
pub(crate) use trace::{Bytes, Part, Trace};
pub use winner::block_match::{block_match, block_sums};
pub use winner::block_statistics::{BlockStatistics, block_statistics};
pub use winner::mirror::{mirror, mirrored};
#[cfg(test)]
pub(crate) use winner::winner::winner_of_row;
pub use winner::winner::{Views, points_inside, winner};
