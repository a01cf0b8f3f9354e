//! What the command does: a file for each verb, in which its arguments are resolved, run and reported.

pub mod adapters;
pub mod batch;
pub mod bench;
pub mod calib;
mod energy;
pub mod eval;
mod network;
mod outcome;
pub mod single;
pub mod study;
mod summary;
mod variants;
pub mod video;
pub mod weights;

pub use outcome::Outcome;
