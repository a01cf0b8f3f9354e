//! Stage `block_match`: the winners of block sums.

use rayon::prelude::*;

use crate::cpu::LANES;
use crate::cpu::aligned::Aligned;
use crate::cpu::cost::CostRows;
use crate::cpu::cost::correlation::Correlation;
use crate::cpu::images::Planes;
use crate::cpu::instructions::Instructions;
use crate::cpu::winner::{Costs, RowOfMaps, WinnerRow};
use crate::params::Params;
use crate::reference::Views;
use crate::{ConfidenceMap, DisparityMap};

/// The winners of both views by [`Method::Bm`](crate::Method::Bm), a band of rows a thread.
pub fn block_match(sides: [&Planes; 2], table: &[u8], params: &Params, instructions: Instructions) -> Views {
    let (width, height) = (sides[0].width, sides[0].height);
    let map = || DisparityMap { width: width as u32, height: height as u32, data: vec![0; width * height] };
    let mut views = Views {
        left: map(),
        right: map(),
        margins: ConfidenceMap { width: width as u32, height: height as u32, data: vec![0; width * height] },
        labels: vec![0; width * height],
    };
    let rows = height.div_ceil(rayon::current_num_threads());
    let Views { left, right, margins, labels } = &mut views;
    let left = left.data.par_chunks_mut(rows * width);
    let maps = left.zip(right.data.par_chunks_mut(rows * width)).zip(margins.data.par_chunks_mut(rows * width));
    maps.zip(labels.par_chunks_mut(rows * width)).enumerate().for_each(|(i, (((left, right), margins), labels))| {
        let maps = RowOfMaps { left, right, margins, labels };
        let mut costs = CostRows::new(sides, table, params, instructions);
        let band = Band { first: i * rows, width, params, instructions };
        if params.correlates() {
            let mut correlation = Correlation::new(sides, params, instructions);
            band.match_rows(maps, |y, row: &mut [u32]| {
                costs.wide_sums(y, 0..width, row);
                correlation.row(y, row);
            });
        } else if costs.sums_are_narrow() {
            band.match_rows(maps, |y, row: &mut [u16]| costs.narrow_sums(y, 0..width, row));
        } else {
            band.match_rows(maps, |y, row: &mut [u32]| costs.wide_sums(y, 0..width, row));
        }
    });
    views
}

/// Rows of one thread.
struct Band<'a> {
    first: usize,
    width: usize,
    params: &'a Params,
    instructions: Instructions,
}

impl Band<'_> {
    /// `costs` makes a row of costs, `[x][n]`.
    fn match_rows<T: Costs>(&self, maps: RowOfMaps<'_>, mut costs: impl FnMut(usize, &mut [T])) {
        let Self { first, width, params, instructions } = *self;
        let n = (params.disparities as usize).next_multiple_of(LANES);
        let mut row = Aligned::<T>::zeroed(width * n);
        let mut winner = WinnerRow::new(width, params, instructions);
        let rows = maps.left.chunks_mut(width).zip(maps.right.chunks_mut(width));
        let rows = rows.zip(maps.margins.chunks_mut(width)).zip(maps.labels.chunks_mut(width));
        for (y, (((left, right), margins), labels)) in (first..).zip(rows) {
            costs(y, &mut row);
            winner.row(&mut row, params, RowOfMaps { left, right, margins, labels });
        }
    }
}
