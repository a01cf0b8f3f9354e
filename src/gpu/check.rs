//! The comparison of every stage's buffer with the reference.

use crate::gpu::layout::{Frame, Rows};
use crate::gpu::matcher::{confidence_of, depth_of, map_of};
use crate::gpu::recording::{Level, Output, Step, record_steps};
use crate::gpu::{readback, scopes};
use crate::reference::{
    self, BlockStatistics, Channel, Content, Descriptors, Direction, Images, Plane, Round, Views, Volume,
};
use crate::{Cost, DisparityMap, Error, Image, Method, Params, StereoMatcher};

/// The first element of a stage that differs from the reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Mismatch {
    /// Column; of a gray, a prefiltered or a rectified image the byte of its row, of column sums the column plus the block's radius,
    /// of statistics of blocks their place in a row.
    pub x: u32,
    /// Row.
    pub y: u32,
    /// Index of the disparity, for stages that have one value for each.
    pub d: Option<u32>,
    /// What the reference says.
    pub expected: i64,
    /// What the device left.
    pub got: i64,
}

/// What became of one stage.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct StageCheck {
    /// The stage's name, as in docs/ALGORITHMS.md.
    pub stage: String,
    /// Elements compared.
    pub elements: u64,
    /// Elements that differ.
    pub mismatches: u64,
    /// The first of them in order of computation.
    pub first: Option<Mismatch>,
}

impl StageCheck {
    /// Compares one element.
    fn compare(&mut self, x: usize, y: usize, d: Option<usize>, expected: i64, got: i64) {
        self.elements += 1;
        if expected != got {
            self.mismatches += 1;
            self.first.get_or_insert(Mismatch { x: x as u32, y: y as u32, d: d.map(|d| d as u32), expected, got });
        }
    }
}

/// What buffers hold before a stage writes them: "wrote nothing" must differ from "wrote 0".
const SENTINEL: u8 = 0xa5;

/// The reference's buffers, each computed when a step asks for it.
struct Expected {
    /// The rectified pair, until the chain goes on with it.
    rectified: Option<[Image; 2]>,
    /// The left view of the mirrored pair, mirrored, if it was matched before.
    matched: Option<DisparityMap>,
    /// Where the pair has content, if not everywhere.
    content: Option<Content>,
    /// The right view after `validity`.
    right: Option<DisparityMap>,
    luma: [Plane<u8>; 2],
    images: [Images; 2],
    prefiltered: [Images; 2],
    /// What the cost compares of both images, halved ever more often.
    pyramid: Vec<[Descriptors; 2]>,
    rounds: Vec<Round>,
    /// The round to which what follows belongs, and its settings.
    level: Option<usize>,
    params: Params,
    counts: Vec<u32>,
    table: Vec<u8>,
    penalties: Option<Volume<u8>>,
    columns: Volume<u32>,
    statistics: Option<[BlockStatistics; 2]>,
    cost: Volume<u8>,
    paths: Vec<(Direction, Volume<u8>)>,
    views: Option<Views>,
    /// The map of the last stage that left one.
    checked: Option<DisparityMap>,
}

impl Expected {
    fn new(params: &Params, left: &Image, right: &Image, content: Option<Content>) -> Self {
        let luma = [left, right].map(|image| reference::gray(image, Channel::Luma));
        let images = [left, right].map(|image| reference::images(image, params));
        let prefiltered = [0, 1].map(|side: usize| images[side].prefiltered(params));
        let mut pyramid = vec![[0, 1].map(|side: usize| prefiltered[side].descriptors(params))];
        let rounds = reference::rounds(left.width(), left.height(), params);
        for _ in 0..rounds[0].halvings {
            pyramid.push(pyramid[pyramid.len() - 1].each_ref().map(reference::halve));
        }
        Self {
            rectified: None,
            matched: None,
            content,
            right: None,
            luma,
            images,
            prefiltered,
            pyramid,
            rounds,
            level: None,
            params: params.clone(),
            counts: Vec::new(),
            table: Vec::new(),
            penalties: None,
            columns: Volume::new(0, 0, 0),
            statistics: None,
            cost: Volume::new(0, 0, 0),
            paths: Vec::new(),
            views: None,
            checked: None,
        }
    }

    /// Goes on with another round.
    fn enter(&mut self, level: usize) {
        let before = self.level.replace(level);
        if before == Some(level) {
            return;
        }
        let Round { halvings, params } = self.rounds[level].clone();
        let [left, right] = &self.pyramid[halvings as usize];
        if params.cost == Cost::MutualInformation {
            let halved = before.map_or(0, |before| self.rounds[before].halvings - halvings);
            self.counts = reference::mi_histogram(left, right, self.checked.as_ref(), halved);
            self.table = reference::mi_table(&self.counts, (left.width * left.height) as u64);
        }
        let adaptive = params.adaptive_p2 && params.method == Method::Sgm;
        self.penalties = adaptive.then(|| reference::penalties(&self.luma[0], &params));
        self.columns = reference::cost_columns(left, right, &self.table, &params);
        let correlates = params.cost == Cost::Ncc;
        self.statistics = correlates.then(|| reference::block_statistics(left, right, &params));
        if params.method == Method::Sgm {
            self.cost = reference::matching_cost(&self.columns, &params);
        }
        (self.paths, self.views, self.params) = (Vec::new(), None, params);
        (self.checked, self.right) = (None, None);
    }

    fn path(&mut self, direction: Direction) -> &Volume<u8> {
        let known = self.paths.iter().position(|(known, _)| *known == direction);
        let i = known.unwrap_or_else(|| {
            let volume = reference::aggregate_direction(&self.cost, self.penalties.as_ref(), direction, &self.params);
            self.paths.push((direction, volume));
            self.paths.len() - 1
        });
        &self.paths[i].1
    }

    /// The right view that the filters read.
    fn right_view(&mut self) -> DisparityMap {
        match (&self.right, &self.matched) {
            (Some(right), _) => right.clone(),
            (None, Some(matched)) if self.level == Some(self.rounds.len() - 1) => matched.clone(),
            _ => self.views().right.clone(),
        }
    }

    /// Where the images of the round have content.
    fn content(&self) -> Option<Content> {
        let halvings = self.rounds[self.level?].halvings;
        self.content.as_ref().map(|content| content.halved(halvings))
    }

    /// The map that a stage after the winner makes of the one before it; `None` where there is none or it is no such stage.
    fn filtered(&mut self, stage: &Output, params: &Params) -> Option<DisparityMap> {
        let map = self.checked.take()?;
        let luma = &self.luma[0];
        Some(match stage {
            Output::Validity { side: 0 } => reference::validity(&map, &self.content()?, 0),
            Output::Textured => reference::texture(&map, luma, params),
            Output::Checked => reference::lr_check(&map, &self.right_view(), params.lr_check?),
            Output::Speckle => reference::speckle(&map, params.speckle_window, params.speckle_range),
            Output::Median => reference::median(&map, params.median.side()?),
            Output::Fill => reference::fill(&map, &self.right_view(), params),
            Output::WeightedMedian => reference::weighted_median(&map, luma, params.weighted_median?, params),
            Output::Wls => reference::wls(&map, luma, params.wls.as_ref()?, params),
            _ => return None,
        })
    }

    fn views(&mut self) -> &Views {
        if self.views.is_none() {
            let params = &self.params.clone();
            let views = match params.method {
                Method::Bm => reference::block_match(&self.columns, self.statistics.as_ref(), params),
                Method::Sgm => {
                    let cost = &self.cost;
                    let mut sum = Volume::<u16>::new(cost.width, cost.height, cost.disparities);
                    for direction in Direction::all(params.paths) {
                        for (sum, &path) in sum.data.iter_mut().zip(&self.path(direction).data) {
                            *sum += u16::from(path);
                        }
                    }
                    self.paths = Vec::new();
                    reference::winner(&sum, params)
                }
            };
            self.views = Some(views);
        }
        match &self.views {
            Some(views) => views,
            None => unreachable!("set above"),
        }
    }
}

fn each_row(rows: Rows, bytes: &[u8], stride: u64) -> impl Iterator<Item = (usize, &[u8])> {
    (rows.first as usize..).zip(bytes.chunks_exact(stride as usize)).take(rows.count as usize)
}

impl StereoMatcher {
    /// Computes a pair step by step and compares what each step left with the reference, element by element.
    ///
    /// Before a step its buffer is filled with a pattern, so that an element that is never written is found. The host
    /// needs memory for the reference's volumes: a byte a pixel and disparity for the cost and for each direction, and
    /// two for the column sums and for the aggregate. The reference is computed where the future is polled.
    ///
    /// # Errors
    /// As [`StereoMatcher::compute`].
    pub async fn check(&self, left: &Image, right: &Image) -> Result<Vec<StageCheck>, Error> {
        self.check_spoiled(left, right, &mut |_, _| {}).await
    }

    /// As [`StereoMatcher::check`]; blocks until all is compared.
    ///
    /// # Errors
    /// As [`StereoMatcher::compute`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn check_blocking(&self, left: &Image, right: &Image) -> Result<Vec<StageCheck>, Error> {
        readback::block_on(self.check(left, right))
    }

    /// As [`StereoMatcher::check_blocking`], with a chance to spoil the bytes read back from a step: the test of the test.
    #[cfg(not(target_arch = "wasm32"))]
    #[doc(hidden)]
    pub fn check_with(
        &self,
        left: &Image,
        right: &Image,
        mut spoil: impl FnMut(&str, &mut [u8]),
    ) -> Result<Vec<StageCheck>, Error> {
        readback::block_on(self.check_spoiled(left, right, &mut spoil))
    }

    async fn check_spoiled(
        &self,
        left: &Image,
        right: &Image,
        spoil: &mut impl FnMut(&str, &mut [u8]),
    ) -> Result<Vec<StageCheck>, Error> {
        self.accepts(left, right)?;
        self.pulse.check()?;
        let ((), verdict) = scopes::watched(&self.device, || self.write_sources(left, right));
        self.settled(verdict.await)?;
        let rectified = match &self.params.rectify {
            Some(rectification) => {
                Some([reference::rectify(left, rectification, 0)?, reference::rectify(right, rectification, 1)?])
            }
            None => None,
        };
        let [left, right] = rectified.as_ref().map_or([left, right], |[left, right]| [left, right]);
        let content = Content::new(&self.params, left.width(), left.height());
        let mut mirrored = self.params.second_match().is_some();
        let mut expected = match self.params.second_match() {
            Some(second) => {
                let content = content.as_ref().map(Content::mirrored);
                Expected::new(&second, &reference::mirrored(right)?, &reference::mirrored(left)?, content)
            }
            None => Expected::new(&self.params, left, right, content.clone()),
        };
        expected.rectified = rectified.clone();
        let mut stages: Vec<StageCheck> = Vec::new();
        let (mut last_views, mut level) = (None, None);
        for step in &self.steps {
            let rectifies = matches!(step.output, Output::Rectified { .. });
            if mirrored && !step.mirrored && !rectifies {
                let unmirrored = Expected::new(&self.params, left, right, content.clone());
                expected = Expected { matched: expected.matched, ..unmirrored };
                (mirrored, last_views, level) = (false, None, None);
            }
            // A level that follows a wrong one begins with a wrong map.
            if level.replace(step.level).is_some_and(|before| before != step.level)
                && stages.iter().any(|stage| stage.mismatches > 0)
            {
                break;
            }
            let fresh = match &step.output {
                Output::Paths { first, .. } => *first,
                Output::Views { .. } => last_views.replace(step.level) != Some(step.level),
                Output::Cost { volume_row, .. } => *volume_row == 0,
                Output::BlockStatistics { side, .. } => *side == 0,
                Output::Part => false,
                Output::Descriptors { first, .. } => *first == 0,
                _ => true,
            };
            let ((), verdict) = scopes::watched(&self.device, || {
                if fresh && step.part.first {
                    self.fill(&step.buffer, step.bytes);
                    if let Output::Views { right, .. } = &step.output {
                        self.fill(right, self.levels[step.level].sizes.right_map);
                    }
                }
                let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                record_steps(&mut encoder, step.stage(), std::slice::from_ref(step), None);
                self.queue.submit([encoder.finish()]);
            });
            self.settled(verdict.await)?;
            if stages.iter().all(|stage| stage.stage != step.stage()) {
                let stage = step.stage().to_string();
                stages.push(StageCheck { stage, elements: 0, mismatches: 0, first: None });
            }
            let Some(stage) = stages.iter_mut().find(|stage| stage.stage == step.stage()) else { continue };
            self.compare(step, &mut expected, stage, spoil).await?;
        }
        self.has_computed();
        Ok(stages)
    }

    fn fill(&self, buffer: &wgpu::Buffer, bytes: u64) {
        let pattern = vec![SENTINEL; bytes as usize];
        self.queue.write_buffer(buffer, 0, &pattern);
    }

    async fn fetch(
        &self,
        step: &Step,
        buffer: &wgpu::Buffer,
        bytes: u64,
        spoil: &mut impl FnMut(&str, &mut [u8]),
    ) -> Result<Vec<u8>, Error> {
        let copied = readback::copy(&self.device, &self.queue, &self.waiter, buffer, bytes).await;
        let mut bytes = copied.map_err(|error| self.pulse.cause(error))?;
        spoil(step.stage(), &mut bytes);
        Ok(bytes)
    }

    async fn compare(
        &self,
        step: &Step,
        expected: &mut Expected,
        stage: &mut StageCheck,
        spoil: &mut impl FnMut(&str, &mut [u8]),
    ) -> Result<(), Error> {
        let Level { halvings, params, sizes, .. } = &self.levels[step.level];
        let Frame { width, height, min_disparity, block_radius, gray_stride, left_stride, right_stride, .. } =
            sizes.frame;
        let whole = Rows { first: 0, count: height };
        let (width, disparities) = (width as usize, params.disparities as usize);
        let padded = 16 * params.quads() as usize;
        // Maps and paths are compared when all their parts are there.
        if !step.part.last
            || matches!(
                step.output,
                Output::Part | Output::Views { last: false, .. } | Output::Paths { last: false, .. }
            )
        {
            return Ok(());
        }
        if !matches!(
            step.output,
            Output::Rectified { .. }
                | Output::Gray { .. }
                | Output::WindowSums { .. }
                | Output::Prefiltered { .. }
                | Output::Values { .. }
                | Output::Descriptors { .. }
        ) {
            expected.enter(step.level);
        }
        let bytes = self.fetch(step, &step.buffer, step.bytes, spoil).await?;
        match &step.output {
            Output::Rectified { side } => {
                let Some(images) = &expected.rectified else { return Ok(()) };
                let row = width * self.format.bytes_per_pixel() as usize;
                for (i, (&expected, &got)) in images[*side].bytes().iter().zip(&bytes).enumerate() {
                    stage.compare(i % row, i / row, None, expected.into(), got.into());
                }
            }
            Output::Gray { side, channel: 0, deep: false } => {
                let plane = &expected.luma[*side];
                compare_picture(stage, whole, &bytes, 16 * gray_stride, |x, y| plane.clamped(x, y));
            }
            Output::Gray { side, channel, deep } => {
                let images = &expected.images[*side];
                let plane = &images.channels[channel.saturating_sub(1)];
                if *deep {
                    let values: Vec<u16> = bytes.chunks_exact(2).map(|v| u16::from_le_bytes([v[0], v[1]])).collect();
                    compare_picture(stage, whole, &values, 16 * gray_stride, |x, y| plane.clamped(x, y));
                } else {
                    compare_picture(stage, whole, &bytes, 16 * gray_stride, |x, y| plane.clamped(x, y));
                }
            }
            Output::WindowSums { side, channel, filtered, window } => {
                let images = if *filtered { &expected.prefiltered } else { &expected.images };
                let plane = &images[*side].channels[*channel];
                let sums = bytemuck::pod_collect_to_vec::<u8, u32>(&bytes);
                for (i, &got) in sums.iter().enumerate() {
                    let (x, y) = (i % width, i / width);
                    let sum = reference::window_sum(plane, *window, x as i64, y as i64);
                    stage.compare(x, y, None, sum.into(), got.into());
                }
            }
            Output::Prefiltered { side, channel } => {
                let plane = &expected.prefiltered[*side].channels[*channel];
                compare_picture(stage, whole, &bytes, 16 * gray_stride, |x, y| plane.clamped(x, y));
            }
            Output::Descriptors { side, first, count, rows: held } => {
                let (descriptors, stride) =
                    (&expected.pyramid[*halvings as usize][*side], 4 * [left_stride, right_stride][*side] as usize);
                let reach = i64::from(block_radius);
                let plane = held.count as usize;
                let rows = bytes.chunks_exact(stride).enumerate().skip(first * plane);
                for (row, bytes) in rows.take(count * plane) {
                    let (p, y) = (row / plane, held.first as usize + row % plane);
                    for (j, &got) in bytes.iter().enumerate() {
                        let x = match side {
                            0 => j as i64 - reach,
                            _ => width as i64 - 1 + reach - i64::from(min_disparity) - j as i64,
                        };
                        stage.compare(j, y, None, descriptors.clamped(x, y as i64)[p].into(), got.into());
                    }
                }
            }
            Output::Values { side } => {
                let values = &expected.pyramid[*halvings as usize][*side];
                compare_picture(stage, whole, &bytes, 16 * gray_stride, |x, y| values.clamped(x, y)[0].into());
            }
            Output::Histogram => {
                let counts = bytemuck::pod_collect_to_vec::<u8, u32>(&bytes);
                for (i, (&expected, &got)) in expected.counts.iter().zip(&counts).enumerate() {
                    stage.compare(i % 256, i / 256, None, expected.into(), got.into());
                }
            }
            Output::Table => {
                for (i, (&expected, &got)) in expected.table.iter().zip(&bytes).enumerate() {
                    stage.compare(i % 256, i / 256, None, expected.into(), got.into());
                }
            }
            Output::Columns { chunk } => {
                let columns = &expected.columns;
                for (y, row) in each_row(*chunk, &bytes, sizes.columns_row) {
                    let sum_bytes = if params.wide_sums() { 4 } else { 2 };
                    for (c, values) in row.chunks_exact(sum_bytes * padded).enumerate() {
                        let expected = &columns.data[(y * columns.width + c) * disparities..][..disparities];
                        for (d, &expected) in expected.iter().enumerate() {
                            // Two a word: of disparities 4k .. 4k + 3 the even two, then the odd two.
                            let at = 2 * (d / 4 * 4 + d % 2 * 2 + d / 2 % 2);
                            let got = match params.wide_sums() {
                                true => bytemuck::pod_read_unaligned::<u32>(&values[4 * d..][..4]),
                                false => u16::from_le_bytes([values[at], values[at + 1]]).into(),
                            };
                            stage.compare(c, y, Some(d), expected.into(), got.into());
                        }
                    }
                }
            }
            Output::BlockStatistics { side, chunk } => {
                let Some(statistics) = &expected.statistics else { return Ok(()) };
                let numbers = bytemuck::pod_collect_to_vec::<u8, u32>(&bytes);
                let columns = &statistics[*side].columns;
                let count = (columns.end - columns.start) as usize;
                let row_numbers = sizes.statistics_row as usize / 4;
                for (row, y) in (chunk.first..chunk.first + chunk.count).enumerate() {
                    let found = &numbers[row * row_numbers + 2 * side * width..][..2 * count];
                    for (i, found) in found.chunks_exact(2).enumerate() {
                        let x = if *side == 0 { i as i64 } else { columns.end - 1 - i as i64 };
                        for (&expected, &got) in statistics[*side].at(x, y as usize).iter().zip(found) {
                            stage.compare(i, y as usize, None, expected.into(), got.into());
                        }
                    }
                }
            }
            Output::Penalties { direction } => {
                let (Some(penalties), Some(k)) =
                    (&expected.penalties, Direction::FORWARD.iter().position(|forward| forward == direction))
                else {
                    return Ok(());
                };
                let (dx, dy) = (direction.dx as isize, direction.dy as usize);
                for (i, values) in penalties.data.chunks_exact(penalties.disparities).enumerate() {
                    let (x, y) = (i % width, i / width);
                    let (line, place) = match dy {
                        0 => (y * (width / 16 + 1), x),
                        _ => {
                            let column = (x as isize - dx * (y / dy) as isize).rem_euclid(width as isize);
                            (y % dy * width + column as usize, y / dy)
                        }
                    };
                    let vector = line + place / 16 * (dy * width).max(1);
                    stage.compare(x, y, Some(k), values[k].into(), bytes[16 * vector + place % 16].into());
                }
            }
            Output::Cost { chunk, volume_row } => {
                let first = u64::from(*volume_row) * sizes.volume_row;
                for (y, row) in each_row(*chunk, &bytes[first as usize..], sizes.volume_row) {
                    for (x, values) in row.chunks_exact(padded).take(width).enumerate() {
                        let expected = &expected.cost.data[(y * width + x) * disparities..][..disparities];
                        for (d, (&expected, &got)) in expected.iter().zip(values).enumerate() {
                            stage.compare(x, y, Some(d), expected.into(), got.into());
                        }
                    }
                }
            }
            Output::Paths { directions, band, volume_row, .. } => {
                let first = u64::from(*volume_row) * sizes.volume_row;
                // The device keeps T = L - C, summed over the directions so far.
                for &direction in directions {
                    expected.path(direction);
                }
                let volumes: Vec<&Volume<u8>> =
                    expected.paths.iter().filter(|(d, _)| directions.contains(d)).map(|(_, volume)| volume).collect();
                for (y, row) in each_row(*band, &bytes[first as usize..], sizes.volume_row) {
                    for (x, values) in row.chunks_exact(padded).take(width).enumerate() {
                        let at = (y * width + x) * disparities;
                        for (d, &got) in values[..disparities].iter().enumerate() {
                            let cost = i64::from(expected.cost.data[at + d]);
                            let sum: i64 = volumes.iter().map(|volume| i64::from(volume.data[at + d]) - cost).sum();
                            stage.compare(x, y, Some(d), sum, got.into());
                        }
                    }
                }
            }
            Output::Views { right, .. } => {
                let left = map_of(&sizes.frame, &bytes);
                let behind = self.fetch(step, right, sizes.right_map, spoil).await?;
                let right = map_of(&sizes.frame, &behind);
                let wanted = expected.params.confidence;
                let views = expected.views();
                compare_maps(stage, &views.left, &left);
                compare_maps(stage, &views.right, &right);
                if wanted {
                    let margins = map_of(&sizes.frame, &behind[sizes.map as usize..]);
                    for (i, (&expected, &got)) in views.margins.data.iter().zip(&margins.data).enumerate() {
                        stage.compare(i % width, i / width, None, expected.into(), got.into());
                    }
                }
                expected.checked = Some(views.left.clone());
            }
            Output::Mirrored => {
                let matched = reference::mirror(&expected.views().left);
                compare_maps(stage, &matched, &map_of(&sizes.frame, &bytes));
                expected.matched = Some(matched);
            }
            Output::Validity { side: 1 } => {
                if let Some(content) = expected.content() {
                    let right = reference::validity(&expected.right_view(), &content, 1);
                    compare_maps(stage, &right, &map_of(&sizes.frame, &bytes));
                    expected.right = Some(right);
                }
            }
            Output::Confidence => {
                if let Some(map) = expected.checked.clone() {
                    let confidence = reference::confidence(&map, &expected.views().margins);
                    let got = confidence_of(&sizes.frame, &bytes);
                    for (i, (&expected, &got)) in confidence.data.iter().zip(&got.data).enumerate() {
                        stage.compare(i % width, i / width, None, expected.into(), got.into());
                    }
                }
            }
            Output::Depth => {
                if let (Some(map), Some(camera)) = (&expected.checked, &params.depth) {
                    let depth = reference::depth(map, camera);
                    let got = depth_of(&sizes.frame, &bytes);
                    for (i, (&expected, &got)) in depth.data.iter().zip(&got.data).enumerate() {
                        stage.compare(i % width, i / width, None, expected.into(), got.into());
                    }
                }
            }
            filter => {
                if let Some(filtered) = expected.filtered(filter, params) {
                    compare_maps(stage, &filtered, &map_of(&sizes.frame, &bytes));
                    expected.checked = Some(filtered);
                }
            }
        }
        Ok(())
    }
}

/// Compares an image laid out with 16 columns before the first one, `stride` values a row.
fn compare_picture<T: Copy + Into<i64>>(
    stage: &mut StageCheck,
    rows: Rows,
    values: &[T],
    stride: u32,
    expected: impl Fn(i64, i64) -> i32,
) {
    for (y, row) in (0..rows.count as usize).zip(values.chunks_exact(stride as usize)) {
        for (j, &got) in row.iter().enumerate() {
            stage.compare(j, y, None, expected(j as i64 - 16, y as i64).into(), got.into());
        }
    }
}

fn compare_maps(stage: &mut StageCheck, expected: &DisparityMap, got: &DisparityMap) {
    let width = expected.width as usize;
    for (i, (&expected, &got)) in expected.data.iter().zip(&got.data).enumerate() {
        stage.compare(i % width, i / width, None, expected.into(), got.into());
    }
}
