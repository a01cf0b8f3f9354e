//! Filters of the map, and what is made of it.

mod fill;
pub(super) mod filtered;
mod map_step;
mod speckle;
mod wls;
