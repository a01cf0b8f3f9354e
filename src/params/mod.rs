//! What a user may ask for, and the checks that come before anything touches a device.

mod camera;
mod check;
mod choices;
mod costs;
mod derived;
mod filters;
mod lens;
mod masks;
mod names;
mod options;
#[allow(clippy::module_inception)] // the settings themselves
mod params;
mod presets;
mod rectification;
mod validate;
#[cfg(feature = "serde")]
mod with_serde;

pub use camera::Camera;
pub use choices::{
    Census, Fill, Median, Method, Paths, Prefilter, Preset, RightView, Schedule, Smoothness, Subpixel, Wls,
};
pub use costs::Cost;
pub(crate) use costs::Descriptor;
pub(crate) use filters::{Filter, Steps};
pub use lens::{Distortion, Lens};
pub use masks::Masks;
#[cfg(test)]
pub(crate) use names::Named;
pub use options::ParamOption;
pub use params::Params;
pub use rectification::Rectification;
