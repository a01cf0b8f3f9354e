//! What a step writes.

use crate::gpu::layout::Rows;
use crate::params::Filter;
use crate::reference::Direction;

/// What a step writes, and which part of it: for the comparison with the reference.
#[derive(Clone, Debug)]
pub(crate) enum Written {
    /// The rectified image of a side, laid out like the uploaded one.
    Rectified {
        side: usize,
    },
    /// Luma in 8 bits, or with `deep` the channel of an image in 16 bits.
    Gray {
        side: usize,
        channel: usize,
        deep: bool,
    },
    /// An intermediate result of a stage, for a later kernel of the same stage.
    Part,
    /// Sums over windows of an image, prefiltered or not.
    WindowSums {
        side: usize,
        channel: usize,
        filtered: bool,
        window: u32,
    },
    /// A prefiltered image, laid out like a gray one.
    Prefiltered {
        side: usize,
        channel: usize,
    },
    /// `count` planes of descriptors, from `first` on, of some rows of the image.
    Descriptors {
        side: usize,
        first: usize,
        count: usize,
        rows: Rows,
    },
    /// The mean and the deviation of an image.
    FeatureStatistics {
        side: usize,
    },
    /// What a layer of a network of features leaves of some rows, or without one what the first layer reads.
    FeatureLayer {
        side: usize,
        layer: Option<usize>,
        rows: Rows,
    },
    /// The features of some rows.
    Features {
        side: usize,
        rows: Rows,
    },
    /// The values that are halved, or what came of it, laid out like a gray image.
    Values {
        side: usize,
    },
    Histogram,
    Table,
    Columns {
        chunk: Rows,
    },
    /// Of a forward direction.
    Penalties {
        direction: Direction,
    },
    Cost {
        chunk: Rows,
        volume_row: u32,
    },
    /// Of the blocks of one side.
    BlockStatistics {
        side: usize,
        chunk: Rows,
    },
    /// The paths of all directions together, when the last of their steps is done.
    Paths {
        directions: Vec<Direction>,
        band: Rows,
        volume_row: u32,
        first: bool,
        last: bool,
    },
    /// The cost of the second pass, of some rows; the last ones end what is of the first pass.
    SecondCost {
        rows: Rows,
        volume_row: u32,
        last: bool,
    },
    /// The sums of costs of a level of belief propagation.
    CoarseCost {
        level: usize,
        band: usize,
    },
    /// The messages of a level after some rounds.
    Messages {
        level: usize,
        band: usize,
        rounds: usize,
        last: bool,
    },
    /// The output of an operation of a network, of both sides where it has two; the last one's are the disparities.
    Layer {
        operation: usize,
        /// Its first texel in the buffer.
        at: u32,
        /// Whether others lie in the same buffer.
        joined: bool,
    },
    /// The map of the disparities of a network.
    Rounded,
    /// Both views; the right one, the margins and the labels are in `right`.
    Views {
        right: wgpu::Buffer,
        last: bool,
    },
    /// The right view of a second match.
    Mirrored,
    /// A map of the left view (0) or of the right one (1).
    Validity {
        side: usize,
    },
    /// The map of a filter.
    Filter(Filter),
    Confidence,
    Depth,
}

impl Written {
    /// Whether the step completes what is compared.
    pub(crate) fn is_whole(&self) -> bool {
        !matches!(
            self,
            Self::Part
                | Self::Views { last: false, .. }
                | Self::Paths { last: false, .. }
                | Self::Messages { last: false, .. }
        )
    }

    /// Whether it is made of the images alone, before the first round of mutual information begins.
    pub(crate) fn precedes_rounds(&self) -> bool {
        matches!(
            self,
            Self::Rectified { .. }
                | Self::Gray { .. }
                | Self::WindowSums { .. }
                | Self::Prefiltered { .. }
                | Self::Values { .. }
                | Self::Descriptors { .. }
                | Self::FeatureStatistics { .. }
                | Self::FeatureLayer { .. }
                | Self::Features { .. }
        )
    }
}
