//! Evidence: the corners that both images of a pair have in common, and what follows from them.

use super::corners::{Corner, Gray, corners};
use super::finding::Finding;
use std::ops::RangeInclusive;

/// The most pixels of an analysed image; larger images are reduced by an integer factor.
const PIXELS: usize = 600_000;
/// With fewer corners nothing is concluded.
const FEWEST: usize = 40;
/// The greatest distance at which two descriptors match, of 256.
const ALIKE: u16 = 72;
/// A rival is farther than this from the best match, in px.
const APART: i32 = 5;
/// How far from its row a partner may lie, in px.
const TOLERANCE: f64 = 1.5;
/// How far beyond the range a disparity may lie, in widths of the range, before it counts as outside.
const SLACK: f64 = 0.12;
/// With fewer gray levels there is nothing to match.
const LEVELS: u8 = 4;

/// A corner in the left image and the same in the right one, by column and row.
#[derive(Clone, Copy, Debug)]
struct Match {
    left: [f64; 2],
    right: [f64; 2],
}

impl Match {
    fn disparity(&self) -> f64 {
        self.left[0] - self.right[0]
    }

    /// By how many rows the partner lies lower.
    fn fall(&self) -> f64 {
        self.right[1] - self.left[1]
    }
}

/// By how many rows the partners of left pixels (x, y) lie lower: a + b x + c y.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Rows([f64; 3]);

impl Rows {
    fn fall(&self, [x, y]: [f64; 2]) -> f64 {
        self.0[0] + self.0[1] * x + self.0[2] * y
    }

    fn fits(&self, found: &Match) -> bool {
        (found.fall() - self.fall(found.left)).abs() <= TOLERANCE
    }
}

/// What a pair's corners show, whatever range is searched.
#[derive(Debug)]
pub struct Evidence {
    /// What is wrong whatever range is searched.
    always: Option<Finding>,
    /// Disparities of corners, in px of the given images, if these are related.
    disparities: Vec<f64>,
}

impl Evidence {
    /// Looks at a pair of one size.
    pub fn of(left: &Gray, right: &Gray) -> Self {
        if left.data == right.data {
            return Self::only(Finding::Same);
        }
        let levels = [left, right].map(|image| {
            let (least, most) = image.data.iter().fold((u8::MAX, 0), |(a, b), &v| (a.min(v), b.max(v)));
            most.saturating_sub(least)
        });
        if let Some(side) = levels.iter().position(|&levels| levels < LEVELS) {
            return Self::only(Finding::Flat { side: ["left", "right"][side], levels: levels[side] });
        }
        let factor = ((left.width * left.height) as f64 / PIXELS as f64).sqrt().ceil().max(1.0) as usize;
        let (left, right) = (left.reduced(factor), right.reduced(factor));
        let (a, b) = rayon::join(|| corners(&left), || corners(&right));
        if a.len().max(b.len()) < FEWEST {
            return Self { always: None, disparities: Vec::new() };
        }
        let distances = Distances::new(&a, &b);
        let free = distances.matches(&a, &b, |_, _| true);
        let rows = fitted(&free);
        let fitting = free.iter().filter(|found| rows.fits(found)).count();
        // Even a mirrored image has corners that look alike, in the same rows.
        if 10 * fitting < 6 * free.len().max(FEWEST)
            && let Some(turned) = turned(&a, &right, fitting)
        {
            return Self::only(turned);
        }
        if !is_related(fitting, free.len()) {
            // In a repeating pattern every corner has many equal partners, so none is unique.
            if 2 * distances.very_alike() >= a.len() {
                return Self { always: None, disparities: Vec::new() };
            }
            return Self::only(Finding::Unrelated { found: fitting, of: a.len() });
        }
        // In the known rows a partner has fewer rivals.
        let near = |a: &Corner, b: &Corner| {
            (f64::from(b.y - a.y) - rows.fall([a.x.into(), a.y.into()])).abs() <= TOLERANCE + 0.5
        };
        let found = supported(&distances.matches(&a, &b, near));
        let scale = factor as f64;
        let falls: Vec<_> = found.iter().map(|found| scale * rows.fall(found.left).abs()).collect();
        // A corner of an image that was saved again may lie a pixel beside.
        let within = |px: f64| {
            let is_still = |found: &&Match| found.disparity().abs() <= px && found.fall().abs() <= px;
            found.iter().filter(is_still).count()
        };
        let is_same =
            found.len() >= FEWEST / 2 && 20 * within(1.5) >= 19 * found.len() && 2 * within(0.5) >= found.len();
        let (mean, most) =
            (falls.iter().sum::<f64>() / falls.len().max(1) as f64, falls.iter().fold(0.0, |a: f64, &b| a.max(b)));
        let always = if is_same {
            Some(Finding::Same)
        } else if fitting >= 16 && (mean >= 0.7 || most >= 1.4) {
            let middle = [left.width as f64 / 2.0, left.height as f64 / 2.0];
            let degrees = rows.0[1].atan().to_degrees();
            Some(Finding::Rows { offset: scale * rows.fall(middle), degrees, most })
        } else {
            None
        };
        Self { always, disparities: found.iter().map(|found| scale * found.disparity()).collect() }
    }

    fn only(finding: Finding) -> Self {
        Self { always: Some(finding), disparities: Vec::new() }
    }

    /// What is wrong when the disparities of `range` are searched: the first cause, not what follows from it.
    pub fn finding(&self, range: &RangeInclusive<i32>) -> Option<Finding> {
        match &self.always {
            Some(Finding::Rows { .. }) => {}
            Some(other) => return Some(other.clone()),
            None => {}
        }
        let mut disparities = self.disparities.clone();
        disparities.sort_by(f64::total_cmp);
        let of = disparities.len();
        if of < FEWEST / 4 {
            return self.always.clone();
        }
        let (first, last) = (f64::from(*range.start()), f64::from(*range.end()));
        let count = |is: &dyn Fn(f64) -> bool| disparities.iter().filter(|&&d| is(d)).count();
        // Far points do not show which side is which.
        let (negative, positive) = (count(&|d| d < -1.5), count(&|d| d > 1.5));
        let outside = count(&|d| d < -1.5 && d < first - 1.0);
        if negative * 6 >= of && negative >= 4 * positive && 2 * outside >= negative {
            return Some(Finding::Exchanged { negative, of });
        }
        if self.always.is_some() {
            return self.always.clone();
        }
        // A few pixels more are no reason to search again.
        let slack = 1.0 + SLACK * (last - first + 1.0);
        let (below, above) = (count(&|d| d < first - slack), count(&|d| d > last + slack));
        let many = |count: usize| count * 20 >= of && count >= 5;
        if !many(below) && !many(above) {
            return None;
        }
        // All but a few, which may be wrong.
        let few = of / 100;
        let (least, most) = (disparities[few].floor() as i32, disparities[of - 1 - few].ceil() as i32);
        let needed = (*range.start()).min(least)..=(*range.end()).max(most);
        Some(Finding::Range { searched: range.clone(), needed, share: (below + above) as f64 / of as f64, of })
    }
}

/// Whether so many matches in common rows cannot be chance.
fn is_related(fitting: usize, of: usize) -> bool {
    fitting >= 8 && 10 * fitting >= 3 * of
}

/// How the right image would have to be turned or mirrored to match the left one.
/// `before`: the matches in common rows as it is.
fn turned(left: &[Corner], right: &Gray, before: usize) -> Option<Finding> {
    let (width, height) = (right.width, right.height);
    // Whether columns and rows run backwards.
    let ways = [
        ("upside down", [true, true]),
        ("mirrored left to right", [true, false]),
        ("mirrored top to bottom", [false, true]),
    ];
    ways.into_iter().find_map(|(how, [columns, rows])| {
        let place =
            |x: usize, y: usize| (if columns { width - 1 - x } else { x }, if rows { height - 1 - y } else { y });
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| place(x, y)));
        let data = pixels.map(|(x, y)| right.data[y * width + x]).collect();
        let right = corners(&Gray { width, height, data });
        let free = Distances::new(left, &right).matches(left, &right, |_, _| true);
        let rows = fitted(&free);
        let fitting = free.iter().filter(|found| rows.fits(found)).count();
        (is_related(fitting, free.len()) && fitting >= 2 * before).then_some(Finding::Turned { how })
    })
}

/// In how many bits each left corner differs from each right one.
struct Distances {
    columns: usize,
    all: Vec<u16>,
}

impl Distances {
    fn new(left: &[Corner], right: &[Corner]) -> Self {
        let all = left.iter().flat_map(|a| right.iter().map(|b| a.distance(b) as u16)).collect();
        Self { columns: right.len(), all }
    }

    /// Left corners that look almost like some right one.
    fn very_alike(&self) -> usize {
        self.all.chunks(self.columns.max(1)).filter(|row| row.iter().any(|&distance| 2 * distance <= ALIKE)).count()
    }

    /// Corners that are each other's best among those `allowed`, and clearly better than any rival elsewhere.
    fn matches(&self, left: &[Corner], right: &[Corner], allowed: impl Fn(&Corner, &Corner) -> bool) -> Vec<Match> {
        let mut best_of_right = vec![(u16::MAX, usize::MAX); right.len()];
        let mut best_of_left = Vec::with_capacity(left.len());
        for (i, a) in left.iter().enumerate() {
            let row = &self.all[i * self.columns..][..self.columns];
            let candidates = || right.iter().zip(row).enumerate().filter(|(_, (b, _))| allowed(a, b));
            let mut best = None;
            for (j, (_, &distance)) in candidates() {
                best_of_right[j] = best_of_right[j].min((distance, i));
                best = Some(best.unwrap_or((u16::MAX, usize::MAX)).min((distance, j)));
            }
            let clear = best.filter(|&(least, j)| {
                let far = |b: &Corner| (b.x - right[j].x).abs().max((b.y - right[j].y).abs()) > APART;
                let is_rival = |distance: u16| 5 * u32::from(least) >= 4 * u32::from(distance);
                least <= ALIKE && !candidates().any(|(_, (b, &distance))| is_rival(distance) && far(b))
            });
            best_of_left.push(clear.map(|(_, j)| j));
        }
        let pairs = best_of_left.iter().enumerate().filter_map(|(i, &j)| Some((i, j?)));
        let place = |corner: &Corner| [f64::from(corner.x), f64::from(corner.y)];
        let mutual = pairs.filter(|&(i, j)| best_of_right[j].1 == i);
        mutual.map(|(i, j)| Match { left: place(&left[i]), right: place(&right[j]) }).collect()
    }
}

/// Matches with a neighbour of similar disparity, which chance matches do not have.
fn supported(all: &[Match]) -> Vec<Match> {
    const NEIGHBOURS: usize = 6;
    let has_support = |i: usize| {
        let Match { left: [x, y], .. } = all[i];
        let square = |other: &Match| (other.left[0] - x).powi(2) + (other.left[1] - y).powi(2);
        let others = all.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, other)| (square(other), other));
        let mut others: Vec<_> = others.collect();
        let wanted = NEIGHBOURS.min(others.len());
        if wanted < others.len() {
            others.select_nth_unstable_by(wanted, |a, b| a.0.total_cmp(&b.0));
        }
        let disparity = all[i].disparity();
        let near = |other: &Match| (other.disparity() - disparity).abs() <= (0.1 * disparity.abs()).max(3.0);
        others[..wanted].iter().any(|(_, other)| near(other))
    };
    (0..all.len()).filter(|&i| has_support(i)).map(|i| all[i]).collect()
}

/// The row offsets that most matches fit: RANSAC over planes through three matches, then least squares.
fn fitted(all: &[Match]) -> Rows {
    let count = |rows: &Rows| all.iter().filter(|found| rows.fits(found)).count();
    let mut best = (count(&Rows::default()), Rows::default());
    if all.len() < 3 {
        return best.1;
    }
    let mut state = 1_u64;
    for _ in 0..300 {
        let picked = [(); 3].map(|()| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            all[(state >> 33) as usize % all.len()]
        });
        let Some(rows) = plane(&picked) else { continue };
        let fitting = count(&rows);
        if fitting > best.0 {
            best = (fitting, rows);
        }
    }
    for _ in 0..3 {
        let fitting: Vec<_> = all.iter().filter(|found| best.1.fits(found)).copied().collect();
        let Some(rows) = plane(&fitting) else { break };
        best.1 = rows;
    }
    best.1
}

/// Least squares; `None` if the matches are degenerate or the result is beyond any plausible rotation.
fn plane(of: &[Match]) -> Option<Rows> {
    let n = of.len() as f64;
    let mean = |value: &dyn Fn(&Match) -> f64| of.iter().map(value).sum::<f64>() / n;
    let (x, y, fall) = (mean(&|m| m.left[0]), mean(&|m| m.left[1]), mean(&Match::fall));
    let product = |a: &dyn Fn(&Match) -> f64, b: &dyn Fn(&Match) -> f64| mean(&|m| a(m) * b(m));
    let (dx, dy, df) = (|m: &Match| m.left[0] - x, |m: &Match| m.left[1] - y, |m: &Match| m.fall() - fall);
    let (xx, xy, yy) = (product(&dx, &dx), product(&dx, &dy), product(&dy, &dy));
    let (xf, yf) = (product(&dx, &df), product(&dy, &df));
    let determinant = xx * yy - xy * xy;
    if determinant < 1.0 || determinant < 1e-3 * xx * yy {
        return None;
    }
    let (b, c) = ((xf * yy - yf * xy) / determinant, (yf * xx - xf * xy) / determinant);
    (b.abs() < 0.2 && c.abs() < 0.2).then_some(Rows([fall - b * x - c * y, b, c]))
}
