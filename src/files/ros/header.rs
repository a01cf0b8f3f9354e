//! The header that messages begin with.

/// When and in which frame of coordinates a message was taken.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Header {
    /// Seconds and nanoseconds.
    pub stamp: (i32, u32),
    /// The name of the frame.
    pub frame: String,
}

impl Header {
    /// Nanoseconds since the epoch of the stamps.
    #[must_use]
    pub fn nanoseconds(&self) -> i64 {
        i64::from(self.stamp.0) * 1_000_000_000 + i64::from(self.stamp.1)
    }
}
