//! The penalties of the steps of paths.

use rayon::prelude::*;

use crate::reference::{Direction, Plane, Volume};
use crate::{Params, Paths};

/// Stage `penalties`, as [`crate::reference::penalties`], from a table of the penalties of each change of intensity.
pub(crate) fn penalties(gray: &Plane<u8>, params: &Params) -> Volume<u8> {
    let directions = &Direction::FORWARD[..if params.paths == Paths::Sixteen { 8 } else { 4 }];
    match params.adaptive_p1 {
        true => of_steps(gray, directions, &std::array::from_fn(|delta| [large(delta, params), small(delta, params)])),
        false => of_steps(gray, directions, &std::array::from_fn(|delta| [large(delta, params)])),
    }
}

/// P2 of a change of intensity.
fn large(delta: usize, &Params { p1, p2, adaptive_p2, p2_step, .. }: &Params) -> u8 {
    if !adaptive_p2 {
        return p2 as u8;
    }
    (p2_step * p2 / (delta as u32).max(p2_step)).max(p1 + p1 / 2).min(p2) as u8
}

/// P1 of it.
fn small(delta: usize, &Params { p1, .. }: &Params) -> u8 {
    (3 * p1 / (delta as u32).max(3)).max(8).min(p1) as u8
}

/// The entries of `table`, EACH for each change of intensity.
fn of_steps<const EACH: usize>(gray: &Plane<u8>, directions: &[Direction], table: &[[u8; EACH]; 256]) -> Volume<u8> {
    let (width, count) = (gray.width, EACH * directions.len());
    let mut penalties = Volume::new(width, gray.height, count);
    penalties.data.par_chunks_mut(width * count).enumerate().for_each(|(y, row)| {
        let here = &gray.data[y * width..][..width];
        row.as_chunks_mut().0.fill(table[0]);
        for (k, step) in directions.iter().enumerate() {
            let Some(above) = y.checked_sub(step.dy as usize) else { continue };
            let there = &gray.data[above * width..][..width];
            let shift = step.dx.unsigned_abs() as usize;
            let inside = width.saturating_sub(shift);
            let (here, there, first) = match step.dx >= 0 {
                true => (&here[width - inside..], &there[..inside], width - inside),
                false => (&here[..inside], &there[width - inside..], 0),
            };
            let values = row[first * count..].chunks_exact_mut(count).map(|values| &mut values.as_chunks_mut().0[k]);
            for ((value, here), there) in values.zip(here).zip(there) {
                *value = table[usize::from(here.abs_diff(*there))];
            }
        }
    });
    penalties
}

/// P1 and P2 of the steps into the pixels of a row along one direction.
#[derive(Clone, Copy)]
pub(super) struct PenaltyRow<'a> {
    values: &'a [u8],
    /// Where that of column 0 lies; before the first value where the step into it comes from outside.
    base: usize,
    stride: usize,
    /// Whether P1 follows each P2.
    pairs: bool,
    /// Those of the parameters.
    otherwise: [u8; 2],
}

impl<'a> PenaltyRow<'a> {
    /// Those of the steps (`dx`, `dy`) into row `y`: of `penalties`, or the same everywhere.
    pub(super) fn new(penalties: Option<&'a Volume<u8>>, step: Direction, y: usize, params: &Params) -> Self {
        let (otherwise, pairs) = ([params.p1 as u8, params.p2 as u8], params.adaptive_p1);
        let Some(penalties) = penalties else { return Self { values: &[], base: 0, stride: 0, pairs, otherwise } };
        // The step from q to p has the penalty of that from p to q: of the two, the forward one is stored, at its end.
        let index = |step: Direction| Direction::FORWARD.iter().position(|forward| *forward == step);
        let (k, back) = match index(step) {
            Some(k) => (k, Direction { dx: 0, dy: 0 }),
            None => (index(step.opposite()).unwrap_or(0), step),
        };
        let pixel = (y as i64 - i64::from(back.dy)) * penalties.width as i64 - i64::from(back.dx);
        let stride = penalties.disparities;
        let k = if pairs { 2 * k } else { k };
        Self { values: &penalties.data, base: (pixel * stride as i64 + k as i64) as usize, stride, pairs, otherwise }
    }

    /// Those of column `x`; any where the step comes from outside the image, since there a path starts.
    #[inline(always)]
    pub(super) fn at(&self, x: usize) -> [u8; 2] {
        let at = self.base.wrapping_add(x * self.stride);
        match (self.pairs, self.values.get(at), self.values.get(at.wrapping_add(1))) {
            (true, Some(&p2), Some(&p1)) => [p1, p2],
            (false, Some(&p2), _) => [self.otherwise[0], p2],
            _ => self.otherwise,
        }
    }
}
