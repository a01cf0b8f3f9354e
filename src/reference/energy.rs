use crate::image_view::check_pair;
use crate::reference::beliefs::messages::weight_and_truncation;
use crate::reference::winner::block_match::correlation_cost;
use crate::reference::{
    BlockStatistics, Channel, Descriptors, Plane, block_statistics, gray, images, matching_cost_scale, pixel_cost,
    rectify,
};
use crate::{Energy, Error, ImageView, Labels, Method, Params, Smoothness};
use rayon::prelude::*;

/// Stage `energy`: what the `labels` of a pair cost in the eyes of the Markov random field that [`Method::Bp`] minimises,
/// whatever method has found them: the smaller, the better. [`Params::labels`] gives the labels.
///
/// ```
/// use gpu_stereo::{Image, Params, Pixels, reference};
/// let texture = |x: u32, y: u32| (x * x * 31 + x * y * 17 + y * 7) as u8;
/// let view = |shift| (0..32 * 8).map(|i| texture(i % 32 + shift, i / 32)).collect();
/// let left = Image::new(32, 8, Pixels::Gray8(view(0)))?;
/// let right = Image::new(32, 8, Pixels::Gray8(view(3)))?;
/// let energy = |mut params: Params| {
///     params.labels = true;
///     let labels = reference::compute_all(&left, &right, &params)?.labels.expect("they were asked for");
///     reference::energy(&left, &right, &labels, &params)
/// };
/// assert!(energy(Params::bp(16))?.sum() <= energy(Params::sgm(16))?.sum());
/// # Ok::<(), gpu_stereo::Error>(())
/// ```
///
/// # Errors
/// [`Error::Misuse`] for [`Method::Psmnet`], which has no cost, and for labels that are not of this pair and these settings;
/// else as [`crate::reference::compute`].
pub fn energy<'a>(
    left: impl Into<ImageView<'a>>,
    right: impl Into<ImageView<'a>>,
    labels: &Labels,
    params: &Params,
) -> Result<Energy, Error> {
    let (left, right) = (left.into(), right.into());
    params.validate()?;
    check_pair([left, right])?;
    ensure_fit(left, labels, params)?;
    let rectified = match &params.rectify {
        Some(rectification) => Some([rectify(left, rectification, 0)?, rectify(right, rectification, 1)?]),
        None => None,
    };
    let pair = rectified.as_ref().map_or([left, right], |pair| pair.each_ref().map(ImageView::from));
    let sides = pair.map(|image| images(image, params).prefiltered(params).descriptors(params));
    Ok(energy_of(&sides, &gray(pair[0], Channel::Luma), &labels.data, &labels.table, params))
}

/// Refuses labels of another pair or of other settings.
fn ensure_fit(image: ImageView<'_>, labels: &Labels, params: &Params) -> Result<(), Error> {
    let misuse = |text: &str| Err(Error::Misuse(text.into()));
    let pixels = image.width() as usize * image.height() as usize;
    if params.method == Method::Psmnet {
        return misuse("method psmnet has no energy, since it has no matching cost; take sgm, bm or bp");
    }
    if (labels.width, labels.height, labels.data.len()) != (image.width(), image.height(), pixels) {
        return misuse("the labels are not of the size of the images; take those of the same pair");
    }
    if labels.data.iter().any(|&label| u32::from(label) >= params.disparities) {
        return misuse("a label is not below the number of disparities; take those of the same settings");
    }
    if labels.table.len() != if params.has_table() { 1 << 16 } else { 0 } {
        return misuse(
            "the labels come without the costs of mi, or with costs of another cost; take those of the settings",
        );
    }
    Ok(())
}

/// [`energy`], from what the cost compares of both sides, and the gray left image.
pub(crate) fn energy_of(
    sides: &[Descriptors; 2],
    gray: &Plane<u8>,
    labels: &[u16],
    table: &[u8],
    params: &Params,
) -> Energy {
    let (width, height) = (gray.width, gray.height);
    let statistics = params.correlates().then(|| block_statistics(&sides[0], &sides[1], params));
    let data = DataTerms { sides, statistics, table, params };
    let between = |p: usize, q: usize| {
        let weight_and_truncation = weight_and_truncation(params, Some([gray.data[p], gray.data[q]]));
        smoothness(labels[p].abs_diff(labels[q]).into(), weight_and_truncation, params.smoothness)
    };
    let row = |y: usize| {
        let mut energy = [data.of_row(y, &labels[y * width..][..width]), 0];
        for x in 0..width {
            let p = y * width + x;
            let neighbours = [(x + 1 < width).then_some(p + 1), (y + 1 < height).then_some(p + width)];
            energy[1] += neighbours.into_iter().flatten().map(|q| u64::from(between(p, q))).sum::<u64>();
        }
        energy
    };
    let sums = (0..height).into_par_iter().map(row).reduce(|| [0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
    Energy { data: sums[0], smoothness: sums[1] }
}

/// What two neighbours cost whose labels differ by k: V of docs/ALGORITHMS.md.
fn smoothness(k: u32, [weight, truncation]: [u32; 2], kind: Smoothness) -> u32 {
    match kind {
        Smoothness::Linear => (weight * k).min(truncation),
        Smoothness::Quadratic => (weight * k * k).min(truncation),
        Smoothness::Potts => truncation * k.min(1),
    }
}

/// What a pixel costs at a label.
struct DataTerms<'a> {
    sides: &'a [Descriptors; 2],
    statistics: Option<[BlockStatistics; 2]>,
    table: &'a [u8],
    params: &'a Params,
}

impl DataTerms<'_> {
    /// What a row costs at its labels. A block sum goes on from the pixel before where that has the same label.
    fn of_row(&self, y: usize, labels: &[u16]) -> u64 {
        let radius = i64::from(self.params.radius());
        let mut before = None;
        let pixel = |(x, &label): (usize, &u16)| {
            let column = x as i64;
            let sum = match before {
                Some((same, sum)) if same == label => {
                    sum + self.column(column + radius, y, label) - self.column(column - radius - 1, y, label)
                }
                _ => (-radius..=radius).map(|i| self.column(column + i, y, label)).sum(),
            };
            before = Some((label, sum));
            u64::from(self.quantised(sum, x, y, label))
        };
        labels.iter().enumerate().map(pixel).sum()
    }

    /// The sum of the pixel costs of a column as high as the block, around (x, y), which may lie outside the image.
    fn column(&self, x: i64, y: usize, label: u16) -> u32 {
        let (radius, [left, right]) = (i64::from(self.params.radius()), self.sides);
        let other = x - i64::from(self.params.min_disparity) - i64::from(label);
        let pair = |y: i64| (left.clamped(x, y), right.clamped(other, y));
        let rows = (y as i64 - radius..=y as i64 + radius).map(pair);
        rows.map(|(left, right)| pixel_cost(left, right, self.table, self.params)).sum()
    }

    /// The quantised cost of a block sum, 0 to 89: that of stage `matching_cost`, also where a method does without it.
    fn quantised(&self, sum: u32, x: usize, y: usize, label: u16) -> u32 {
        let sum = sum >> self.params.narrowing();
        match &self.statistics {
            Some([left, right]) => {
                let other = x as i64 - i64::from(self.params.min_disparity) - i64::from(label);
                (89 * correlation_cost(sum, left.at(x as i64, y), right.at(other, y), self.params) + 4096) >> 13
            }
            None => (sum * matching_cost_scale(self.params) + (1 << 23)) >> 24,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Cost, Image, Pixels, Prefilter, reference};

    /// Labels of other pairs and settings are refused, not counted.
    #[test]
    fn labels_that_do_not_fit_are_refused() {
        let image = Image::new(20, 6, Pixels::Gray8((0..120).map(|i| (i * i % 251) as u8).collect())).unwrap();
        let params = Params { labels: true, ..Params::sgm(8) };
        let labels = reference::compute_all(&image, &image, &params).unwrap().labels.unwrap();
        assert_eq!(energy(&image, &image, &labels, &params).unwrap().data, 0);
        let refused =
            |labels: &Labels, params: &Params| energy(&image, &image, labels, params).unwrap_err().to_string();
        let small = Labels { width: 19, ..labels.clone() };
        assert!(refused(&small, &params).contains("of the size of the images"));
        let mut high = labels.clone();
        high.data[7] = 8;
        assert!(refused(&high, &params).contains("below the number of disparities"));
        let mut of_mi = params.clone();
        (of_mi.cost, of_mi.prefilter) = (Cost::MutualInformation, Prefilter::None);
        assert!(refused(&labels, &of_mi).contains("the costs of mi"));
        let other = Image::new(20, 5, Pixels::Gray8(vec![0; 100])).unwrap();
        assert!(energy(&image, &other, &labels, &params).is_err());
        let network = Params { method: Method::Psmnet, ..params };
        assert!(energy(&image, &image, &labels, &network).is_err());
    }
}
