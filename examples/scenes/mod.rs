//! Random scenes: what stands in them, what it looks like, how cameras see it.

mod camera;
mod chance;
mod layout;
mod material;
mod solid;

pub use camera::{Picture, Side, View};
pub use chance::Chance;
pub use layout::random_scene;
