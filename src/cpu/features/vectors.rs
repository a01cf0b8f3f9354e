//! Vectors of one length, in bytes.

use std::ops::Range;

/// Columns at once.
const COLUMNS: usize = 16;

/// The features of a row: of the values of all channels, `[channel][column]` with this stride, from `first` on; to these columns of
/// `[channel][column of the image]`. The twin of [`features`](crate::reference::features()).
///
/// Quotients of floats are right, as numerators are below 2^20, and as one below a whole number up to 127 differs from it by
/// at least 1 / 46342.
#[inline(always)]
pub fn vectors((values, stride): (&[i32], usize), first: usize, columns: Range<usize>, width: usize, out: &mut [u8]) {
    for column in columns.clone().step_by(COLUMNS) {
        let count = COLUMNS.min(columns.end - column);
        let at = first + column - columns.start;
        let mut squares = [0_i32; COLUMNS];
        for channel in values.chunks_exact(stride) {
            let channel = &channel[at..at + COLUMNS];
            squares.iter_mut().zip(channel).for_each(|(sum, v)| *sum += v * v);
        }
        let lengths = squares.map(
            #[inline(always)]
            |square| {
                let root = f64::from(square).sqrt() as i32;
                root + i32::from(root * root < square)
            },
        );
        for (channel, out) in values.chunks_exact(stride).zip(out.chunks_exact_mut(width)) {
            let channel = &channel[at..at + COLUMNS];
            let mut bytes = [0; COLUMNS];
            for ((byte, &v), &length) in bytes.iter_mut().zip(channel).zip(&lengths) {
                let size = ((340 * v.abs() + length) as f32 / (2 * length.max(1)) as f32).min(127.0) as i32;
                *byte = (128 + if v < 0 { -size } else { size }) as u8;
            }
            out[column..column + count].copy_from_slice(&bytes[..count]);
        }
    }
}
