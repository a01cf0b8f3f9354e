//! A row of the paths that lead from row to row: down, or up where the rows are walked upwards.

use fearless_simd::{Simd, u8x32};

use super::front::{FrontRow, Fronts};
use super::step::{Receive, load, steps, store};
use crate::cpu::instructions::{Instructions, Kernel};

/// A row of a window of columns, all `[x][n]`.
pub(super) struct DownRow<'a, 'b> {
    /// The front of each direction.
    pub(super) fronts: Vec<FrontRow<'a>>,
    pub(super) cost: &'b [u8],
    /// Bytes a pixel.
    pub(super) n: usize,
    /// T of the directions, added two by two: half as many planes as directions, rounded up. Nothing if T is not wanted.
    pub(super) planes: Vec<&'b mut [u8]>,
    /// T of a single path from the other side, which goes into the first plane with the T of the first direction.
    pub(super) other: Option<&'b [u8]>,
}

/// Computes a row.
pub(super) type Down = fn(DownRow<'_, '_>, Instructions);

/// The function for `directions` directions and n bytes a pixel.
pub(super) fn down_for(directions: usize, n: usize) -> Down {
    match (directions, n) {
        (1, 64) => down::<1, 1, 64>,
        (1, 128) => down::<1, 1, 128>,
        (1, _) => down::<1, 1, 0>,
        (3, 64) => down::<3, 2, 64>,
        (3, 128) => down::<3, 2, 128>,
        (3, _) => down::<3, 2, 0>,
        _ => down::<7, 4, 0>,
    }
}

/// K directions, S planes. N: the bytes of a pixel where they are known, else 0.
fn down<const K: usize, const S: usize, const N: usize>(row: DownRow<'_, '_>, instructions: Instructions)
where
    for<'f> [FrontRow<'f>; K]: Fronts<K>,
{
    instructions.launch(Row::<K, S, N>(row));
}

struct Row<'a, 'b, const K: usize, const S: usize, const N: usize>(DownRow<'a, 'b>);

impl<const K: usize, const S: usize, const N: usize> Kernel for Row<'_, '_, K, S, N>
where
    for<'f> [FrontRow<'f>; K]: Fronts<K>,
{
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        let DownRow { fronts, cost, n, planes, other } = self.0;
        let n = if N > 0 { N } else { n };
        let Ok(fronts) = <[FrontRow<'_>; K]>::try_from(fronts) else { return };
        match (<[&mut [u8]; S]>::try_from(planes), other) {
            (Err(_), _) => columns(simd, fronts, cost, n, &mut Nothing),
            (Ok(planes), None) => {
                columns(simd, fronts, cost, n, &mut Sums::<V, S, false> { simd, planes, other: &[], first: 0 });
            }
            (Ok(planes), Some(other)) => {
                columns(simd, fronts, cost, n, &mut Sums::<V, S, true> { simd, planes, other, first: 0 });
            }
        }
    }
}

/// The steps into all columns.
#[inline(always)]
fn columns<V: Simd, const K: usize>(
    simd: V,
    mut fronts: [FrontRow<'_>; K],
    cost: &[u8],
    n: usize,
    to: &mut impl Receive<V, K>,
) where
    for<'f> [FrontRow<'f>; K]: Fronts<K>,
{
    for (x, cost) in cost.chunks_exact(n).enumerate() {
        to.column(x * n);
        steps(simd, fronts.next(x), cost, to);
    }
}

/// T of a column to its planes, two in a byte: at most 127 each.
struct Sums<'a, V, const S: usize, const OTHER: bool> {
    simd: V,
    planes: [&'a mut [u8]; S],
    other: &'a [u8],
    first: usize,
}

impl<V: Simd, const K: usize, const S: usize, const OTHER: bool> Receive<V, K> for Sums<'_, V, S, OTHER> {
    #[inline(always)]
    fn column(&mut self, first: usize) {
        self.first = first;
    }

    #[inline(always)]
    fn receive(&mut self, at: usize, t: [u8x32<V>; K]) {
        let at = self.first + at;
        for i in 0..S {
            let sum = if OTHER && i == 0 {
                self.simd.add_u8x32(load(self.simd, self.other, at), t[0])
            } else {
                let first = if OTHER { 2 * i - 1 } else { 2 * i };
                if first + 1 < K { self.simd.add_u8x32(t[first], t[first + 1]) } else { t[first] }
            };
            store(sum, self.planes[i], at);
        }
    }
}

/// T is not wanted.
struct Nothing;

impl<V: Simd, const K: usize> Receive<V, K> for Nothing {
    #[inline(always)]
    fn receive(&mut self, _: usize, _: [u8x32<V>; K]) {}
}
