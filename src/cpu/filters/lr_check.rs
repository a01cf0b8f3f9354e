use crate::DisparityMap;
use rayon::prelude::*;

const INVALID: i16 = DisparityMap::INVALID;

/// [`crate::reference::lr_check`], row by row.
pub(super) fn lr_check(left: &DisparityMap, right: &DisparityMap, max_difference: u32) -> DisparityMap {
    let width = left.width as usize;
    let mut checked = left.clone();
    let rows = checked.data.par_chunks_mut(width).zip(right.data.par_chunks(width));
    rows.with_min_len(16).for_each(|(row, seen)| {
        for (x, value) in row.iter_mut().enumerate() {
            let whole = (i32::from(*value) + 8) >> 4;
            // Of an invalid value any will do: it stays invalid.
            let other = seen.get((x as i32 - whole) as usize).copied().unwrap_or(INVALID);
            let agrees = other != INVALID && (i32::from(other) >> 4).abs_diff(whole) <= max_difference;
            *value = if agrees { *value } else { INVALID };
        }
    });
    checked
}
