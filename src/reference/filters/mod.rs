//! Filters of the map, and what is made of it.

mod confidence;
mod depth;
mod fill;
mod lr_check;
mod median;
mod speckle;
mod texture;
mod validity;
mod weighted_median;
mod wls;

pub use confidence::{confidence, margin};
pub use depth::depth;
pub use fill::fill;
pub use lr_check::lr_check;
pub use median::median;
pub use speckle::speckle;
pub use texture::texture;
pub use validity::{Content, validity};
pub(crate) use weighted_median::{median_decay, median_spacing, weighted_middle};
pub use weighted_median::{median_weight, weighted_median};
pub(crate) use wls::wls_bits;
pub use wls::{wls, wls_couplings};

use crate::DisparityMap;
use crate::params::{Filter, Params};
use crate::reference::Plane;

/// The map that a filter makes of `map`; `right` is the right view, `luma` that of the left image. `None` if the settings do
/// not ask for the filter.
pub(crate) fn filtered(
    filter: Filter,
    map: &DisparityMap,
    right: &DisparityMap,
    luma: &Plane<u8>,
    params: &Params,
) -> Option<DisparityMap> {
    filter.wanted(params).then_some(())?;
    Some(match filter {
        Filter::Texture => texture(map, luma, params),
        Filter::LrCheck => lr_check(map, right, params.lr_check?),
        Filter::Speckle => speckle(map, params.speckle_window, params.speckle_range),
        Filter::Median => median(map, params.median.side()?),
        Filter::Fill => fill(map, right, luma, params),
        Filter::WeightedMedian => weighted_median(map, luma, params.weighted_median?, params),
        Filter::Wls => wls(map, luma, params.wls.as_ref()?, params),
    })
}
