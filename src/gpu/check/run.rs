//! The check: runs the steps one by one, and compares what each left with the reference.

use crate::check::StageCheck;
use crate::gpu::check::compare::Comparison;
use crate::gpu::check::expected::Expected;
use crate::gpu::recording::{Step, Written, record_steps};
use crate::gpu::{readback, scopes};
use crate::reference::{self, Content};
use crate::{Error, Image, ImageView, StereoMatcher};

/// What buffers hold before a stage writes them: "wrote nothing" must differ from "wrote 0".
const SENTINEL: u8 = 0xa5;

/// The pair that is checked, and the reference's results for the pair or its mirror image.
struct Checked<'a> {
    pair: [ImageView<'a>; 2],
    content: Option<Content>,
    /// Whether the steps so far are of the mirrored pair.
    mirrored: bool,
    expected: Expected,
    /// The level of the last step, and of the last that left both views.
    level: Option<usize>,
    views_level: Option<usize>,
}

impl<'a> Checked<'a> {
    fn new(matcher: &StereoMatcher, pair: [ImageView<'a>; 2]) -> Result<Self, Error> {
        let [left, right] = pair;
        let content = Content::new(&matcher.params, left.width(), left.height());
        let second = matcher.params.second_match();
        let mirrored = second.is_some();
        let expected = match second {
            Some(second) => {
                let content = content.as_ref().map(Content::mirrored);
                let mirrored = [reference::mirrored(right)?, reference::mirrored(left)?];
                Expected::new(&second, mirrored.each_ref().map(ImageView::from), content)
            }
            None => Expected::new(&matcher.params, pair, content.clone()),
        };
        Ok(Self { pair, content, mirrored, expected, level: None, views_level: None })
    }

    /// Goes on with a step. Returns whether another level begins.
    fn enter(&mut self, matcher: &StereoMatcher, step: &Step) -> bool {
        let rectifies = matches!(step.written, Written::Rectified { .. });
        if self.mirrored && !step.mirrored && !rectifies {
            let unmirrored = Expected::new(&matcher.params, self.pair, self.content.clone());
            let matched = self.expected.matched.take();
            self.expected = Expected { matched, ..unmirrored };
            (self.mirrored, self.views_level, self.level) = (false, None, None);
        }
        self.level.replace(step.level).is_some_and(|before| before != step.level)
    }

    /// Whether the step is the first of those that write its buffer together.
    fn begins(&mut self, step: &Step) -> bool {
        let first = match &step.written {
            Written::Paths { first, .. } => *first,
            Written::Views { .. } => self.views_level.replace(step.level) != Some(step.level),
            Written::Cost { volume_row, .. } => *volume_row == 0,
            Written::BlockStatistics { side, .. } => *side == 0,
            // The paths of the first pass, from which it is made, lie in the same buffer.
            Written::Part | Written::SecondCost { .. } => false,
            Written::Messages { rounds, .. } => *rounds == 0,
            Written::Descriptors { first, .. } => *first == 0,
            Written::Layer { joined, .. } => !joined,
            _ => true,
        };
        first && step.part.first
    }
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
    pub async fn check<'a>(
        &self,
        left: impl Into<ImageView<'a>>,
        right: impl Into<ImageView<'a>>,
    ) -> Result<Vec<StageCheck>, Error> {
        self.check_spoiled([left.into(), right.into()], &mut |_, _| {}).await
    }

    /// As [`StereoMatcher::check`]; blocks until all is compared.
    ///
    /// # Errors
    /// As [`StereoMatcher::compute`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn check_blocking<'a>(
        &self,
        left: impl Into<ImageView<'a>>,
        right: impl Into<ImageView<'a>>,
    ) -> Result<Vec<StageCheck>, Error> {
        readback::block_on(self.check(left, right))
    }

    /// As [`StereoMatcher::check_blocking`], with a chance to spoil the bytes read back from a step: the test of the test.
    #[cfg(not(target_arch = "wasm32"))]
    #[doc(hidden)]
    pub fn check_with<'a>(
        &self,
        left: impl Into<ImageView<'a>>,
        right: impl Into<ImageView<'a>>,
        mut spoil: impl FnMut(&str, &mut [u8]),
    ) -> Result<Vec<StageCheck>, Error> {
        readback::block_on(self.check_spoiled([left.into(), right.into()], &mut spoil))
    }

    async fn check_spoiled(
        &self,
        [left, right]: [ImageView<'_>; 2],
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
        let pair = rectified.as_ref().map_or([left, right], |pair: &[Image; 2]| pair.each_ref().map(ImageView::from));
        let mut checked = Checked::new(self, pair)?;
        checked.expected.rectified = rectified.clone();
        let mut stages: Vec<StageCheck> = Vec::new();
        for step in &self.steps {
            // A level that follows a wrong one begins with a wrong map.
            if checked.enter(self, step) && stages.iter().any(|stage| stage.mismatches > 0) {
                break;
            }
            let begins = checked.begins(step);
            let ((), verdict) = scopes::watched(&self.device, || self.run_step(step, begins));
            self.settled(verdict.await)?;
            let known = stages.iter().position(|stage| stage.stage == step.stage());
            let place = known.unwrap_or_else(|| {
                stages.push(StageCheck { stage: step.stage().into(), elements: 0, mismatches: 0, first: None });
                stages.len() - 1
            });
            self.compare(step, &mut checked.expected, &mut stages[place], spoil).await?;
            // A second pass that follows a wrong cost is wrong.
            if matches!(step.written, Written::SecondCost { .. }) && stages[place].mismatches > 0 {
                break;
            }
        }
        self.has_computed();
        Ok(stages)
    }

    /// Submits one step; if it `begins` a buffer, that is filled with the pattern before.
    fn run_step(&self, step: &Step, begins: bool) {
        let fill = |buffer: &wgpu::Buffer, bytes: u64| {
            self.queue.write_buffer(buffer, 0, &vec![SENTINEL; bytes as usize]);
        };
        if begins {
            fill(&step.buffer, step.bytes);
            if let Written::Views { right, .. } = &step.written {
                fill(right, self.levels[step.level].sizes.right_map);
            }
        }
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        record_steps(&mut encoder, step.stage(), std::slice::from_ref(step), None);
        self.queue.submit([encoder.finish()]);
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
        // Maps and paths are compared when all their parts are there.
        if !step.part.last || !step.written.is_whole() {
            return Ok(());
        }
        if !step.written.precedes_rounds() {
            expected.enter(step.level);
        }
        let level = &self.levels[step.level];
        let bytes = self.fetch(step, &step.buffer, step.bytes, spoil).await?;
        let right = match &step.written {
            Written::Views { right, .. } => self.fetch(step, right, level.sizes.right_map, spoil).await?,
            _ => Vec::new(),
        };
        Comparison { level, format: self.format, bytes, right, expected, stage }.run(&step.written);
        Ok(())
    }
}
