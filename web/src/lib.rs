//! The library for JavaScript: what web/npm/index.js wraps and the web page uses.
//!
//! Settings come as pairs of names and values, such as `["preset", "dense", "p2", "80"]`: those of the command's options
//! without dashes. Images come as bytes, row by row from the top, without padding. Every function throws an `Error` whose `kind` tells
//! what is wrong ([`thrown`](throw::thrown)).

#[cfg(target_arch = "wasm32")]
mod device;
#[cfg(target_arch = "wasm32")]
mod maps;
#[cfg(target_arch = "wasm32")]
mod matcher;
#[cfg(target_arch = "wasm32")]
mod objects;
#[cfg(target_arch = "wasm32")]
mod settings;
#[cfg(target_arch = "wasm32")]
mod textures;
#[cfg(target_arch = "wasm32")]
mod throw;
