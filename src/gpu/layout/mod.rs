//! How buffers are laid out.

mod bands;
mod request;
mod sizes;
mod uniforms;

pub(crate) use bands::{PAIR_BUFFERS, Piece, Rows, cut};
pub(crate) use request::{ROW_UNIT, source_layout};
pub(crate) use sizes::Sizes;
#[cfg(test)]
pub(crate) use uniforms::Own;
pub(crate) use uniforms::{
    Dispatch, FillOwn, Frame, GrayOwn, HistogramOwn, NO_OWN, PathOwn, PlaneOwn, SmoothOwn, TEXELS, TEXTURE_ROW,
    ValidityOwn, WindowOwn,
};
