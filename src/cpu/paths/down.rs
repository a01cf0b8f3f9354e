//! A row of the paths that lead from row to row: down, or up where the rows are walked upwards.

use fearless_simd::{Simd, u8x32};

use super::front::FrontRow;
use super::step::{Receive, load, steps, store};
use crate::cpu::instructions::{Instructions, Kernel};

/// A row of a window of columns, all `[x][n]`.
pub(super) struct DownRow<'a, 'b> {
    /// The front of each direction.
    pub(super) fronts: Vec<FrontRow<'a>>,
    pub(super) cost: &'b [u8],
    /// Bytes a pixel.
    pub(super) n: usize,
    pub(super) p1: u8,
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
fn down<const K: usize, const S: usize, const N: usize>(row: DownRow<'_, '_>, instructions: Instructions) {
    instructions.launch(Row::<K, S, N>(row));
}

struct Row<'a, 'b, const K: usize, const S: usize, const N: usize>(DownRow<'a, 'b>);

impl<const K: usize, const S: usize, const N: usize> Kernel for Row<'_, '_, K, S, N> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        let DownRow { fronts, cost, n, p1, planes, other } = self.0;
        let n = if N > 0 { N } else { n };
        let Ok(mut fronts) = <[FrontRow<'_>; K]>::try_from(fronts) else { return };
        let Ok(mut planes) = <[&mut [u8]; S]>::try_from(planes) else {
            for (x, cost) in cost.chunks_exact(n).enumerate() {
                steps(simd, fronts.each_mut().map(|front| front.next(x)), cost, p1, &mut Nothing);
            }
            return;
        };
        for (x, cost) in cost.chunks_exact(n).enumerate() {
            let paths = fronts.each_mut().map(|front| front.next(x));
            let planes = planes.each_mut().map(|plane| &mut plane[x * n..][..n]);
            match other {
                Some(other) => {
                    let other = &other[x * n..][..n];
                    steps(simd, paths, cost, p1, &mut Sums::<V, S, true> { simd, planes, other });
                }
                None => steps(simd, paths, cost, p1, &mut Sums::<V, S, false> { simd, planes, other: &[] }),
            }
        }
    }
}

/// T of a pixel to its planes, two in a byte: at most 127 each.
struct Sums<'a, V, const S: usize, const OTHER: bool> {
    simd: V,
    planes: [&'a mut [u8]; S],
    other: &'a [u8],
}

impl<V: Simd, const K: usize, const S: usize, const OTHER: bool> Receive<V, K> for Sums<'_, V, S, OTHER> {
    #[inline(always)]
    fn receive(&mut self, at: usize, t: [u8x32<V>; K]) {
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
