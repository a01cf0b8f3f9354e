//! The pipelines and bind groups for the caller's resources: made at first use, and kept for the next frames.

use std::collections::{HashMap, VecDeque};
use std::hash::{BuildHasher as _, RandomState};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::Error;
use crate::gpu::interop::context::Context;
use crate::gpu::interop::pipelines::{CallerResource, MatcherResource, Pipeline, Prepared, bind, compile};
use crate::gpu::interop::resources::{PixelBuffer, Seen, TextureLayer};
use crate::gpu::interop::work::{LANES, Work, WriteMethod};
use crate::gpu::layout::Frame;
use crate::gpu::scopes;
use wgpu::TextureFormat;

/// Bind groups that are kept: those of eight pairs, and of all that may be shown of them.
const KEPT: usize = 32;

/// Hashes that are kept of targets which can be drawn to, and of query sets that can be written to.
const KNOWN: usize = 64;

/// All that a bind group follows from.
#[derive(PartialEq)]
struct Key {
    work: Work,
    source: Option<wgpu::Texture>,
    map: Option<wgpu::Buffer>,
    resources: [Option<Bound>; 2],
    origin: [u32; 2],
    frame: Frame,
    disparities: u32,
}

/// What is bound of the caller's: a layer, or the bytes of a buffer from an offset on and those of a row.
#[derive(PartialEq)]
enum Bound {
    Layer(Seen),
    Buffer(wgpu::Buffer, u64, u64, u32),
}

impl Bound {
    fn new(resource: CallerResource<'_>) -> Self {
        match resource {
            CallerResource::Layer(layer, format) => Bound::Layer(layer.seen(format)),
            CallerResource::Buffer(PixelBuffer { buffer, offset, bytes_per_row, .. }, bytes) => {
                Bound::Buffer(buffer.clone(), offset, bytes, bytes_per_row)
            }
        }
    }
}

impl Key {
    fn new(
        context: &Context<'_>,
        work: Work,
        resources: [Option<CallerResource<'_>>; 2],
        end: MatcherResource<'_>,
    ) -> Self {
        let (source, map) = match end {
            MatcherResource::Texture(source) => (Some(source.clone()), None),
            MatcherResource::Buffer(map, _) => (None, Some(map.clone())),
        };
        let origin = resources[0].map_or([0, 0], |resource| resource.origin());
        // A target that is drawn to is in no bind group.
        let drawn = matches!(work.method(), Some(WriteMethod::Draw(_)));
        let resources = resources.map(|resource| resource.filter(|_| !drawn).map(Bound::new));
        let (frame, disparities) = (*context.frame, context.params.disparities);
        Self { work, source, map, resources, origin, frame, disparities }
    }
}

/// What is kept from frame to frame.
#[derive(Default)]
struct Kept {
    pipelines: HashMap<Work, (wgpu::BindGroupLayout, Pipeline)>,
    /// The latest used one comes last.
    bind_groups: Vec<(Key, wgpu::BindGroup)>,
    /// Targets that are drawn to, from the second time on: a window gives another texture each time. The latest used one
    /// comes last.
    targets: Vec<(Seen, wgpu::TextureView)>,
    /// Hashes of targets and of query sets, which do not keep them alive.
    known: VecDeque<u64>,
}

impl Kept {
    fn remember(&mut self, hash: u64) {
        self.known.truncate(KNOWN - 1);
        self.known.push_front(hash);
    }
}

/// The pipelines and bind groups for the caller's resources.
#[derive(Default)]
pub(crate) struct PassCache {
    kept: Mutex<Kept>,
    hasher: RandomState,
}

impl std::fmt::Debug for PassCache {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let kept = self.kept();
        let (pipelines, bind_groups) = (kept.pipelines.len(), kept.bind_groups.len());
        f.debug_struct("PassCache").field("pipelines", &pipelines).field("bind_groups", &bind_groups).finish()
    }
}

impl PassCache {
    fn kept(&self) -> MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Drops what holds the caller's resources.
    pub(crate) fn forget(&self) {
        let mut kept = self.kept();
        kept.bind_groups.clear();
        kept.targets.clear();
        kept.known.clear();
    }

    /// Tries the caller's resource out, unless it passed before.
    pub(crate) fn tried(
        &self,
        resource: &impl std::hash::Hash,
        trial: impl FnOnce() -> Result<(), Error>,
    ) -> Result<(), Error> {
        let hash = self.hasher.hash_one(resource);
        if self.kept().known.contains(&hash) {
            return Ok(());
        }
        trial()?;
        self.kept().remember(hash);
        Ok(())
    }

    /// The work between one resource of the caller's, or two, and one of the matcher's.
    pub(super) fn prepare(
        &self,
        context: &Context<'_>,
        name: &str,
        work: Work,
        resource: CallerResource<'_>,
        chroma: Option<CallerResource<'_>>,
        end: MatcherResource<'_>,
    ) -> Result<Prepared, Error> {
        let resources = [Some(resource), chroma];
        let mut kept = self.kept();
        let (layout, pipeline) = match kept.pipelines.get(&work) {
            Some(found) => found.clone(),
            None => {
                let compiled = scopes::guarded_or_left(context.device, || compile(context.device, work));
                let new = compiled.map_err(|error| context.pulse.cause(error))?;
                kept.pipelines.insert(work, new.clone());
                new
            }
        };
        let key = Key::new(context, work, resources, end);
        let bind_group = match kept.bind_groups.iter().position(|(other, _)| *other == key) {
            Some(at) => {
                let found = kept.bind_groups.remove(at);
                let bind_group = found.1.clone();
                kept.bind_groups.push(found);
                bind_group
            }
            None => {
                let bind = || bind(context, work, &layout, resources, end);
                let bind_group = scopes::guarded_or_left(context.device, bind);
                let bind_group = bind_group.map_err(|error| resource.refused(context, name, error))?;
                if kept.bind_groups.len() >= KEPT {
                    kept.bind_groups.remove(0);
                }
                kept.bind_groups.push((key, bind_group.clone()));
                bind_group
            }
        };
        let label = work.name();
        let Frame { width, height, .. } = *context.frame;
        match (pipeline, resource) {
            (Pipeline::Render(pipeline), CallerResource::Layer(layer, format)) => {
                let drawn = |target| Prepared::Draw { label, pipeline, bind_group, target };
                self.target(&mut kept, context, layer, format, drawn)
                    .map_err(|error| resource.refused(context, name, error))
            }
            (Pipeline::Compute(pipeline), _) => {
                let workgroups = match work {
                    Work::Intake { format, .. } => {
                        let bytes = u64::from(width) * u64::from(height) * u64::from(format.bytes_per_pixel());
                        let texels = 1 << context.frame.source_shift;
                        [texels / LANES, bytes.div_ceil(16 * u64::from(texels)) as u32]
                    }
                    _ => [width.div_ceil(LANES), height],
                };
                Ok(Prepared::Compute { label, pipeline, bind_group, workgroups })
            }
            (Pipeline::Render(_), CallerResource::Buffer(..)) => unreachable!("nothing is drawn into a buffer"),
        }
    }

    /// What is drawn into a layer.
    fn target(
        &self,
        kept: &mut Kept,
        context: &Context<'_>,
        layer: TextureLayer<'_>,
        format: TextureFormat,
        drawn: impl FnOnce(wgpu::TextureView) -> Prepared,
    ) -> Result<Prepared, Error> {
        let seen = layer.seen(format);
        if let Some(at) = kept.targets.iter().position(|(other, _)| *other == seen) {
            let found = kept.targets.remove(at);
            let view = found.1.clone();
            kept.targets.push(found);
            return Ok(drawn(view));
        }
        let view = scopes::guarded_or_left(context.device, || layer.view(format))?;
        let prepared = drawn(view.clone());
        let hash = self.hasher.hash_one(&seen);
        if kept.known.contains(&hash) {
            if kept.targets.len() >= KEPT {
                kept.targets.remove(0);
            }
            kept.targets.push((seen, view));
            return Ok(prepared);
        }
        // A texture that is no target would spoil the caller's encoder: it spoils another one first.
        #[cfg(not(target_arch = "wasm32"))]
        scopes::guarded(context.device, || {
            let mut encoder = context.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            prepared.record(&mut encoder, || None);
            encoder.finish()
        })?;
        kept.remember(hash);
        Ok(prepared)
    }
}
