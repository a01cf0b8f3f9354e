//! What an operation reads and makes.

/// The output of an operation for one side: `data[((channel * planes + plane) * rows + row) * columns + column]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    /// Channels, planes, rows, columns. An image has one plane.
    pub shape: [usize; 4],
    /// The values, column fastest.
    pub data: Vec<f64>,
}

impl Values {
    /// Zeros.
    pub fn new(shape: [usize; 4]) -> Self {
        Self { shape, data: vec![0.0; shape.iter().product()] }
    }

    /// A row of columns.
    pub fn row(&self, channel: usize, plane: usize, row: usize) -> &[f64] {
        let [_, planes, rows, columns] = self.shape;
        &self.data[((channel * planes + plane) * rows + row) * columns..][..columns]
    }

    /// A single value.
    pub fn at(&self, channel: usize, plane: usize, row: usize, column: usize) -> f64 {
        self.row(channel, plane, row)[column]
    }
}
