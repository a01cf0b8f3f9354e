//! Partners: which image of one camera belongs to which of the other, by their stamps.

/// The pairs of two cameras' images.
#[derive(Debug, PartialEq, Eq)]
pub struct Partners {
    /// For each pair, the places of the left and of the right image among those of their camera.
    pub pairs: Vec<[usize; 2]>,
    /// The largest difference of the stamps within a pair, in nanoseconds.
    pub apart: i64,
}

/// Images with the same stamp belong together; else the nearest ones within half the time between two images of the left camera.
pub fn partners(stamps: [&[i64]; 2]) -> Partners {
    let sorted = stamps.map(|stamps| {
        let mut sorted: Vec<_> = stamps.iter().copied().zip(0..).collect();
        sorted.sort_unstable();
        sorted
    });
    let [left, right] = &sorted;
    let most = half_a_period(left);
    let far = |l: usize, r: usize| match (left.get(l), right.get(r)) {
        (Some((l, _)), Some((r, _))) => l.saturating_sub(*r).saturating_abs(),
        _ => i64::MAX,
    };
    let (mut pairs, mut apart) = (Vec::new(), 0);
    let (mut l, mut r) = (0, 0);
    while l < left.len() && r < right.len() {
        let distance = far(l, r);
        if far(l, r + 1) < distance {
            r += 1;
        } else if far(l + 1, r) < distance {
            l += 1;
        } else {
            if distance <= most {
                pairs.push([left[l].1, right[r].1]);
                apart = apart.max(distance);
            }
            (l, r) = (l + 1, r + 1);
        }
    }
    Partners { pairs, apart }
}

/// Half of the usual time between two images: the lower median. Of a single image it is not known, and any is near enough.
fn half_a_period(sorted: &[(i64, usize)]) -> i64 {
    let mut periods: Vec<_> = sorted.windows(2).map(|pair| pair[1].0.saturating_sub(pair[0].0)).collect();
    periods.sort_unstable();
    periods.get(periods.len().saturating_sub(1) / 2).map_or(i64::MAX, |period| period / 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_stamps_belong_together_and_else_the_nearest() {
        let of = |left: &[i64], right: &[i64]| partners([left, right]);
        let pairs = |left: &[i64], right: &[i64]| of(left, right).pairs;
        assert_eq!(of(&[0, 100, 200], &[0, 100, 200]), Partners { pairs: vec![[0, 0], [1, 1], [2, 2]], apart: 0 });
        // One is missing on each side.
        assert_eq!(pairs(&[0, 200, 300], &[0, 100, 300]), [[0, 0], [2, 2]]);
        // Cameras that are not in step, and the first right one has no partner.
        assert_eq!(
            of(&[100, 200, 300], &[20, 110, 215, 290]),
            Partners { pairs: vec![[0, 1], [1, 2], [2, 3]], apart: 15 }
        );
        // More than half a period apart.
        assert_eq!(pairs(&[100, 200, 300], &[151, 251, 351]), [[1, 0], [2, 1]]);
        assert!(pairs(&[0, 100], &[1000, 1100]).is_empty());
        // The nearest one, not the first one; in any order of the file.
        assert_eq!(pairs(&[200, 100], &[90, 99, 210]), [[1, 1], [0, 2]]);
        assert_eq!(pairs(&[5], &[7]), [[0, 0]]);
        assert!(pairs(&[], &[7]).is_empty());
        assert_eq!(pairs(&[i64::MIN, i64::MAX], &[i64::MAX, i64::MIN]), [[0, 1], [1, 0]]);
    }
}
