//! A row of the paths that lead from row to row: down, or up where the rows are walked upwards.

use super::front::FrontRow;
use super::step::{Receive, steps};
use crate::cpu::instructions::Instructions;

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

/// Half a step: T of a pixel to its planes.
struct Sums<'a, const S: usize, const OTHER: bool> {
    planes: [&'a mut [u8]; S],
    other: &'a [u8],
}

impl<const K: usize, const S: usize, const OTHER: bool> Receive<K> for Sums<'_, S, OTHER> {
    #[inline(always)]
    fn receive<const B: usize>(&mut self, at: usize, t: &[[u8; B]; K]) {
        for i in 0..S {
            // At most 127 each.
            let mut sum = [0u8; B];
            if OTHER && i == 0 {
                let other = &self.other[at..][..B];
                for d in 0..B {
                    sum[d] = other[d].wrapping_add(t[0][d]);
                }
            } else {
                let first = if OTHER { 2 * i - 1 } else { 2 * i };
                if first + 1 < K {
                    for d in 0..B {
                        sum[d] = t[first][d].wrapping_add(t[first + 1][d]);
                    }
                } else {
                    sum = t[first];
                }
            }
            self.planes[i][at..][..B].copy_from_slice(&sum);
        }
    }
}

/// T is not wanted.
struct Nothing;

impl<const K: usize> Receive<K> for Nothing {
    #[inline(always)]
    fn receive<const B: usize>(&mut self, _: usize, _: &[[u8; B]; K]) {}
}

/// K directions, S planes. N: the bytes of a pixel where they are known, else 0.
fn down<const K: usize, const S: usize, const N: usize>(row: DownRow<'_, '_>, instructions: Instructions) {
    instructions.run(
        #[inline(always)]
        move || down_in_set::<K, S, N>(row),
    );
}

#[inline(always)]
fn down_in_set<const K: usize, const S: usize, const N: usize>(row: DownRow<'_, '_>) {
    let DownRow { fronts, cost, n, p1, planes, other } = row;
    let n = if N > 0 { N } else { n };
    let Ok(mut fronts) = <[FrontRow<'_>; K]>::try_from(fronts) else { return };
    let Ok(mut planes) = <[&mut [u8]; S]>::try_from(planes) else {
        for (x, cost) in cost.chunks_exact(n).enumerate() {
            steps(fronts.each_mut().map(|front| front.next(x)), cost, p1, &mut Nothing);
        }
        return;
    };
    for (x, cost) in cost.chunks_exact(n).enumerate() {
        let paths = fronts.each_mut().map(|front| front.next(x));
        let planes = planes.each_mut().map(|plane| &mut plane[x * n..][..n]);
        match other {
            Some(other) => {
                steps(paths, cost, p1, &mut Sums::<S, true> { planes, other: &other[x * n..][..n] });
            }
            None => steps(paths, cost, p1, &mut Sums::<S, false> { planes, other: &[] }),
        }
    }
}
