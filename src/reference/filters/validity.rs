use std::ops::Range;

use crate::reference::Plane;
use crate::{DisparityMap, Masks, Method, Params, Rectification};

/// Which pixels of the pair at hand have content: after [`Params::rectify`], if that is asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Content {
    /// Of the left view and of the right one.
    pub sides: [Plane<bool>; 2],
}

impl Content {
    /// Of pairs of `width` x `height` pixels, those that the rectification and the masks are for. `None` if all pixels have
    /// content: then no stage reads it.
    ///
    /// A pixel of a given image has content if its mask is not 0, or there is none. A pixel of a rectified image has content
    /// if each pixel that it is interpolated from lies in the given image and has content there. With
    /// [`Params::opencv_rules`] only those of the left view have it whose range of disparities lies in the right image.
    pub fn new(params: &Params, width: u32, height: u32) -> Option<Self> {
        if params.rectify.is_none() && params.masks.is_none() && !params.opencv_rules {
            return None;
        }
        let side = |side| content_of_side(params.rectify.as_ref(), params.masks.as_ref(), side, [width, height]);
        let mut content = Self { sides: [side(0), side(1)] };
        if params.opencv_rules {
            let left = &mut content.sides[0];
            let (columns, rows) = valid_rectangle(params, left.width as i64, left.height as i64);
            let inside = |i: usize, width: usize| {
                columns.contains(&((i % width) as i64)) && rows.contains(&((i / width) as i64))
            };
            let width = left.width;
            left.data.iter_mut().enumerate().for_each(|(i, has)| *has &= inside(i, width));
        }
        content.sides.iter().any(|side| side.data.contains(&false)).then_some(content)
    }

    /// The content of images halved `halvings` times: a pixel has content if all four pixels that it is computed from have,
    /// the image continued by its border.
    #[must_use]
    pub fn halved(&self, halvings: u32) -> Self {
        let half = |side: &Plane<bool>| {
            let (width, height) = (side.width.div_ceil(2), side.height.div_ceil(2));
            let blank = Plane { width, height, data: vec![false; width * height] };
            let four = |x, y| [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| side.clamped(2 * x + i, 2 * y + j));
            blank.map(|x, y| four(x, y) == [1; 4])
        };
        (0..halvings).fold(self.clone(), |content, _| Self { sides: content.sides.each_ref().map(half) })
    }

    /// Of the pair (mirrored right image, mirrored left image).
    #[must_use]
    pub fn mirrored(&self) -> Self {
        let [left, right] = &self.sides;
        let mirror = |side: &Plane<bool>| Plane {
            data: side.data.chunks_exact(side.width).flat_map(|row| row.iter().rev().copied()).collect(),
            ..*side
        };
        Self { sides: [mirror(right), mirror(left)] }
    }
}

/// The columns and rows in which OpenCV gives disparities: with [`Method::Bm`] those of StereoBM, whose blocks lie in the left
/// image and, for all disparities from 0 on, in the right one; else those of StereoSGBM, one column less at the left.
fn valid_rectangle(params: &Params, width: i64, height: i64) -> (Range<i64>, Range<i64>) {
    let smallest = i64::from(params.min_disparity);
    let behind = smallest + i64::from(params.disparities);
    match params.method {
        Method::Bm => {
            let r = i64::from(params.radius());
            ((behind - 1).max(0) + r..width - r.max(-smallest), r..height - r)
        }
        Method::Sgm | Method::Bp | Method::Psmnet => (behind.max(0)..width + smallest.min(0), 0..height),
    }
}

fn content_of_side(
    rectification: Option<&Rectification>,
    masks: Option<&Masks>,
    side: usize,
    [width, height]: [u32; 2],
) -> Plane<bool> {
    let mask = masks.and_then(|masks| masks.side(side));
    let has = |x: i32, y: i32| {
        (0..width as i32).contains(&x)
            && (0..height as i32).contains(&y)
            && mask.is_none_or(|mask| mask[y as usize * width as usize + x as usize] != 0)
    };
    let [columns, rows] = rectification.map_or([width, height], Rectification::rectified_size);
    let data = match rectification {
        None => {
            mask.map_or(vec![true; width as usize * height as usize], |mask| mask.iter().map(|&v| v != 0).collect())
        }
        Some(rectification) => {
            let all_that_count = |&[x, y]: &[i32; 2]| {
                let (beside, below) = (i32::from(x & 255 != 0), i32::from(y & 255 != 0));
                let (x, y) = (x >> 8, y >> 8);
                has(x, y) && has(x + beside, y) && has(x, y + below) && has(x + beside, y + below)
            };
            rectification.positions(side).iter().map(all_that_count).collect()
        }
    };
    Plane { width: columns as usize, height: rows as usize, data }
}

/// Stage `validity`: a map of the left view (`side` 0) or of the right one (1) without the disparities of pixels that have no
/// content, or lead to one that has none.
///
/// A disparity v leads from column x to P / 16 of the other view, with P = 16 x - v of the left map and 16 x + v of the right
/// one: to the columns floor(P / 16) and ceil(P / 16), which are one where P / 16 is whole; the content is continued by its
/// border.
pub fn validity(map: &DisparityMap, content: &Content, side: usize) -> DisparityMap {
    let width = map.width as usize;
    let has = |side: usize, x: i64, y: usize| content.sides[side].clamped(x, y as i64) == 1;
    let of = |(i, &value): (usize, &i16)| {
        let (x, y) = ((i % width) as i64, i / width);
        let place = if side == 0 { 16 * x - i64::from(value) } else { 16 * x + i64::from(value) };
        let stays = has(side, x, y) && has(1 - side, place >> 4, y) && has(1 - side, (place + 15) >> 4, y);
        if stays { value } else { DisparityMap::INVALID }
    };
    DisparityMap { data: map.data.iter().enumerate().map(of).collect(), ..*map }
}
