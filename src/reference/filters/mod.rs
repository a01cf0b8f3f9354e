//! Filters of the map, and what is made of it.

pub(crate) mod confidence;
pub(crate) mod depth;
pub(crate) mod fill;
pub(crate) mod filtered;
pub(crate) mod lr_check;
pub(crate) mod median;
pub(crate) mod speckle;
pub(crate) mod texture;
pub(crate) mod validity;
pub(crate) mod weighted_median;
pub(crate) mod wls;
