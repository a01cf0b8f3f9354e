//! The work of a frame, recorded into the caller's encoder.

use crate::gpu::interop::{Context, Inputs, Outputs, Prepared, Regions};
use crate::gpu::matcher::stereo_matcher::StereoMatcher;
use crate::gpu::matcher::timestamps::{Stamps, TimedSpan, Timestamps};
use crate::gpu::recording::{Step, Written, record_steps};
use crate::gpu::scopes;
use crate::gpu::spans::span;
use crate::gpu::uploads::Uploaded;
use crate::{Error, Method, Network};

/// Multiplications of a network that are submitted at once: a CPU adapter has some tenths of a second to do with them.
const AT_ONCE: u64 = 2_000_000_000;

impl StereoMatcher {
    /// Records the work of one frame into the caller's encoder: takes the pair from `inputs`, leaves the map in
    /// [`StereoMatcher::output`] and in what `outputs` names. It neither submits nor waits.
    ///
    /// What is recorded is whole: whatever is uploaded, computed, resized or set before it is submitted, it gives the maps of
    /// the pair, the size and the settings that it was recorded with.
    ///
    /// # Errors
    /// [`Error::Image`] if an input or an output does not fit the matcher; [`Error::Misuse`] if no pair of this size was
    /// uploaded, or the encoder is another device's: then nothing is recorded. [`Error::Misuse`], too, if a pass of the encoder
    /// is open, which spoils it. [`Error::Lost`] if the device is lost. In a browser, errors that the device itself reports go
    /// to the caller's error scopes and error handler.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        outputs: &Outputs<'_>,
    ) -> Result<(), Error> {
        self.record_with(encoder, inputs, outputs, None).map(|_| ())
    }

    /// As [`StereoMatcher::record`], and the passes write timestamps into the caller's queries. Returns what is between which of
    /// them, in the order of the work.
    ///
    /// ```no_run
    /// # use gpu_stereo::{Error, Inputs, Outputs, StereoMatcher, Timestamps, wgpu};
    /// # fn program(matcher: &StereoMatcher, encoder: &mut wgpu::CommandEncoder, device: &wgpu::Device) -> Result<(), Error> {
    /// let queries = device.create_query_set(&wgpu::QuerySetDescriptor {
    ///     label: None,
    ///     ty: wgpu::QueryType::Timestamp,
    ///     count: matcher.stage_queries(),
    /// });
    /// let timestamps = Timestamps::stages(&queries, 0);
    /// for span in matcher.record_timed(encoder, &Inputs::Uploaded, &Outputs::default(), timestamps)? {
    ///     println!("{}: from query {} to query {}", span.name, span.begin, span.end);
    /// }
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// As [`StereoMatcher::record`]; [`Error::Misuse`] if the query set has not the type `Timestamp` or too few queries, or is another
    /// device's: then nothing is recorded.
    pub fn record_timed(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        outputs: &Outputs<'_>,
        timestamps: Timestamps<'_>,
    ) -> Result<Vec<TimedSpan>, Error> {
        self.record_with(encoder, inputs, outputs, Some(timestamps))
    }

    /// The most queries that [`Timestamps::stages`] writes for a frame of the present size and settings.
    pub fn stage_queries(&self) -> u32 {
        2 * (self.runs(true).len() as u32 + 2) // and what takes the pair, and what writes the outputs
    }

    fn record_with(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &Inputs<'_>,
        outputs: &Outputs<'_>,
        timestamps: Option<Timestamps<'_>>,
    ) -> Result<Vec<TimedSpan>, Error> {
        span!(DEBUG, "record");
        self.pulse.check()?;
        if !self.pulse.owns(encoder) {
            return Err(Error::Misuse(
                "the encoder is of another wgpu device than the matcher; create it with the device that the matcher was \
                 made with"
                    .into(),
            ));
        }
        let frame = self.prepared(inputs, outputs, timestamps.is_some_and(|timestamps| timestamps.stages))?;
        let (mut stamps, spans) = Stamps::new(self, timestamps, &frame.names())?;
        let recorded = scopes::guarded_or_left(&self.device, || self.record_prepared(encoder, &frame, &mut stamps));
        recorded.map_err(|error| match self.pulse.cause(error) {
            Error::Refused(text) => Error::Misuse(format!(
                "the encoder refused the work: {text}; end its open passes before, and begin with a new encoder"
            )),
            other => other,
        })?;
        self.has_recorded(encoder, &frame);
        Ok(spans)
    }

    /// A frame whose inputs and outputs are checked, and all of whose work is made. `stages`: with a pass for each stage.
    pub(crate) fn prepared(
        &self,
        inputs: &Inputs<'_>,
        outputs: &Outputs<'_>,
        stages: bool,
    ) -> Result<PreparedFrame<'_>, Error> {
        let context = self.interop();
        let mut regions = Regions::default();
        let before = context.before(&self.passes, inputs, &mut regions)?;
        let after = context.after(&self.passes, outputs, &mut regions)?;
        let uploaded = match inputs {
            Inputs::Uploaded => Some(self.uploads.last().filter(|pair| pair.size == self.size()).ok_or_else(|| {
                let [width, height] = self.size();
                Error::Misuse(format!(
                    "no pair of {width}x{height} was uploaded since the matcher takes that size; upload one before it is \
                     recorded"
                ))
            })?),
            _ => None,
        };
        Ok(PreparedFrame { uploaded, before, runs: self.runs(stages), stages, after })
    }

    /// Records a frame.
    pub(crate) fn record_prepared(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &PreparedFrame<'_>,
        stamps: &mut Stamps<'_>,
    ) {
        if let Some(pair) = &frame.uploaded {
            self.record_sources(encoder, &pair.buffer);
        }
        frame.before.iter().for_each(|work| work.record(encoder, || stamps.next()));
        for steps in &frame.runs {
            span!(TRACE, "pass", stage = steps[0].stage(), dispatches = steps.len());
            let label = if frame.stages { steps[0].stage() } else { "gpu-stereo" };
            record_steps(encoder, label, steps, stamps.next());
        }
        frame.after.iter().for_each(|work| work.record(encoder, || stamps.next()));
    }

    /// A frame was recorded: until it is done, or the encoder dropped, what it needs is kept.
    pub(crate) fn has_recorded(&self, encoder: &wgpu::CommandEncoder, frame: &PreparedFrame<'_>) {
        let held = (self.recorded.clone(), frame.uploaded.as_ref().map(|pair| pair.held.clone()));
        encoder.on_submitted_work_done(move || drop(held));
        self.has_computed();
    }

    /// The steps of each compute pass, which ends where something is copied or cleared; or also with each stage.
    pub(super) fn runs(&self, stages: bool) -> Vec<&[Step]> {
        let together = |a: &Step, b: &Step| a.copy_to.is_none() && !b.clears && !(stages && a.stage() != b.stage());
        self.steps.chunk_by(together).collect()
    }

    fn interop(&self) -> Context<'_> {
        Context {
            device: &self.device,
            queue: &self.queue,
            pulse: &self.pulse,
            frame: &self.sizes.frame,
            format: self.format,
            params: &self.params,
            sources: &self.ends.sources,
            output: &self.ends.output,
            right: self.ends.right.as_ref(),
            confidence: self.ends.confidence.as_ref(),
            depth: self.ends.depth.as_ref(),
        }
    }

    /// Drops the bind groups of the textures and buffers of [`Inputs`] and [`Outputs`]. Those of about eight pairs are kept for the
    /// next frames, and keep these resources alive.
    pub fn forget_resources(&self) {
        self.passes.forget();
    }

    /// Records the work of one frame that is submitted at once, of a network in [`Pieces`].
    pub(super) fn record_at_once(&self, encoder: &mut wgpu::CommandEncoder) {
        let mut pieces = Pieces::new(self);
        for steps in self.runs(false) {
            span!(TRACE, "pass", stage = steps[0].stage(), dispatches = steps.len());
            record_steps(encoder, "gpu-stereo", steps, None);
            pieces.recorded(encoder, steps);
        }
        pieces.end(encoder);
    }

    /// Those of a step, if it is the last one of an operation of a network.
    fn multiplications(&self, network: &Network, step: &Step) -> u64 {
        match (&step.written, &self.sizes.layers) {
            (Written::Layer { operation, .. }, Some(layers)) if step.part.last => {
                let operations = network.operations();
                operations[*operation].multiplications(operations, &layers.padded)
            }
            _ => 0,
        }
    }

    /// Records the work of one frame, from the uploaded pair to [`StereoMatcher::output`].
    pub(crate) fn record_chain(&self, encoder: &mut wgpu::CommandEncoder) {
        for steps in self.runs(false) {
            record_steps(encoder, "gpu-stereo", steps, None);
        }
    }
}

/// A frame that only has to be recorded.
pub(crate) struct PreparedFrame<'a> {
    /// The pair that was uploaded last, if it is taken.
    uploaded: Option<Uploaded>,
    before: Vec<Prepared>,
    /// The steps of each compute pass of the chain.
    runs: Vec<&'a [Step]>,
    stages: bool,
    after: Vec<Prepared>,
}

impl PreparedFrame<'_> {
    /// The name of the stage of each pass, in their order.
    fn names(&self) -> Vec<&'static str> {
        let passes = |all: &[Prepared], name| vec![name; all.iter().filter(|work| work.is_pass()).count()];
        let chain = self.runs.iter().map(|steps| steps[0].stage()).collect();
        [passes(&self.before, "intake"), chain, passes(&self.after, "outputs")].concat()
    }
}

/// What was recorded of a network is submitted whenever it has [`AT_ONCE`] multiplications, which are counted when they are
/// done: so it is known how far it is. Other methods are one piece.
pub(super) struct Pieces<'a> {
    matcher: &'a StereoMatcher,
    network: Option<&'a Network>,
    multiplications: u64,
}

impl<'a> Pieces<'a> {
    pub(super) fn new(matcher: &'a StereoMatcher) -> Self {
        let params = &matcher.params;
        let network = params.network.as_ref().filter(|_| params.method == Method::Psmnet);
        Self { matcher, network, multiplications: 0 }
    }

    /// These steps were recorded: if the piece is full, it is submitted and the encoder replaced.
    pub(super) fn recorded(&mut self, encoder: &mut wgpu::CommandEncoder, steps: &[Step]) {
        let Some(network) = self.network else { return };
        self.multiplications += steps.iter().map(|step| self.matcher.multiplications(network, step)).sum::<u64>();
        if self.multiplications >= AT_ONCE {
            let next = self.matcher.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let full = std::mem::replace(encoder, next);
            self.end(&full);
            self.matcher.queue.submit([full.finish()]);
        }
    }

    /// The piece that the encoder holds is the next to be submitted.
    pub(super) fn end(&mut self, encoder: &wgpu::CommandEncoder) {
        let Some(network) = self.network.cloned() else { return };
        let done = std::mem::take(&mut self.multiplications);
        encoder.on_submitted_work_done(move || network.add_done(done));
    }
}
