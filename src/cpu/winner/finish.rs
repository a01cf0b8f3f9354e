//! From the winners of a row and their costs to the maps.

use crate::{DisparityMap, Params, Subpixel};

/// A cost that winners are found of.
pub(crate) trait Sum: Copy + Ord + Default + bytemuck::Pod {
    /// What no disparity costs: it stands for none.
    const NONE: Self;

    /// Its value.
    fn value(self) -> u32;

    /// floor(a / b), b > 0, where 0 <= a <= 255 * 2^16 and a / b <= 255.
    fn quotient(a: u32, b: u32) -> u32;
}

impl Sum for u16 {
    const NONE: Self = u16::MAX;

    #[inline(always)]
    fn value(self) -> u32 {
        u32::from(self)
    }

    /// Vectorises, and is exact: the quotient of f32, rounded to an integer by the addition of 2^23, lies within 1 of a / b, so it is
    /// the floor or the next integer.
    #[inline(always)]
    fn quotient(a: u32, b: u32) -> u32 {
        let rounded = (a as i32 as f32 / b as i32 as f32 + 8_388_608.0).to_bits() & 0x1ff;
        rounded - u32::from(rounded.wrapping_mul(b) as i32 > a as i32)
    }
}

impl Sum for u32 {
    const NONE: Self = u32::MAX;

    #[inline(always)]
    fn value(self) -> u32 {
        self
    }

    /// As for 16 bits, in f64, where a < 2^31 and b < 2^23.
    #[inline(always)]
    fn quotient(a: u32, b: u32) -> u32 {
        let rounded = (f64::from(a as i32) / f64::from(b as i32) + 4_503_599_627_370_496.0).to_bits() as u32 & 0x1ff;
        rounded - u32::from(rounded.wrapping_mul(b) > a)
    }
}

/// What was found of the winners of a row of the left view, a value a column.
pub(crate) struct Found<T> {
    /// The cost of the winner.
    pub(crate) best: Vec<T>,
    /// Its index.
    pub(crate) label: Vec<u16>,
    /// The cost of the disparity before it; any value if there is none.
    pub(crate) before: Vec<T>,
    /// The cost of the disparity after it; any value if there is none.
    pub(crate) after: Vec<T>,
    /// The smallest cost of the disparities that are neither it nor its neighbours, or [`Sum::NONE`].
    pub(crate) rival: Vec<T>,
}

/// A row of [`crate::reference::Views`].
pub(crate) struct RowOfMaps<'a> {
    pub(crate) left: &'a mut [i16],
    pub(crate) right: &'a mut [i16],
    pub(crate) margins: &'a mut [u8],
    pub(crate) labels: &'a mut [u16],
}

impl<T: Sum> Found<T> {
    pub(crate) fn new(width: usize) -> Self {
        let costs = || vec![T::default(); width];
        Self { best: costs(), label: vec![0; width], before: costs(), after: costs(), rival: costs() }
    }

    /// The left view, its margins and labels.
    #[inline(always)]
    pub(crate) fn finish(&self, params: &Params, to: &mut RowOfMaps<'_>) {
        let width = to.left.len();
        let (best, label, rival) = (&self.best[..width], &self.label[..width], &self.rival[..width]);
        to.labels.copy_from_slice(label);
        let stereo_bm = params.chooses_as_stereo_bm();
        match params.subpixel {
            Subpixel::Off => to.left.fill(0),
            _ if stereo_bm => self.offsets(params, to.left, |a, b, c| {
                let quotient = T::quotient(128 * (a - c).unsigned_abs(), (a.max(c) - b).max(1) as u32) as i16;
                if a > c { (quotient + 15) >> 4 } else { -(quotient >> 4) }
            }),
            _ if params.opencv_rules => self.offsets(params, to.left, |a, b, c| {
                let curve = (a + c - 2 * b).max(1);
                let scaled = 16 * (a - c) + curve;
                let quotient = T::quotient(scaled.unsigned_abs(), 2 * curve as u32) as i16;
                if scaled < 0 { -quotient } else { quotient }
            }),
            Subpixel::Parabola => self.offsets(params, to.left, |a, b, c| rounded::<T>(a - c, a + c - 2 * b)),
            Subpixel::Equiangular => self.offsets(params, to.left, |a, b, c| rounded::<T>(a - c, a.max(c) - b)),
        }
        let margins = &mut to.margins[..width];
        for x in 0..width {
            let (best, rival) = (best[x].value(), rival[x].value());
            let margin = T::quotient(255 * (rival.wrapping_sub(best) & 0x00ff_ffff), rival.max(1));
            let margin = if rival == 0 { 0 } else { margin };
            margins[x] = if rival == T::NONE.value() { 255 } else { margin as u8 };
        }
        let (ratio, smallest) = (params.uniqueness, params.min_disparity);
        let left = &mut to.left[..width];
        for x in 0..width {
            let (best, rival) = (best[x].value(), rival[x].value());
            let none = (rival == T::NONE.value()) | (ratio == 0);
            let ahead = match stereo_bm {
                true => rival > best + best * ratio / 100,
                false => rival.wrapping_mul(100 - ratio) + u32::from(params.opencv_rules) > best * 100,
            };
            let unique = none | ahead;
            let value = 16 * (smallest + i32::from(label[x])) + i32::from(left[x]);
            let seen = x as i32 - ((value + 8) >> 4);
            let valid = unique & (seen >= 0) & (seen < width as i32);
            left[x] = if valid { value as i16 } else { DisparityMap::INVALID };
        }
    }

    /// By how much each winner is refined: `offset` of the costs before, at and after it.
    #[inline(always)]
    fn offsets(&self, params: &Params, to: &mut [i16], offset: impl Fn(i32, i32, i32) -> i16) {
        let width = to.len();
        let (best, label) = (&self.best[..width], &self.label[..width]);
        let (before, after) = (&self.before[..width], &self.after[..width]);
        let last = params.disparities as u16 - 1;
        for x in 0..width {
            let [a, b, c] = [before[x], best[x], after[x]].map(|cost| cost.value() as i32);
            // Without neighbours the costs are those of others; what comes of them is not used.
            let offset = offset(a, b, c);
            let inside = (label[x] > 0) & (label[x] < last);
            to[x] = if inside { offset } else { 0 };
        }
    }
}

/// floor((16 difference + curve - 1) / (2 curve)), from -8 to 8, with curve at least 1.
#[inline(always)]
fn rounded<T: Sum>(difference: i32, curve: i32) -> i16 {
    let curve = curve.max(1);
    // Not negative: 8 is added before the division.
    T::quotient((16 * difference + 17 * curve - 1) as u32, 2 * curve as u32) as i16 - 8
}
