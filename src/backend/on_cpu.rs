//! What computes without an adapter: the native schedule, or the reference.

use crate::backend::beforehand::Shape;
use crate::backend::names::Names;
use crate::cpu::{CpuMatcher, has_own_stages};
use crate::{Error, ImageView, Matched, Method, Params, StageCheck, StageTime, reference};

/// Bytes for each pixel and disparity that the native schedule keeps for a comparison: the cost and the aggregate.
const KEPT_BYTES: u64 = 3;

/// A schedule for the CPU, made for pairs of one size and format.
#[derive(Debug)]
pub enum OnCpu {
    /// The native schedule.
    Native {
        /// It.
        matcher: Box<CpuMatcher>,
        /// A CPU adapter that is there, too.
        adapter: Option<String>,
    },
    /// The definition.
    Reference(Box<Params>),
}

impl OnCpu {
    /// The native schedule for pairs of this shape, if the memory that is left holds them.
    ///
    /// # Errors
    /// As [`CpuMatcher::new`].
    pub fn native(shape: Shape, params: &Params, adapter: Option<String>) -> Result<Self, Error> {
        let Shape { size: [width, height], format } = shape;
        let matcher = CpuMatcher::new(width, height, format, params)?;
        Ok(Self::Native { matcher: Box::new(matcher), adapter })
    }

    /// The reference for pairs of this shape, if the memory that is left holds them.
    ///
    /// # Errors
    /// As [`CpuMatcher::new`].
    pub fn reference(shape: Shape, params: &Params) -> Result<Self, Error> {
        params.accepts(shape.size[0], shape.size[1])?;
        reference::ensure_memory("the CPU reference", shape.size, params, 0)?;
        Ok(Self::Reference(Box::new(params.clone())))
    }

    /// The same for pairs of this shape, with other settings.
    ///
    /// # Errors
    /// As [`CpuMatcher::new`].
    pub fn again(&self, shape: Shape, params: &Params) -> Result<Self, Error> {
        match self {
            Self::Native { adapter, .. } => Self::native(shape, params, adapter.clone()),
            Self::Reference(_) => Self::reference(shape, params),
        }
    }

    /// Makes it fit for pairs of this shape, with these settings.
    ///
    /// # Errors
    /// As [`CpuMatcher::new`].
    pub fn fit(&mut self, shape: Shape, params: &Params) -> Result<(), Error> {
        match self {
            Self::Native { matcher, .. } if matcher.format() == shape.format && matcher.params() == params => {
                return matcher.resize(shape.size[0], shape.size[1]);
            }
            _ => *self = self.again(shape, params)?,
        }
        Ok(())
    }

    /// The maps of a pair, with the time of each stage.
    ///
    /// # Errors
    /// As [`CpuMatcher::compute`].
    pub fn compute<'a>(
        &self,
        left: impl Into<ImageView<'a>>,
        right: impl Into<ImageView<'a>>,
    ) -> Result<(Matched, Vec<StageTime>), Error> {
        match self {
            Self::Native { matcher, .. } => matcher.compute_timed(left, right),
            Self::Reference(params) => reference::compute_timed(left, right, params),
        }
    }

    /// Compares each stage with the reference. The reference itself has nothing to compare.
    ///
    /// # Errors
    /// [`Error::Memory`] if less is left than the comparison takes; otherwise as [`CpuMatcher::check`].
    pub fn check<'a>(
        &self,
        left: impl Into<ImageView<'a>>,
        right: impl Into<ImageView<'a>>,
    ) -> Result<Vec<StageCheck>, Error> {
        let (left, right) = (left.into(), right.into());
        match self {
            Self::Native { matcher, .. } => {
                ensure_check(left, matcher.params(), KEPT_BYTES)?;
                matcher.check(left, right)
            }
            Self::Reference(_) => Ok(Vec::new()),
        }
    }

    /// What it is called. Networks and belief propagation have no instruction set to choose.
    pub fn names<'a>(&self, settings: impl IntoIterator<Item = &'a Params>) -> Names {
        let driver = concat!("gpu-stereo ", env!("CARGO_PKG_VERSION")).to_owned();
        let (adapter, backend) = match self {
            Self::Native { matcher, .. } if settings.into_iter().any(|params| has_own_stages(params.method)) => {
                (format!("CPU with {}", matcher.instructions()), "cpu")
            }
            Self::Native { .. } => ("CPU".into(), "cpu"),
            Self::Reference(_) => ("CPU reference".into(), "reference"),
        };
        let also = match self {
            Self::Native { adapter, .. } => adapter.clone(),
            Self::Reference(_) => None,
        };
        Names { adapter, backend: backend.into(), driver, also }
    }

    /// Whether a frame takes so little time that it is usually computed several times.
    pub fn is_quick(&self, params: &Params) -> bool {
        matches!(self, Self::Native { .. }) && has_own_stages(params.method)
    }
}

/// Refuses a comparison with the reference for which less memory is left than it takes: every path and the aggregate, and what
/// the other schedule keeps.
pub(super) fn ensure_check(image: ImageView<'_>, params: &Params, kept: u64) -> Result<(), Error> {
    let more = match params.method {
        Method::Sgm => 2 + u64::from(params.paths.count()),
        Method::Bp => 7,
        Method::Psmnet => 4, // doubles
        _ => 3,
    };
    let size = [image.width(), image.height()];
    reference::ensure_memory("the reference that --check compares with", size, params, more + kept)
}
