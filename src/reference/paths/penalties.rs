use crate::Params;
use crate::reference::{Direction, Plane, Volume};
use rayon::prelude::*;

/// Stage `penalties`: P2 for the step into each pixel from the pixel before it, for each of [`Direction::FORWARD`] that
/// is among the paths or whose opposite is: `data[(y * width + x) * disparities + k]`, k the direction. Four directions,
/// and eight for 16 paths. With [`Params::adaptive_p1`] P2 and P1 take turns: of direction k they are the entries 2 k and 2 k + 1.
///
/// P2'(delta) = min(P2, max(floor(s P2 / max(delta, s)), P1 + floor(P1 / 2))), delta = |I(p) - I(q)| of the left gray
/// image in 8 bits and s = [`Params::p2_step`]: P2 where the intensity changes by at most s levels, and in inverse proportion to the
/// change above (Hirschmüller 2008, section 2.3), but not below one and a half times P1. delta is 0 where q lies outside.
///
/// P1'(delta) = min(P1, max(8, floor(3 P1 / max(delta, 3)))): likewise, from a change of 3 levels on. Each is the parameter itself
/// where it is not adaptive. P1' <= P2': P2' is P2 >= P1 or at least P1 + floor(P1 / 2) >= P1, and P1' <= P1.
pub fn penalties(gray: &Plane<u8>, params: &Params) -> Volume<u8> {
    let directions = &Direction::FORWARD[..if params.paths == crate::Paths::Sixteen { 8 } else { 4 }];
    let each = if params.adaptive_p1 { 2 } else { 1 };
    let mut penalties = Volume::new(gray.width, gray.height, each * directions.len());
    let row_len = penalties.row_len();
    penalties.data.par_chunks_mut(row_len).enumerate().for_each(|(y, row)| {
        for (x, values) in row.chunks_exact_mut(each * directions.len()).enumerate() {
            let (x, y) = (x as i64, y as i64);
            for (values, step) in values.chunks_exact_mut(each).zip(directions) {
                let (u, v) = (x - i64::from(step.dx), y - i64::from(step.dy));
                let inside = (0..gray.width as i64).contains(&u) && (0..gray.height as i64).contains(&v);
                let delta = if inside { gray.clamped(x, y).abs_diff(gray.clamped(u, v)) } else { 0 };
                values.copy_from_slice(&[large(delta, params) as u8, small(delta, params) as u8][..each]);
            }
        }
    });
    penalties
}

/// P2 of a step.
fn large(delta: u32, params: &Params) -> u32 {
    if !params.adaptive_p2 {
        return params.p2;
    }
    (params.p2_step * params.p2 / delta.max(params.p2_step)).max(params.p1 + params.p1 / 2).min(params.p2)
}

/// P1 of a step.
fn small(delta: u32, params: &Params) -> u32 {
    (3 * params.p1 / delta.max(3)).max(8).min(params.p1)
}
