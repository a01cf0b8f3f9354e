//! What a user may ask for, and the checks that come before anything touches a device.

mod camera;
mod lens;
mod masks;
mod options;
mod parameters;
mod rectification;

pub use camera::Camera;
pub use lens::{Distortion, Lens};
pub use masks::Masks;
#[cfg(test)]
pub(crate) use options::Named;
pub use options::ParamOption;
pub use parameters::{
    Census, Cost, Fill, Median, Method, Params, Paths, Prefilter, Preset, RightView, Schedule, Subpixel, Wls,
};
pub use rectification::Rectification;
