//! Calibration files become the cameras of a pair: the structure of a file shows its kind, and its numbers are fitted to the
//! images.
//!
//! ```no_run
//! use gpu_stereo::files::calibration::{Calibration, Reading};
//!
//! let calibration = Calibration::read("calib.txt".as_ref(), None, Reading::default())?;
//! let camera = calibration.fit(1280, 720)?.camera;
//! # Ok::<(), gpu_stereo::files::Error>(())
//! ```

mod algebra;
mod apart;
mod cameras;
mod content;
mod describe;
mod fit;
mod kinds;
mod lenses;
mod read;
mod reading;
mod rectified;
mod rectifying;
mod rig;
mod scale;
#[cfg(test)]
mod tests;

pub use cameras::Calibration;
pub use describe::{DescribedCamera, Description, turn_of};
pub use fit::Fitted;
pub use kinds::Source;
pub use lenses::LensModel;
pub use reading::{KittiPair, Reading, Unit};
pub use scale::Scale;
