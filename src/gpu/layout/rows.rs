//! Rows of images, and how they are cut.

/// Neighbouring rows that are worked on together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Rows {
    pub(crate) first: u32,
    pub(crate) count: u32,
}

impl Rows {
    /// The row after the last one.
    pub(crate) fn end(self) -> u32 {
        self.first + self.count
    }
}

/// Cuts `rows` into the fewest pieces of at most `most` rows, as even as can be.
pub(crate) fn cut(rows: Rows, most: u32) -> Vec<Rows> {
    let pieces = rows.count.div_ceil(most);
    let count = rows.count.div_ceil(pieces);
    let firsts = (0..pieces).map(|i| rows.first + i * count);
    let end = rows.first + rows.count;
    firsts.filter(|&first| first < end).map(|first| Rows { first, count: count.min(end - first) }).collect()
}

/// The same, of pieces that begin at multiples of `unit` rows; `most` is at least that.
pub(crate) fn cut_to(rows: Rows, most: u32, unit: u32) -> Vec<Rows> {
    let units = Rows { first: 0, count: rows.count.div_ceil(unit) };
    let whole = |piece: Rows| {
        let (first, end) = (piece.first * unit, (piece.end() * unit).min(rows.count));
        Rows { first: rows.first + first, count: end - first }
    };
    cut(units, most / unit).into_iter().map(whole).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_cover_all_rows_once() {
        for count in 1..40 {
            for most in 1..45 {
                let pieces = cut(Rows { first: 3, count }, most);
                let mut next = 3;
                for piece in &pieces {
                    assert_eq!(piece.first, next);
                    assert!(piece.count >= 1 && piece.count <= most);
                    next += piece.count;
                }
                assert_eq!(next, 3 + count);
                assert_eq!(pieces.len() as u32, count.div_ceil(most), "{count} rows in pieces of {most}");
            }
        }
    }
}
