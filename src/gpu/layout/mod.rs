//! How buffers are laid out.

mod bands;
mod features;
mod layers;
mod request;
mod rows;
mod scales;
mod sizes;
mod uniforms;

pub(crate) use bands::{PAIR_BUFFERS, Piece};
pub(crate) use features::{feature_inputs, feature_rows, feature_vectors, packed_features};
pub(crate) use layers::{BLOCK_UNIT, Layers, Place, packed, weight_places};
pub(crate) use request::{ROW_UNIT, source_layout};
#[cfg(test)]
pub(crate) use rows::cut_to;
pub(crate) use rows::{Rows, cut};
pub(crate) use scales::{Scale, WAYS};
pub(crate) use sizes::Sizes;
#[cfg(test)]
pub(crate) use uniforms::Own;
pub(crate) use uniforms::{
    BeliefOwn, CoarseOwn, Dispatch, FeatureOwn, FillOwn, Frame, GrayOwn, HistogramOwn, ImageOwn, IntakeOwn, LayerOwn,
    NO_OWN, PathOwn, PlaneOwn, RoundOwn, SmoothOwn, StartOwn, StatisticsOwn, TEXELS, TEXTURE_ROW, ValidityOwn,
    WindowOwn,
};
