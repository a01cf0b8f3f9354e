//! The comparison of what each kind of step writes with the reference.

use crate::PixelFormat;
use crate::check::StageCheck;
use crate::gpu::check::expected::Expected;
use crate::gpu::layout::Rows;
use crate::gpu::maps::{confidence_of, depth_of, labels_of, map_of};
use crate::gpu::plan::penalty_bytes;
use crate::gpu::recording::{Level, Written};
use crate::params::Filter;
use crate::reference::{self, Direction, Volume};
use crate::{DisparityMap, Params};

/// What a step wrote, and what the reference gives.
pub(super) struct Comparison<'a> {
    pub(super) level: &'a Level,
    pub(super) format: PixelFormat,
    /// What the step's buffer holds.
    pub(super) bytes: Vec<u8>,
    /// Of both views: what the buffer of the right one holds.
    pub(super) right: Vec<u8>,
    pub(super) expected: &'a mut Expected,
    pub(super) stage: &'a mut StageCheck,
}

impl Comparison<'_> {
    /// Compares all elements.
    pub(super) fn run(&mut self, written: &Written) {
        match written {
            Written::Part => {}
            Written::Rectified { side } => self.rectified(*side),
            Written::Gray { side, channel, deep } => self.gray(*side, *channel, *deep),
            Written::WindowSums { side, channel, filtered, window } => {
                self.window_sums(*side, *channel, *filtered, *window);
            }
            Written::Prefiltered { side, channel } => {
                let plane = &self.expected.prefiltered[*side].channels[*channel];
                self.level.compare_picture(self.stage, &self.bytes, |x, y| plane.clamped(x, y));
            }
            Written::Descriptors { side, first, count, rows } => self.descriptors(*side, *first, *count, *rows),
            Written::FeatureStatistics { side } => self.feature_statistics(*side),
            Written::FeatureLayer { side, layer, rows } => self.feature_layer(*side, *layer, *rows),
            Written::Features { side, rows } => self.features(*side, *rows),
            Written::Values { side } => {
                let values = &self.expected.pyramid[self.level.halvings as usize][*side];
                self.level.compare_picture(self.stage, &self.bytes, |x, y| values.clamped(x, y)[0].into());
            }
            Written::Histogram => {
                let counts = bytemuck::pod_collect_to_vec::<u8, u32>(&self.bytes);
                compare_each(self.stage, 256, &self.expected.counts, &counts);
            }
            Written::Table => compare_each(self.stage, 256, &self.expected.table, &self.bytes),
            Written::Columns { chunk } => self.columns(*chunk),
            Written::BlockStatistics { side, chunk } => self.block_statistics(*side, *chunk),
            Written::Penalties { direction } => self.penalties(*direction),
            Written::Cost { chunk, volume_row } => self.cost(*chunk, *volume_row),
            Written::Paths { directions, band, volume_row, .. } => self.paths(directions, *band, *volume_row),
            Written::SecondCost { rows, volume_row, last } => self.second_cost(*rows, *volume_row, *last),
            Written::CoarseCost { level, band } => self.coarse_cost(*level, *band),
            Written::Messages { level, band, .. } => self.messages(*level, *band),
            Written::Layer { operation, at, .. } => self.layer(*operation, *at),
            Written::Rounded => self.rounded(),
            Written::Views { .. } => self.views(),
            Written::Mirrored => {
                let matched = reference::mirror(&self.expected.views().left);
                self.map(&matched);
                self.expected.matched = Some(matched);
            }
            Written::Validity { side } => self.validity(*side),
            Written::Filter(filter) => self.filter(*filter),
            Written::Confidence => self.confidence(),
            Written::Depth => self.depth(),
        }
    }

    fn params(&self) -> &Params {
        &self.level.params
    }

    fn width(&self) -> usize {
        self.level.sizes.frame.width as usize
    }

    /// Compares the map of the step.
    pub(super) fn map(&mut self, expected: &DisparityMap) {
        compare_maps(self.stage, expected, &map_of(&self.level.sizes.frame, &self.bytes));
    }

    fn rectified(&mut self, side: usize) {
        let row = self.width() * self.format.bytes_per_pixel() as usize;
        if let Some(images) = &self.expected.rectified {
            compare_each(self.stage, row, images[side].bytes(), &self.bytes);
        }
    }

    fn gray(&mut self, side: usize, channel: usize, deep: bool) {
        let Self { level, bytes, expected, stage, .. } = self;
        if channel == 0 && !deep {
            let plane = &expected.luma[side];
            return level.compare_picture(stage, bytes, |x, y| plane.clamped(x, y));
        }
        let plane = &expected.images[side].channels[channel.saturating_sub(1)];
        if deep {
            let values: Vec<u16> = bytes.chunks_exact(2).map(|v| u16::from_le_bytes([v[0], v[1]])).collect();
            level.compare_picture(stage, &values, |x, y| plane.clamped(x, y));
        } else {
            level.compare_picture(stage, bytes, |x, y| plane.clamped(x, y));
        }
    }

    fn window_sums(&mut self, side: usize, channel: usize, filtered: bool, window: u32) {
        let width = self.width();
        let images = if filtered { &self.expected.prefiltered } else { &self.expected.images };
        let plane = &images[side].channels[channel];
        let sums = bytemuck::pod_collect_to_vec::<u8, u32>(&self.bytes);
        for (i, &got) in sums.iter().enumerate() {
            let (x, y) = (i % width, i / width);
            let sum = reference::window_sum(plane, window, x as i64, y as i64);
            self.stage.compare(x, y, None, sum.into(), got.into());
        }
    }

    fn descriptors(&mut self, side: usize, first: usize, count: usize, held: Rows) {
        let frame = &self.level.sizes.frame;
        let descriptors = &self.expected.pyramid[self.level.halvings as usize][side];
        let stride = 4 * [frame.left_stride, frame.right_stride][side] as usize;
        let (width, reach) = (i64::from(frame.width), i64::from(frame.block_radius));
        let plane = held.count as usize;
        let rows = self.bytes.chunks_exact(stride).enumerate().skip(first * plane);
        for (row, bytes) in rows.take(count * plane) {
            let (p, y) = (row / plane, held.first as usize + row % plane);
            for (j, &got) in bytes.iter().enumerate() {
                let x = match side {
                    0 => j as i64 - reach,
                    _ => width - 1 + reach - i64::from(frame.min_disparity) - j as i64,
                };
                self.stage.compare(j, y, None, descriptors.clamped(x, y as i64)[p].into(), got.into());
            }
        }
    }

    fn columns(&mut self, chunk: Rows) {
        let (disparities, wide) = (self.params().disparities as usize, self.params().wide_sums());
        let (columns, padded) = (&self.expected.columns, 16 * self.params().quads() as usize);
        for (y, row) in each_row(chunk, &self.bytes, self.level.sizes.columns_row) {
            let sum_bytes = if wide { 4 } else { 2 };
            for (c, values) in row.chunks_exact(sum_bytes * padded).enumerate() {
                let expected = &columns.data[(y * columns.width + c) * disparities..][..disparities];
                for (d, &expected) in expected.iter().enumerate() {
                    let at = pair_place(d);
                    let got = match wide {
                        true => bytemuck::pod_read_unaligned::<u32>(&values[4 * d..][..4]),
                        false => u16::from_le_bytes([values[at], values[at + 1]]).into(),
                    };
                    self.stage.compare(c, y, Some(d), expected.into(), got.into());
                }
            }
        }
    }

    fn block_statistics(&mut self, side: usize, chunk: Rows) {
        let width = self.width();
        let Some(statistics) = &self.expected.statistics else { return };
        let numbers = bytemuck::pod_collect_to_vec::<u8, u32>(&self.bytes);
        let columns = &statistics[side].columns;
        let count = (columns.end - columns.start) as usize;
        let row_numbers = self.level.sizes.statistics_row as usize / 4;
        for (row, y) in (chunk.first..chunk.end()).enumerate() {
            let found = &numbers[row * row_numbers + 2 * side * width..][..2 * count];
            for (i, found) in found.chunks_exact(2).enumerate() {
                let x = if side == 0 { i as i64 } else { columns.end - 1 - i as i64 };
                for (&expected, &got) in statistics[side].at(x, y as usize).iter().zip(found) {
                    self.stage.compare(i, y as usize, None, expected.into(), got.into());
                }
            }
        }
    }

    fn penalties(&mut self, direction: Direction) {
        let width = self.width();
        let k = Direction::FORWARD.iter().position(|forward| *forward == direction);
        let (Some(penalties), Some(k)) = (&self.expected.penalties, k) else { return };
        let (dx, dy) = (direction.dx as isize, direction.dy as usize);
        let each = penalty_bytes(self.params()) as usize;
        for (i, values) in penalties.data.chunks_exact(penalties.disparities).enumerate() {
            let (x, y) = (i % width, i / width);
            let (line, place) = match dy {
                0 => (y * (width / 16 + 1), x),
                _ => {
                    let column = (x as isize - dx * (y / dy) as isize).rem_euclid(width as isize);
                    (y % dy * width + column as usize, y / dy)
                }
            };
            for (i, &expected) in values[each * k..][..each].iter().enumerate() {
                let got = match dy {
                    0 => self.bytes[each * (16 * line + place) + i],
                    _ => {
                        let vector = line + each * place / 16 * dy * width;
                        self.bytes[16 * vector + each * place % 16 + i]
                    }
                };
                self.stage.compare(x, y, Some(each * k + i), expected.into(), got.into());
            }
        }
    }

    /// Compares some rows of a volume; `expected` gives the value of an index of the reference's.
    fn volume(&mut self, rows: Rows, volume_row: u32, expected: impl Fn(&Expected, usize) -> i64) {
        let (width, disparities) = (self.width(), self.params().disparities as usize);
        let (stride, padded) = (self.level.sizes.volume_row, 16 * self.params().quads() as usize);
        let first = u64::from(volume_row) * stride;
        for (y, row) in each_row(rows, &self.bytes[first as usize..], stride) {
            for (x, values) in row.chunks_exact(padded).take(width).enumerate() {
                for (d, &got) in values[..disparities].iter().enumerate() {
                    let expected = expected(self.expected, (y * width + x) * disparities + d);
                    self.stage.compare(x, y, Some(d), expected, got.into());
                }
            }
        }
    }

    fn cost(&mut self, chunk: Rows, volume_row: u32) {
        self.volume(chunk, volume_row, |expected, i| expected.cost.data[i].into());
    }

    fn paths(&mut self, directions: &[Direction], band: Rows, volume_row: u32) {
        for &direction in directions {
            self.expected.path(direction);
        }
        // The device keeps T = L - C, summed over the directions so far.
        let known: Vec<usize> =
            (0..self.expected.paths.len()).filter(|&i| directions.contains(&self.expected.paths[i].0)).collect();
        self.volume(band, volume_row, |expected, i| {
            let cost = i64::from(expected.cost.data[i]);
            let volume = |&path: &usize| -> &Volume<u8> { &expected.paths[path].1 };
            known.iter().map(|path| i64::from(volume(path).data[i]) - cost).sum()
        });
    }

    fn second_cost(&mut self, rows: Rows, volume_row: u32, last: bool) {
        self.expected.second_cost();
        self.volume(rows, volume_row, |expected, i| expected.second.as_ref().map_or(0, |second| second.data[i].into()));
        if last {
            self.expected.begin_second_pass();
        }
    }

    fn coarse_cost(&mut self, level: usize, band: usize) {
        let (scale, quads) = (&self.level.sizes.scales[level], self.params().quads());
        let (rows, stride) = (scale.bands[band], 32 * u64::from(quads) * u64::from(scale.stride));
        let expected = &self.expected.coarse[level - 1];
        for (y, row) in each_row(rows, &self.bytes, stride) {
            for (x, values) in row.chunks_exact(32 * quads as usize).take(expected.width).enumerate() {
                for d in 0..expected.disparities {
                    let at = pair_place(d);
                    let got = u16::from_le_bytes([values[at], values[at + 1]]);
                    let expected = expected.data[(y * expected.width + x) * expected.disparities + d];
                    self.stage.compare(x, y, Some(d), expected.into(), got.into());
                }
            }
        }
    }

    fn messages(&mut self, level: usize, band: usize) {
        let (scale, quads) = (&self.level.sizes.scales[level], self.params().quads());
        let (rows, stride) = (scale.bands[band], 16 * u64::from(quads) * u64::from(scale.stride));
        let volumes = self.bytes.chunks_exact(scale.volume(band, quads) as usize);
        // The device has what pixels send up, down, left and right, the reference what they receive.
        let received = self.expected.messages[level].received.iter().rev();
        for ((expected, bytes), (dx, dy)) in received.zip(volumes).zip([(0, -1), (0, 1), (-1, 0), (1, 0)]) {
            for (y, row) in each_row(rows, bytes, stride) {
                for (x, values) in row.chunks_exact(16 * quads as usize).take(expected.width).enumerate() {
                    let (u, v) = (x.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
                    // A pixel alone sends nothing, and there is nothing.
                    let alone = expected.width * expected.height == 1;
                    let (u, v) = if alone { (x, y) } else { (u, v) };
                    if u < expected.width && v < expected.height {
                        let expected = &expected.data[(v * expected.width + u) * expected.disparities..];
                        for (d, &got) in values[..self.params().disparities as usize].iter().enumerate() {
                            self.stage.compare(x, y, Some(d), expected[d].into(), got.into());
                        }
                    }
                }
            }
        }
    }

    fn views(&mut self) {
        let Self { level, bytes, right, expected, stage, .. } = self;
        let (frame, sizes) = (&level.sizes.frame, &level.sizes);
        let [wanted, labelled] = [expected.params.confidence, expected.params.labels];
        let views = expected.views();
        compare_maps(stage, &views.left, &map_of(frame, bytes));
        compare_maps(stage, &views.right, &map_of(frame, right));
        if wanted {
            let margins = map_of(frame, &right[sizes.map as usize..]);
            compare_each(stage, frame.width as usize, &views.margins.data, &margins.data);
        }
        if labelled {
            let labels = labels_of(frame, &right[(sizes.right_map - sizes.map) as usize..], &[]);
            compare_each(stage, frame.width as usize, &views.labels, &labels.data);
        }
        expected.checked = Some(views.left.clone());
    }

    fn validity(&mut self, side: usize) {
        let Some(content) = self.expected.content() else { return };
        let map = if side == 0 { self.expected.checked.take() } else { Some(self.expected.right_view()) };
        let Some(valid) = map.map(|map| reference::validity(&map, &content, side)) else { return };
        self.map(&valid);
        let kept = if side == 0 { &mut self.expected.checked } else { &mut self.expected.right };
        *kept = Some(valid);
    }

    fn filter(&mut self, filter: Filter) {
        if let Some(filtered) = self.expected.filtered(filter, &self.level.params) {
            self.map(&filtered);
            self.expected.checked = Some(filtered);
        }
    }

    fn confidence(&mut self) {
        let Some(map) = self.expected.checked.clone() else { return };
        let confidence = reference::confidence(&map, &self.expected.views().margins);
        let got = confidence_of(&self.level.sizes.frame, &self.bytes);
        compare_each(self.stage, self.width(), &confidence.data, &got.data);
    }

    fn depth(&mut self) {
        let (Some(map), Some(camera)) = (&self.expected.checked, &self.level.params.depth) else { return };
        let depth = reference::depth(map, camera);
        let got = depth_of(&self.level.sizes.frame, &self.bytes);
        compare_each(self.stage, self.width(), &depth.data, &got.data);
    }
}

impl Level {
    /// Compares an image laid out with 16 columns before the first one.
    fn compare_picture<T: Copy + Into<i64>>(
        &self,
        stage: &mut StageCheck,
        values: &[T],
        expected: impl Fn(i64, i64) -> i32,
    ) {
        let frame = &self.sizes.frame;
        for (y, row) in values.chunks_exact(16 * frame.gray_stride as usize).take(frame.height as usize).enumerate() {
            for (j, &got) in row.iter().enumerate() {
                stage.compare(j, y, None, expected(j as i64 - 16, y as i64).into(), got.into());
            }
        }
    }
}

/// Where a value of 16 bits lies, two of which are in a word: of disparities 4k .. 4k + 3 the even two, then the odd two.
fn pair_place(d: usize) -> usize {
    2 * (d / 4 * 4 + d % 2 * 2 + d / 2 % 2)
}

/// The rows of a buffer with `stride` bytes a row.
fn each_row(rows: Rows, bytes: &[u8], stride: u64) -> impl Iterator<Item = (usize, &[u8])> {
    (rows.first as usize..).zip(bytes.chunks_exact(stride as usize)).take(rows.count as usize)
}

/// Compares values row by row, `width` a row.
fn compare_each<E: Copy + Into<i64>, G: Copy + Into<i64>>(
    stage: &mut StageCheck,
    width: usize,
    expected: &[E],
    got: &[G],
) {
    for (i, (&expected, &got)) in expected.iter().zip(got).enumerate() {
        stage.compare(i % width, i / width, None, expected.into(), got.into());
    }
}

fn compare_maps(stage: &mut StageCheck, expected: &DisparityMap, got: &DisparityMap) {
    compare_each(stage, expected.width as usize, &expected.data, &got.data);
}
