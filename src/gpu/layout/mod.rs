//! How buffers are laid out.

mod bands;
mod request;
mod sizes;
mod uniforms;

pub(crate) use bands::{PAIR_BUFFERS, Piece, Rows, cut};
pub(crate) use request::{ROW_UNIT, source_layout};
pub(crate) use sizes::Sizes;
pub(crate) use uniforms::{Frame, Pass, TEXELS, TEXTURE_ROW};
