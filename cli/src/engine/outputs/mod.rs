//! Outputs: the files that options ask for, where they are written, and how it is known later that they are as they were.

pub mod files;
pub mod known;
pub mod places;
