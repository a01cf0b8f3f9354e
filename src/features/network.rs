//! A list of layers that fit each other.

use std::fmt;
use std::sync::Arc;

use crate::Error;
use crate::features::layer::{Layer, LayerKind, refused};

/// A network that makes features of an image, for [`crate::Params::features`]. A clone shares its layers.
#[derive(Clone)]
pub struct FeatureNetwork(Arc<[Layer]>);

impl PartialEq for FeatureNetwork {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.0 == other.0
    }
}

impl fmt::Debug for FeatureNetwork {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (layers, channels) = (self.0.len(), self.channels());
        f.debug_struct("FeatureNetwork").field("layers", &layers).field("channels", &channels).finish_non_exhaustive()
    }
}

impl FeatureNetwork {
    /// The most layers.
    pub const MAX_LAYERS: usize = 16;
    /// The most channels of a layer.
    pub const MAX_CHANNELS: usize = 128;
    /// The fewest features of a pixel.
    pub const MIN_FEATURES: usize = 8;

    /// Of layers from the image to the features: first a convolution of one channel, last one without relu, of 8 to 128 channels. All
    /// channels but the image's are a multiple of 4, at most 128.
    ///
    /// # Errors
    /// [`Error::Network`] if layers do not fit each other or might overflow.
    pub fn new(layers: Vec<Layer>) -> Result<Self, Error> {
        if !(1..=Self::MAX_LAYERS).contains(&layers.len()) {
            return Err(Error::Network(format!(
                "a network of features has {} layers, but must have 1 to {}; give others",
                layers.len(),
                Self::MAX_LAYERS
            )));
        }
        let mut before = 1;
        for (at, layer) in layers.iter().enumerate() {
            let Layer { kind, inputs, outputs, .. } = *layer;
            if at == 0 && kind != LayerKind::Convolution {
                return Err(refused(at, "is", kind, "convolution", "begin with a convolution of the image"));
            }
            if inputs != before {
                let wanted = format!("{before}, those of the layer before");
                return Err(refused(at, "reads channels:", inputs, &wanted, "give layers that fit each other"));
            }
            if outputs % 4 != 0 || !(4..=Self::MAX_CHANNELS).contains(&outputs) {
                let allowed = format!("a multiple of 4 up to {}", Self::MAX_CHANNELS);
                return Err(refused(at, "makes channels:", outputs, &allowed, "fill them up with zeros"));
            }
            if kind == LayerKind::Depthwise && inputs != outputs {
                let wanted = format!("{inputs}, as it reads");
                return Err(refused(at, "makes channels:", outputs, &wanted, "a depthwise layer keeps them"));
            }
            layer.check(at)?;
            before = outputs;
        }
        let last = layers.len() - 1;
        if before < Self::MIN_FEATURES {
            let allowed = format!("at least {}", Self::MIN_FEATURES);
            return Err(refused(last, "makes features:", before, &allowed, "give it more channels"));
        }
        if layers[last].relu {
            return Err(refused(last, "is", "relu", "linear", "a feature may be negative"));
        }
        Ok(Self(layers.into()))
    }

    /// The layers, in the order of computation.
    pub fn layers(&self) -> &[Layer] {
        &self.0
    }

    /// Features of a pixel.
    pub fn channels(&self) -> usize {
        self.0.last().map_or(0, |layer| layer.outputs)
    }

    /// Rows and columns around a pixel that its features depend on, on each side.
    pub fn reach(&self) -> usize {
        self.0.iter().map(|layer| layer.kind.reach()).sum()
    }

    /// Multiplications with weights of a pixel of one image.
    pub fn multiplications(&self) -> usize {
        self.0.iter().map(Layer::multiplications).sum()
    }
}
