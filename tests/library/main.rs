//! The library as its users meet it, and each of its schedules beside the definition. One program for all, since each links
//! the drivers' interfaces once more: `cargo test --test library exactness::` runs one file, `.. exactness::bands` one test.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[cfg(not(all(feature = "cpu", feature = "files", feature = "gpu")))]
compile_error!(
    "the tests need the features cpu, files and gpu: run `cargo test` in the repository's root without -p and without features"
);

mod algorithms;
mod api;
mod callers;
mod covering;
mod embedding;
mod errors;
mod exactness;
mod features;
mod misuse;
mod network;
mod portability;
mod properties;
mod serialised;
mod stream;
#[path = "../support/mod.rs"]
mod support;
mod validity;
mod vectors;
mod views;
