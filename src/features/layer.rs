//! A layer, and whether it may overflow.

use std::fmt;

use crate::Error;

/// What a layer sums.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum LayerKind {
    /// 3x3 pixels of all input channels.
    Convolution,
    /// 3x3 pixels of the input channel of the same number.
    Depthwise,
    /// The pixel itself in all input channels.
    Point,
}

impl LayerKind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Convolution, Self::Depthwise, Self::Point];

    /// Its name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Convolution => "convolution",
            Self::Depthwise => "depthwise",
            Self::Point => "point",
        }
    }

    /// Rows and columns by which it reaches beyond a pixel.
    pub const fn reach(self) -> usize {
        match self {
            Self::Convolution | Self::Depthwise => 1,
            Self::Point => 0,
        }
    }

    /// Weights of an output channel.
    pub const fn weights(self, inputs: usize) -> usize {
        match self {
            Self::Convolution => 9 * inputs,
            Self::Depthwise => 9,
            Self::Point => inputs,
        }
    }
}

impl fmt::Display for LayerKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A layer of a [`crate::FeatureNetwork`]. For each output channel o and each pixel it sums products of weights and values,
/// acc = `bias[o]` + sum w v, and makes a value of the sum: floor((acc `multiplier[o]` + 2^(`shift[o]` - 1)) / 2^`shift[o]`), clamped to 0..127 with
/// `relu`, else to -127..127, in the last layer to -2047..2047.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layer {
    /// What is summed.
    pub kind: LayerKind,
    /// Whether negative values become 0.
    pub relu: bool,
    /// Channels that it reads.
    pub inputs: usize,
    /// Channels that it makes.
    pub outputs: usize,
    /// `[output][input][row][column]` of a convolution, `[output][row][column]` of a depthwise one, `[output][input]` of points.
    pub weights: Vec<i8>,
    /// What is added to each output channel.
    pub bias: Vec<i32>,
    /// By what the sums of each output channel are multiplied, 1 to 32767.
    pub multiplier: Vec<i32>,
    /// Bits by which the products of each output channel are shifted down, 1 to 30.
    pub shift: Vec<i32>,
}

/// The largest number that a value between layers and a weight may have, without its sign.
const MOST: i64 = 127;

impl Layer {
    /// What sums are below, and so are exact in 32-bit floats.
    pub const MAX_SUM: i64 = 1 << 24;

    /// The largest sum of an output channel, without its sign.
    pub fn largest_sum(&self, output: usize) -> i64 {
        let each = self.kind.weights(self.inputs);
        let weights = self.weights[output * each..][..each].iter();
        i64::from(self.bias[output]).abs() + MOST * weights.map(|&weight| i64::from(weight).abs()).sum::<i64>()
    }

    /// The least and the largest value that it leaves, as the last layer or another one.
    pub fn range(&self, is_last: bool) -> [i32; 2] {
        match (is_last, self.relu) {
            (true, _) => [-2047, 2047],
            (false, true) => [0, 127],
            (false, false) => [-127, 127],
        }
    }

    /// Multiplications of a pixel.
    pub fn multiplications(&self) -> usize {
        self.weights.len()
    }

    /// Whether all arrays have their lengths and nothing overflows; `at` is its number in the network.
    pub(super) fn check(&self, at: usize) -> Result<(), Error> {
        self.check_lengths(at)?;
        if let Some(weight) = self.weights.iter().find(|weight| **weight == i8::MIN) {
            return Err(refused(at, "has a weight of", weight, "-127 to 127", "clip its weights"));
        }
        for output in 0..self.outputs {
            let (multiplier, shift) = (self.multiplier[output], self.shift[output]);
            if !(1..=32767).contains(&multiplier) {
                let what = format!("has for output {output} a multiplier of");
                return Err(refused(at, &what, multiplier, "1 to 32767", "choose another shift"));
            }
            if !(1..=30).contains(&shift) {
                let what = format!("has for output {output} a shift of");
                return Err(refused(at, &what, shift, "1 to 30", "choose another multiplier"));
            }
            let largest = self.largest_sum(output);
            if largest >= Self::MAX_SUM {
                let what = format!("has for output {output} sums of up to");
                return Err(refused(at, &what, largest, "below 2^24", "scale its weights and its bias down"));
            }
            let product = largest * i64::from(multiplier) + (1 << (shift - 1));
            if product >= 1 << 31 {
                let what = format!("has for output {output} products of sums and multiplier of up to");
                return Err(refused(at, &what, product, "below 2^31", "take a smaller multiplier and shift"));
            }
        }
        Ok(())
    }

    fn check_lengths(&self, at: usize) -> Result<(), Error> {
        let weights = self.outputs * self.kind.weights(self.inputs);
        for (what, given, wanted) in [
            ("weights", self.weights.len(), weights),
            ("biases", self.bias.len(), self.outputs),
            ("multipliers", self.multiplier.len(), self.outputs),
            ("shifts", self.shift.len(), self.outputs),
        ] {
            if given != wanted {
                let text = format!("has {what}:");
                return Err(refused(at, &text, given, &wanted.to_string(), "give as many as its channels need"));
            }
        }
        Ok(())
    }
}

/// That a layer is none that can be computed.
pub(super) fn refused(at: usize, what: &str, given: impl fmt::Display, allowed: &str, remedy: &str) -> Error {
    Error::Network(format!("layer {at} of the network of features {what} {given}, but must be {allowed}; {remedy}"))
}
