//! The comparison of every stage's buffer with the reference.

mod compare;
mod expected;
mod network;
mod run;
