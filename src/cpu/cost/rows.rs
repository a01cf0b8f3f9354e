//! Rows of the matching cost, and of block sums.

use std::ops::Range;

use bytemuck::Pod;

use crate::cpu::LANES;
use crate::cpu::aligned::Aligned;
use crate::cpu::cost::kernels::{Add, Direct, Shift, Slide};
use crate::cpu::cost::pixels::Pixels;
use crate::cpu::cost::quantise::{Sums, Wide, Words};
use crate::cpu::cost::sums::{Finish, Sum, Value};
use crate::cpu::images::Planes;
use crate::cpu::instructions::Instructions;
use crate::params::Params;

/// Columns that are worked on at once: their pixel costs stay in the first cache.
const TILE: usize = 128;

/// Rows of stage `matching_cost`, for one thread: any row, any columns. Rows that follow one another, up or down, with the
/// same columns share their sums over columns.
pub struct CostRows<'a> {
    pixels: Pixels<'a>,
    block: usize,
    /// Disparities, and the same rounded up to a multiple of [`LANES`].
    disparities: usize,
    padded: usize,
    /// Whether the cost of a pixel is a product.
    multiplies: bool,
    quantise: Quantise,
    largest_sum: u32,
    /// Bits by which wide sums are narrowed.
    narrowing: u32,
    instructions: Instructions,
    /// Pixel costs of two rows, `[column][LANES]`.
    bytes: [Aligned<u8>; 2],
    words: [Aligned<u16>; 2],
    /// Sums over columns, `[disparities / LANES][column][LANES]`, and the sums that slide along a row.
    narrow: [Aligned<u16>; 2],
    wide: [Aligned<u32>; 2],
    /// The row and the columns of those sums, and whether they are those of costs.
    at: Option<(usize, Range<usize>, bool)>,
}

/// How sums become costs.
#[derive(Clone, Copy)]
enum Quantise {
    /// Of single pixels: a shift.
    Shift(u32),
    Words(Words),
    Wide(Wide),
}

/// The rows whose pixel costs enter the sums over columns, and those that leave.
enum Change {
    /// All rows of the block.
    All,
    /// One row enters, one leaves.
    One([i64; 2]),
}

impl<'a> CostRows<'a> {
    /// Of the planes of both sides, and for a cost that has one its table
    /// ([`cost_table`](crate::reference::cost_table)).
    pub fn new(sides: [&'a Planes; 2], table: &'a [u8], params: &Params, instructions: Instructions) -> Self {
        let quantise = match (params.scale_shift(), Words::new(params.largest_sum(), params.cost_scale())) {
            (shift, _) if shift > 0 && params.block == 1 => Quantise::Shift(shift),
            (_, Some(words)) if params.narrowing() == 0 => Quantise::Words(words),
            _ => Quantise::Wide(Wide::new(params)),
        };
        let disparities = params.disparities as usize;
        Self {
            pixels: Pixels::new(sides, table, params, instructions),
            block: params.block as usize,
            disparities,
            padded: disparities.next_multiple_of(LANES),
            multiplies: params.multiplies(),
            quantise,
            largest_sum: params.largest_sum(),
            narrowing: params.narrowing(),
            instructions,
            bytes: [Aligned::zeroed(0), Aligned::zeroed(0)],
            words: [Aligned::zeroed(0), Aligned::zeroed(0)],
            narrow: [Aligned::zeroed(0), Aligned::zeroed(0)],
            wide: [Aligned::zeroed(0), Aligned::zeroed(0)],
            at: None,
        }
    }

    /// Row `y` of stage `matching_cost` for these columns of the left image: `cost[(x - columns.start) * n + d]`, n the
    /// disparities rounded up to a multiple of [`LANES`]; 255 beyond the disparities.
    pub fn row(&mut self, y: usize, columns: Range<usize>, cost: &mut [u8]) {
        match self.quantise {
            Quantise::Shift(shift) => self.single(y, columns, shift, cost),
            Quantise::Words(words) => self.narrow((y, columns, true), words, [words.factor, words.bias], cost),
            Quantise::Wide(wide) => self.wide((y, columns, true), wide, cost),
        }
    }

    /// Whether block sums fit 16 bits.
    pub fn sums_are_narrow(&self) -> bool {
        self.largest_sum < 0xffff
    }

    /// The block sums of a row, laid out in the same way; the largest number beyond the disparities. For sums of 16 bits
    /// ([`CostRows::sums_are_narrow`]).
    pub fn narrow_sums(&mut self, y: usize, columns: Range<usize>, sums: &mut [u16]) {
        self.narrow((y, columns, false), Sums { narrowing: 0 }, [1, 0], sums);
    }

    /// The same of larger sums, narrowed as [`block_sums`](crate::reference::block_sums) are.
    pub fn wide_sums(&mut self, y: usize, columns: Range<usize>, sums: &mut [u32]) {
        self.wide((y, columns, false), Sums { narrowing: self.narrowing }, sums);
    }

    /// Columns of the planes, of the blocks around these columns of the image.
    fn around(&self, columns: &Range<usize>) -> Range<usize> {
        columns.start..columns.end + self.block - 1
    }

    /// Costs of single pixels.
    fn single(&mut self, y: usize, columns: Range<usize>, shift: u32, cost: &mut [u8]) {
        let Self { pixels, bytes: [values, _], padded, disparities, instructions, .. } = self;
        resize(values, TILE * LANES);
        for from in columns.clone().step_by(TILE) {
            let tile = from..columns.end.min(from + TILE);
            for d in (0..*padded).step_by(LANES) {
                let values = &mut values[..tile.len() * LANES];
                pixels.bytes(y as i64, tile.clone(), d, values);
                let out = &mut cost[(from - columns.start) * *padded + d..];
                instructions.launch(Shift { values, shift, lanes: *disparities - d, out, stride: *padded });
            }
        }
    }

    fn narrow<F: Finish<u16>>(
        &mut self,
        at: (usize, Range<usize>, bool),
        finish: F,
        [factor, bias]: [u16; 2],
        out: &mut [F::Out],
    ) {
        let y = at.0 as i64;
        let (change, around) = self.change(at);
        let Self { pixels, block, padded, disparities, bytes, words, narrow, instructions, .. } = self;
        let to = To { out, stride: *padded, disparities: *disparities };
        let with = Summed { around, block: *block, factor, bias, change, y, instructions: *instructions };
        if self.multiplies {
            let fill = |y, columns, d, out: &mut [u16]| pixels.words(y, columns, d, out);
            with.rows(fill, words, narrow, finish, to);
        } else {
            let fill = |y, columns, d, out: &mut [u8]| pixels.bytes(y, columns, d, out);
            with.rows(fill, bytes, narrow, finish, to);
        }
    }

    fn wide<F: Finish<u32>>(&mut self, at: (usize, Range<usize>, bool), finish: F, out: &mut [F::Out]) {
        let y = at.0 as i64;
        let (change, around) = self.change(at);
        let Self { pixels, block, padded, disparities, bytes, words, wide, instructions, .. } = self;
        let to = To { out, stride: *padded, disparities: *disparities };
        let with = Summed { around, block: *block, factor: 1, bias: 0, change, y, instructions: *instructions };
        if self.multiplies {
            let fill = |y, columns, d, out: &mut [u16]| pixels.words(y, columns, d, out);
            with.rows(fill, words, wide, finish, to);
        } else {
            let fill = |y, columns, d, out: &mut [u8]| pixels.bytes(y, columns, d, out);
            with.rows(fill, bytes, wide, finish, to);
        }
    }

    /// What is to be done to the sums over columns, which then are those `at` a row and columns; and the columns of the planes.
    fn change(&mut self, at: (usize, Range<usize>, bool)) -> (Change, Range<usize>) {
        let (y, columns, costs) = &at;
        let (here, radius) = (*y as i64, (self.block / 2) as i64);
        let before =
            self.at.as_ref().filter(|(_, same, kind)| same == columns && kind == costs).map(|(before, ..)| *before);
        let change = match before {
            Some(before) if before + 1 == *y => Change::One([here + radius, here - radius - 1]),
            Some(before) if before == *y + 1 => Change::One([here - radius, here + radius + 1]),
            _ => Change::All,
        };
        let around = self.around(columns);
        self.at = Some(at);
        (change, around)
    }
}

/// A row of sums to be made.
struct Summed<S> {
    around: Range<usize>,
    block: usize,
    factor: S,
    bias: S,
    change: Change,
    y: i64,
    instructions: Instructions,
}

/// Where finished sums go.
struct To<'a, O> {
    out: &'a mut [O],
    stride: usize,
    disparities: usize,
}

impl<S: Sum> Summed<S> {
    /// All columns, by [`TILE`], and all disparities, by [`LANES`]. `fill` gives the pixel costs of a row.
    fn rows<V: Value, F: Finish<S, Out: Copy>>(
        &self,
        fill: impl Fn(i64, Range<usize>, usize, &mut [V]),
        values: &mut [Aligned<V>; 2],
        [columns, sums]: &mut [Aligned<S>; 2],
        finish: F,
        to: To<'_, F::Out>,
    ) {
        let len = self.around.len() * LANES;
        values.iter_mut().for_each(|values| resize(values, TILE * LANES));
        resize(columns, self.around.len() * to.stride);
        resize(sums, to.stride);
        sums.fill(self.bias);
        let [new, old] = values;
        for from in self.around.clone().step_by(TILE) {
            let tile = from..self.around.end.min(from + TILE);
            let (new, old) = (&mut new[..tile.len() * LANES], &mut old[..tile.len() * LANES]);
            let first = from - self.around.start;
            if self.block == 1 {
                for d in (0..to.stride).step_by(LANES) {
                    fill(self.y, tile.clone(), d, new);
                    let (factor, bias, lanes) = (self.factor, self.bias, to.disparities - d);
                    let out = &mut to.out[first * to.stride + d..];
                    self.instructions.launch(Direct {
                        values: new,
                        factor,
                        bias,
                        finish,
                        lanes,
                        out,
                        stride: to.stride,
                    });
                }
                continue;
            }
            let chunks = (0..to.stride).step_by(LANES).zip(columns.chunks_exact_mut(len));
            for ((d, columns), sums) in chunks.zip(sums.as_chunks_mut::<LANES>().0) {
                let rows = match self.change {
                    Change::All => {
                        let radius = (self.block / 2) as i64;
                        let columns = &mut columns[first * LANES..][..tile.len() * LANES];
                        columns.fill(S::zeroed());
                        for y in self.y - radius..=self.y + radius {
                            fill(y, tile.clone(), d, new);
                            self.instructions.launch(Add { values: new, factor: self.factor, columns });
                        }
                        None
                    }
                    Change::One([enters, leaves]) => {
                        fill(enters, tile.clone(), d, new);
                        fill(leaves, tile.clone(), d, old);
                        Some([&*new, &*old])
                    }
                };
                let (block, factor, lanes) = (self.block, self.factor, to.disparities - d);
                let (out, stride) = (&mut to.out[d..], to.stride);
                let tile = first..first + tile.len();
                self.instructions.launch(Slide {
                    rows,
                    factor,
                    columns,
                    tile,
                    block,
                    sums,
                    finish,
                    lanes,
                    out,
                    stride,
                });
            }
        }
    }
}

/// Gives a buffer this length; what it held is lost.
fn resize<T: Pod>(buffer: &mut Aligned<T>, len: usize) {
    if buffer.len() != len {
        *buffer = Aligned::zeroed(len);
    }
}
