//! Filters of the map that the reference computes too slowly. The others are the reference's.

mod fill;
mod lr_check;
mod median;
mod speckle;
#[cfg(test)]
mod tests;
mod weighted_median;

use crate::cpu::instructions::Instructions;
use crate::params::Filter;
use crate::reference::{self, Plane};
use crate::{DisparityMap, Params};

/// The map that a filter makes of `map`. `None` if the settings do not ask for the filter.
pub(super) fn filtered(
    filter: Filter,
    map: &DisparityMap,
    right: &DisparityMap,
    luma: &Plane<u8>,
    params: &Params,
    instructions: Instructions,
) -> Option<DisparityMap> {
    filter.wanted(params).then_some(())?;
    Some(match filter {
        Filter::LrCheck => lr_check::lr_check(map, right, params.lr_check?),
        Filter::Speckle => speckle::speckle(map, params.speckle_window, params.speckle_range),
        Filter::Median => median::median(map, params.median.side()?, instructions),
        Filter::Fill => fill::fill(map, right, luma, params),
        Filter::WeightedMedian => {
            weighted_median::weighted_median(map, luma, params.weighted_median?, params, instructions)
        }
        Filter::Texture | Filter::Wls => return reference::filtered(filter, map, right, luma, params),
    })
}
