//! The library for JavaScript: what web/npm/index.js wraps and the web page uses.
//!
//! It is built twice: with the feature `gpu` for devices, and with `cpu` for the CPU; each has all but the other's matcher.
//!
//! Settings come as pairs of names and values, such as `["preset", "dense", "p2", "80"]`: those of the command's options
//! without dashes. Images come as bytes, row by row from the top, without padding. Every function throws an `Error` whose `kind` tells
//! what is wrong ([`thrown`](throw::thrown)).

#[cfg(all(feature = "cpu", target_arch = "wasm32"))]
mod cpu_matcher;
#[cfg(all(feature = "gpu", target_arch = "wasm32"))]
mod device;
#[cfg(all(feature = "gpu", target_arch = "wasm32"))]
mod gpu_matcher;
#[cfg(target_arch = "wasm32")]
mod maps;
#[cfg(target_arch = "wasm32")]
mod objects;
#[cfg(target_arch = "wasm32")]
mod settings;
#[cfg(all(any(feature = "cpu", feature = "gpu"), target_arch = "wasm32"))]
mod stages;
#[cfg(all(feature = "gpu", target_arch = "wasm32"))]
mod textures;
#[cfg(target_arch = "wasm32")]
mod throw;
