//! What each filter of the table computes.

use crate::DisparityMap;
use crate::params::{Filter, Params};
use crate::reference::{Plane, fill, lr_check, median, speckle, texture, weighted_median, wls};

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
        Filter::Fill => fill(map, right, params),
        Filter::WeightedMedian => weighted_median(map, luma, params.weighted_median?, params),
        Filter::Wls => wls(map, luma, params.wls.as_ref()?, params),
    })
}
