//! What is understood of a calibration.

use gpu_stereo::files::calibration::{Description, Fitted};

/// A calibration, and what it is for images of a size.
pub struct Understood {
    /// What it says.
    pub description: Description,
    /// Whether the pairs must be rectified.
    pub lenses: bool,
    /// Columns and rows of the images, and the rectified cameras, where the size is known.
    pub fitted: Option<([u32; 2], Fitted)>,
    /// What is doubtful or missing.
    pub notes: Vec<String>,
}
