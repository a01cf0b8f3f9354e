//! Timestamps of a frame, in the caller's queries.

use crate::Error;
use crate::gpu::matcher::stereo_matcher::StereoMatcher;
use crate::gpu::scopes;

/// Where [`StereoMatcher::record_timed`](crate::StereoMatcher::record_timed) writes timestamps: into a query set of the caller's, of the
/// type `Timestamp`, from one query on. The caller resolves them with all others of the encoder; a device has them with the feature
/// `TIMESTAMP_QUERY`. The set must be of the matcher's device; one of another wgpu instance cannot be told from it.
#[derive(Clone, Copy, Debug)]
pub struct Timestamps<'a> {
    queries: &'a wgpu::QuerySet,
    first: u32,
    /// Whether each stage is timed.
    pub(super) stages: bool,
}

impl<'a> Timestamps<'a> {
    /// Two for the whole frame: query `first` when its first pass begins, query `first` + 1 when its last pass ends. The frame is
    /// recorded as without.
    pub fn frame(queries: &'a wgpu::QuerySet, first: u32) -> Self {
        Self { queries, first, stages: false }
    }

    /// Two for each stage, from query `first` on; [`StereoMatcher::stage_queries`](crate::StereoMatcher::stage_queries) suffice. Each
    /// stage gets a pass of its own, which takes a little more time than a frame without.
    pub fn stages(queries: &'a wgpu::QuerySet, first: u32) -> Self {
        Self { queries, first, stages: true }
    }

    /// `needed`: queries from the first one on.
    fn check(&self, matcher: &StereoMatcher, needed: u32) -> Result<(), Error> {
        let Self { queries, first, .. } = *self;
        if !matches!(queries.ty(), wgpu::QueryType::Timestamp) {
            return Err(Error::Misuse(format!(
                "the query set is of the type {:?}, but must be of the type Timestamp; create one of that type",
                queries.ty()
            )));
        }
        if queries.count().checked_sub(first).is_none_or(|rest| rest < needed) {
            return Err(Error::Misuse(format!(
                "the query set has {} queries, but {needed} are needed from query {first} on; create a larger one \
                 (StereoMatcher::stage_queries), or begin earlier",
                queries.count()
            )));
        }
        #[cfg(not(target_arch = "wasm32"))]
        matcher.passes.tried(queries, || self.try_out(&matcher.device).map_err(|error| matcher.pulse.cause(error)))?;
        #[cfg(target_arch = "wasm32")]
        let _ = matcher; // a browser looks itself
        Ok(())
    }

    /// Writes into the queries in an encoder that is dropped: a query set of another device would spoil the caller's.
    #[cfg(not(target_arch = "wasm32"))]
    fn try_out(&self, device: &wgpu::Device) -> Result<(), Error> {
        let tried = scopes::guarded(device, || {
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let timestamp_writes = Some(wgpu::ComputePassTimestampWrites {
                query_set: self.queries,
                beginning_of_pass_write_index: Some(self.first),
                end_of_pass_write_index: Some(self.first + 1),
            });
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: None, timestamp_writes });
            encoder.finish()
        });
        tried.map(|_| ()).map_err(|error| match error {
            Error::Refused(text) => Error::Misuse(format!(
                "the query set was refused by the device: {text}; create it with the device that the matcher was made with"
            )),
            other => other,
        })
    }
}

/// A part of a frame between two timestamps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct TimedSpan {
    /// `frame`, or the stage's name, as in docs/ALGORITHMS.md; `intake` for what takes the pair from the caller's textures or buffers,
    /// `outputs` for what writes the caller's textures. A stage that runs several times has as many spans.
    pub name: &'static str,
    /// The query that is written when it begins.
    pub begin: u32,
    /// The query that is written when it ends.
    pub end: u32,
}

/// What each pass of a frame writes.
#[derive(Default)]
pub(crate) struct Stamps<'a> {
    queries: Option<&'a wgpu::QuerySet>,
    /// The queries of the begin and the end of each pass, the last one first.
    passes: Vec<[Option<u32>; 2]>,
}

impl<'a> Stamps<'a> {
    /// Of a frame whose passes belong to the stages `names`, of which there is at least one.
    pub(super) fn new(
        matcher: &StereoMatcher,
        timestamps: Option<Timestamps<'a>>,
        names: &[&'static str],
    ) -> Result<(Self, Vec<TimedSpan>), Error> {
        let Some(timestamps) = timestamps else { return Ok((Self::default(), Vec::new())) };
        let (mut spans, mut passes): (Vec<TimedSpan>, Vec<[Option<u32>; 2]>) = (Vec::new(), Vec::new());
        let together: Vec<&[&'static str]> = match timestamps.stages {
            true => names.chunk_by(|a, b| a == b).collect(),
            false => vec![names],
        };
        timestamps.check(matcher, 2 * together.len() as u32)?;
        for (run, begin) in together.iter().zip((timestamps.first..).step_by(2)) {
            let first = passes.len();
            passes.resize(first + run.len(), [None; 2]);
            passes[first][0] = Some(begin);
            passes[first + run.len() - 1][1] = Some(begin + 1);
            let name = if timestamps.stages { run[0] } else { "frame" };
            spans.push(TimedSpan { name, begin, end: begin + 1 });
        }
        passes.reverse();
        Ok((Self { queries: Some(timestamps.queries), passes }, spans))
    }

    /// What the next pass writes.
    pub(super) fn next(&mut self) -> Option<wgpu::ComputePassTimestampWrites<'a>> {
        let [begin, end] = self.passes.pop()?;
        let query_set = self.queries.filter(|_| begin.or(end).is_some())?;
        Some(wgpu::ComputePassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: begin,
            end_of_pass_write_index: end,
        })
    }
}
