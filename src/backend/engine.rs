//! The engine computes the maps of pairs of one size and format: on an adapter, by the native schedule or by the reference.

use std::fmt;
use std::str::FromStr;

use wgpu::DeviceType;

use crate::backend::adapter::{self, Opened};
use crate::backend::beforehand::Shape;
use crate::backend::environment;
use crate::backend::names::Names;
use crate::backend::on_cpu::{self, OnCpu};
use crate::{Error, ImageView, Matched, Method, Params, StageCheck, StageTime, StereoMatcher};

/// Where to compute.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Backend {
    /// The best GPU, else the CPU.
    #[default]
    Auto,
    /// The shaders on any adapter, a CPU adapter such as lavapipe included.
    Gpu,
    /// The native schedule, without an adapter.
    Cpu,
    /// The definition, slow.
    Reference,
}

impl Backend {
    /// All of them by their names.
    pub const NAMED: [(&'static str, Self); 4] =
        [("auto", Self::Auto), ("gpu", Self::Gpu), ("cpu", Self::Cpu), ("reference", Self::Reference)];

    /// Its name.
    pub fn name(self) -> &'static str {
        Self::NAMED.iter().find(|(_, backend)| *backend == self).map_or("", |(name, _)| name)
    }

    /// Whether it may compute on an adapter.
    pub fn takes_adapters(self) -> bool {
        matches!(self, Self::Auto | Self::Gpu)
    }
}

impl fmt::Display for Backend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Backend {
    type Err = Error;

    /// The one of this name.
    fn from_str(text: &str) -> Result<Self, Error> {
        let named = Self::NAMED.iter().find(|(name, _)| *name == text).map(|(_, backend)| *backend);
        named.ok_or_else(|| Error::no_name("backend", text, Self::NAMED.iter().map(|(name, _)| *name)))
    }
}

/// Where to compute: the backend, and on which adapter.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Place {
    /// The backend.
    pub backend: Backend,
    /// The adapter by its index or a part of its name, for the backends that take one; the best, if it is not given.
    pub adapter: Option<String>,
}

impl Place {
    /// By this backend, on the adapter of this index or part of a name.
    #[must_use]
    pub fn new(backend: Backend, adapter: Option<String>) -> Self {
        Self { backend, adapter }
    }
}

/// An adapter with a matcher, or what computes without one.
#[derive(Debug)]
pub enum Engine {
    /// On an adapter.
    Adapter(Box<OnAdapter>),
    /// On the CPU.
    Cpu(OnCpu),
}

/// An adapter and its matcher.
#[derive(Debug)]
pub struct OnAdapter {
    /// The device.
    pub opened: Opened,
    /// The matcher.
    pub matcher: StereoMatcher,
}

impl Engine {
    /// What computes with these settings maps of pairs of this shape. `needed_for`: what only an adapter can do. Adapters that
    /// cannot run the kernels are skipped, and `note` is given a sentence for each.
    ///
    /// # Errors
    /// [`Error::Parameter`] with the name `adapter` or `backend` if there is none as asked for; otherwise as [`StereoMatcher::new`] and
    /// [`CpuMatcher::new`](crate::cpu::CpuMatcher::new).
    pub fn open(
        place: &Place,
        needed_for: Option<&str>,
        shape: Shape,
        params: &Params,
        note: &mut dyn FnMut(String),
    ) -> Result<Self, Error> {
        let (backend, wanted) = (place.backend, place.adapter.as_deref());
        match backend {
            Backend::Cpu => return Ok(Self::Cpu(OnCpu::native(shape, params, None)?)),
            Backend::Reference => return Ok(Self::Cpu(OnCpu::reference(shape, params)?)),
            Backend::Auto | Backend::Gpu => {}
        }
        let mut adapters = adapter::adapters()?;
        if let Some(wanted) = wanted {
            let names: Vec<_> = adapters.iter().map(|adapter| adapter.get_info().name).collect();
            adapters = vec![adapters.swap_remove(adapter::choose(&names, wanted)?)];
        }
        let only = adapters.len() == 1 && wanted.is_some();
        let takes_all = backend == Backend::Gpu || wanted.is_some() || needed_for.is_some();
        let mut passed = None;
        for adapter in &adapters {
            let info = adapter.get_info();
            if info.device_type == DeviceType::Cpu && !takes_all && !on_cpu_adapters(params.method) {
                passed.get_or_insert(info.name);
                continue;
            }
            let opened = adapter::open(adapter).and_then(|opened| Self::on(opened, shape, params));
            match opened {
                Ok(engine) => return Ok(engine),
                // An adapter that cannot run the kernels is skipped, and that is reported.
                Err(error @ (Error::Adapter(_) | Error::Device(_) | Error::Refused(_))) if !only => {
                    note(format!("{}: {error}", info.name));
                }
                Err(error) => return Err(error),
            }
        }
        let why = environment::why_none();
        if backend == Backend::Gpu {
            return Err(Error::Parameter {
                name: "backend",
                given: "gpu".into(),
                allowed: format!("auto or cpu, since there is no usable adapter{why}"),
                remedy: "install a Vulkan driver, or use auto or cpu",
            });
        }
        if let Some(what) = needed_for {
            return Err(Error::Adapter(format!(
                "{what}, but there is no usable adapter{why}; install a Vulkan driver"
            )));
        }
        if adapters.is_empty() && !why.is_empty() {
            note(format!("there is no adapter{why}; computing on the CPU"));
        }
        Ok(Self::Cpu(OnCpu::native(shape, params, passed)?))
    }

    /// The same with other settings or for pairs of another shape, on the same adapter; a new one, as [`Engine::open`] gives it,
    /// where another one computes faster with these settings.
    ///
    /// # Errors
    /// As [`Engine::open`].
    pub fn again(
        self,
        place: &Place,
        shape: Shape,
        params: &Params,
        note: &mut dyn FnMut(String),
    ) -> Result<Self, Error> {
        let by_method = place.backend == Backend::Auto && place.adapter.is_none();
        let fits = match &self {
            Self::Adapter(on) => on.opened.info.device_type != DeviceType::Cpu || on_cpu_adapters(params.method),
            Self::Cpu(OnCpu::Native { adapter, .. }) => adapter.is_none() || !on_cpu_adapters(params.method),
            Self::Cpu(OnCpu::Reference(_)) => true,
        };
        match self {
            _ if by_method && !fits => Self::open(place, None, shape, params, note),
            Self::Adapter(on) => {
                let OnAdapter { opened, matcher } = *on;
                drop(matcher); // its memory goes to the next one
                Self::on(opened, shape, params)
            }
            Self::Cpu(on) => Ok(Self::Cpu(on.again(shape, params)?)),
        }
    }

    fn on(opened: Opened, shape: Shape, params: &Params) -> Result<Self, Error> {
        let Shape { size: [width, height], format } = shape;
        let matcher = StereoMatcher::new(&opened.device, &opened.queue, width, height, format, params);
        opened.fault()?;
        let matcher = matcher?;
        Ok(Self::Adapter(Box::new(OnAdapter { opened, matcher })))
    }

    /// The maps of a pair of its shape; if `timed`, with the time of each stage.
    ///
    /// # Errors
    /// As [`StereoMatcher::compute_timed_blocking`] and [`CpuMatcher::compute_timed`](crate::cpu::CpuMatcher::compute_timed);
    /// [`Error::Lost`] if the device failed outside any call.
    pub fn compute<'a>(
        &self,
        left: impl Into<ImageView<'a>>,
        right: impl Into<ImageView<'a>>,
        timed: bool,
    ) -> Result<(Matched, Vec<StageTime>), Error> {
        let (left, right) = (left.into(), right.into());
        match self {
            Self::Adapter(on) => {
                let OnAdapter { opened, matcher } = on.as_ref();
                let frame = if timed {
                    matcher.compute_timed_blocking(left, right)
                } else {
                    matcher.compute_blocking(left, right).map(|matched| (matched, Vec::new()))
                };
                opened.fault()?;
                frame
            }
            Self::Cpu(on) if timed => on.compute(left, right),
            Self::Cpu(on) => on.compute(left, right).map(|(matched, _)| (matched, Vec::new())),
        }
    }

    /// Compares each stage with the reference; nothing, if it is the reference itself.
    ///
    /// # Errors
    /// [`Error::Memory`] if less is left than the comparison takes; otherwise as [`Engine::compute`].
    pub fn check<'a>(
        &self,
        left: impl Into<ImageView<'a>>,
        right: impl Into<ImageView<'a>>,
    ) -> Result<Vec<StageCheck>, Error> {
        let (left, right) = (left.into(), right.into());
        match self {
            Self::Adapter(on) => {
                let OnAdapter { opened, matcher } = on.as_ref();
                on_cpu::ensure_check(left, matcher.params(), 0)?;
                let stages = matcher.check_blocking(left, right);
                opened.fault()?;
                stages
            }
            Self::Cpu(on) => on.check(left, right),
        }
    }

    /// The names and texts of the kernels; none without an adapter.
    pub fn shaders(&self) -> Vec<(String, &str)> {
        match self {
            Self::Adapter(on) => on.matcher.shaders(),
            Self::Cpu(_) => Vec::new(),
        }
    }

    /// The names of the adapter and its driver, or of what computes without one.
    pub fn names<'a>(&self, settings: impl IntoIterator<Item = &'a Params>) -> Names {
        match self {
            Self::Adapter(on) => {
                let info = &on.opened.info;
                let (adapter, backend) = (info.name.clone(), info.backend.to_string());
                Names { adapter, backend, driver: adapter::driver(info), also: None }
            }
            Self::Cpu(on) => on.names(settings),
        }
    }

    /// Whether frames are usually timed by several of them: where one takes little time, and the first more than others.
    pub fn is_quick(&self, params: &Params) -> bool {
        match self {
            Self::Adapter(_) => true,
            Self::Cpu(on) => on.is_quick(params),
        }
    }

    /// Bytes in use on the device, 0 without one.
    pub fn device_bytes(&self) -> u64 {
        match self {
            Self::Adapter(on) => on.matcher.device_bytes(),
            Self::Cpu(_) => 0,
        }
    }
}

/// Whether `--backend auto` takes a CPU adapter, where there is no GPU: for methods that the native schedule computes as slowly as
/// the reference does.
fn on_cpu_adapters(method: Method) -> bool {
    matches!(method, Method::Bp)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PixelFormat;

    #[test]
    fn pairs_without_pixels_are_refused() {
        for backend in [Backend::Cpu, Backend::Reference] {
            for size in [[0, 8], [8, 0], [0, 0]] {
                let (place, shape) = (Place { backend, adapter: None }, Shape { size, format: PixelFormat::Gray8 });
                let error = Engine::open(&place, None, shape, &Params::sgm(8), &mut |_| ()).unwrap_err();
                assert!(error.to_string().contains("must have at least one pixel"), "{error}");
            }
        }
    }
}
