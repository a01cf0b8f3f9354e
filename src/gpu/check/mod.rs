//! The comparison of every stage's buffer with the reference.

mod compare;
mod expected;
mod features;
mod network;
mod run;
