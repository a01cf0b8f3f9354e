//! Checks of a left map as OpenCV makes them: against itself, by what its matches cost (`validateDisparity`), and by what the right
//! view says, where the costs are not known.

/// The range of disparities of a map, in pixels, and by how many pixels two of them may differ.
pub struct Limits {
    pub minimum: i32,
    pub count: i32,
    pub difference: i32,
}

impl Limits {
    /// What a map holds where it has no disparity.
    pub fn invalid(&self) -> i32 {
        (self.minimum - 1) * 16
    }

    /// The columns in which OpenCV computes disparities.
    fn columns(&self, width: usize) -> std::ops::Range<usize> {
        let (first, end) = ((self.minimum + self.count).max(0), width as i32 + self.minimum.min(0));
        first as usize..end.max(first) as usize
    }
}

/// The column that `disparity` leads to from column `x`, if it is one of the row.
fn led_to(x: usize, disparity: i32, width: usize) -> Option<usize> {
    usize::try_from(x as i64 - i64::from(disparity)).ok().filter(|&right| right < width)
}

/// The nearest whole disparity.
fn nearest(disparity: i32) -> i32 {
    (disparity + 8) >> 4
}

/// Makes the disparities of a row invalid which the votes of both right pixels contradict that they lie between. `votes` has for
/// each right pixel a disparity, or `invalid`; `differs` says whether one is too far from a disparity, whose whole part is given,
/// too.
fn drop_contradicted(row: &mut [i16], votes: &[i32], limits: &Limits, differs: impl Fn(i32, i32, i32) -> bool) {
    let (width, invalid) = (row.len(), limits.invalid());
    for x in limits.columns(width) {
        let disparity = i32::from(row[x]);
        let contradicts = |whole: i32| {
            led_to(x, whole, width)
                .is_some_and(|right| votes[right] > invalid && differs(votes[right], disparity, whole))
        };
        if disparity != invalid && contradicts(disparity >> 4) && contradicts((disparity + 15) >> 4) {
            row[x] = invalid as i16;
        }
    }
}

/// Whether two disparities in 1/16 px differ by more than the limit.
fn sixteenths(limits: &Limits) -> impl Fn(i32, i32, i32) -> bool {
    let allowed = limits.difference.saturating_mul(16);
    move |vote, disparity, _| (vote - disparity).abs() > allowed
}

/// `validateDisparity`: of the left pixels that lead to one right pixel, that of the smallest cost has its vote, of equals the
/// leftmost. What leads out of the row takes no part.
pub fn validate_row(row: &mut [i16], costs: &[i32], limits: &Limits) {
    let (width, invalid) = (row.len(), limits.invalid());
    let mut votes = vec![invalid; width];
    let mut smallest = vec![i32::MAX; width];
    for x in limits.columns(width) {
        let disparity = i32::from(row[x]);
        let Some(right) = led_to(x, nearest(disparity), width).filter(|_| disparity != invalid) else { continue };
        if costs[x] < smallest[right] {
            (votes[right], smallest[right]) = (disparity, costs[x]);
        }
    }
    drop_contradicted(row, &votes, limits, sixteenths(limits));
}

/// The same without costs: the right view says which of the left pixels has the vote. If it names none of them, the one of the
/// smallest disparity has it. With `whole`, as in StereoSGBM, whole disparities are compared.
pub fn check_row(row: &mut [i16], right_view: &[i16], limits: &Limits, whole: bool) {
    let (width, invalid) = (row.len(), limits.invalid());
    let mut votes: Vec<Option<(bool, i32)>> = vec![None; width];
    for x in limits.columns(width) {
        let disparity = i32::from(row[x]);
        let Some(right) = led_to(x, nearest(disparity), width).filter(|_| disparity != invalid) else { continue };
        // `false` is less than `true`: one that is named comes before all others.
        let vote = (i32::from(right_view[right]) != 16 * nearest(disparity), disparity);
        votes[right] = Some(votes[right].map_or(vote, |other| other.min(vote)));
    }
    let votes: Vec<i32> = votes.into_iter().map(|vote| vote.map_or(invalid, |(_, disparity)| disparity)).collect();
    if whole {
        drop_contradicted(row, &votes, limits, |vote, _, whole| (nearest(vote) - whole).abs() > limits.difference);
    } else {
        drop_contradicted(row, &votes, limits, sixteenths(limits));
    }
}
