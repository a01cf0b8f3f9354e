//! What an operation makes.

/// The output of an operation for one side: `data[((plane * rows + row) * channels + channel) * columns + column]`. All
/// channels of a row lie together, so that threads write whole rows.
pub(super) struct Activation {
    /// Channels, planes, rows, columns. An image has one plane.
    pub(super) shape: [usize; 4],
    pub(super) data: Vec<f32>,
}

impl Activation {
    pub(super) fn new(shape: [usize; 4]) -> Self {
        Self { shape, data: vec![0.0; shape.iter().product()] }
    }

    /// A row of columns.
    pub(super) fn row(&self, channel: usize, plane: usize, row: usize) -> &[f32] {
        let [channels, _, rows, columns] = self.shape;
        &self.data[((plane * rows + row) * channels + channel) * columns..][..columns]
    }
}

/// What a convolution reads.
#[derive(Clone, Copy)]
pub(super) enum Source<'a> {
    /// What an operation made.
    One(&'a Activation),
    /// The volume of the features of both sides, which is never stored, with this number of planes.
    Pair(&'a Activation, &'a Activation, usize),
}

/// The columns of a row that may differ from 0: `values[0]` is that of column `first`.
pub(super) struct Row<'a> {
    pub(super) first: usize,
    pub(super) values: &'a [f32],
}

impl<'a> Source<'a> {
    /// Channels, planes, rows, columns.
    pub(super) fn shape(self) -> [usize; 4] {
        match self {
            Self::One(input) => input.shape,
            Self::Pair(left, _, planes) => {
                let [channels, _, rows, columns] = left.shape;
                [2 * channels, planes, rows, columns]
            }
        }
    }

    /// A row; `None` if it is beyond the border.
    pub(super) fn row(self, channel: usize, plane: isize, row: isize) -> Option<Row<'a>> {
        let [_, planes, rows, columns] = self.shape();
        let plane = usize::try_from(plane).ok().filter(|&plane| plane < planes)?;
        let row = usize::try_from(row).ok().filter(|&row| row < rows)?;
        Some(match self {
            Self::One(input) => Row { first: 0, values: input.row(channel, plane, row) },
            Self::Pair(left, right, _) => {
                let first = plane.min(columns);
                let values = match channel.checked_sub(left.shape[0]) {
                    None => &left.row(channel, 0, row)[first..],
                    Some(channel) => &right.row(channel, 0, row)[..columns - first],
                };
                Row { first, values }
            }
        })
    }
}
