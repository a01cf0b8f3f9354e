//! Where to compute: the best adapter of the machine, or the CPU, behind one type. Needs the features `gpu` and `cpu`.
//!
//! [`Engine`] is for programs that bring no device of their own. On a device of the caller's, make a
//! [`StereoMatcher`](crate::StereoMatcher).
//!
//! ```
//! use gpu_stereo::backend::{Backend, Beforehand, Engine, Place};
//! use gpu_stereo::{Image, Params, Pixels};
//!
//! let image = Image::new(40, 8, Pixels::Gray8(vec![9; 320]))?;
//! let before = Beforehand::of(&Params::sgm(16))?; // what matchers do not rectify themselves
//! let place = Place::new(Backend::Cpu, None);
//! let engine = Engine::open(&place, None, before.shape(&image), &before.params, &mut |note| eprintln!("{note}"))?;
//! let (matched, _) = engine.compute(&*before.image(&image, 0)?, &*before.image(&image, 1)?, false)?;
//! assert_eq!(before.upright(matched).map.width, 40);
//! # Ok::<(), gpu_stereo::Error>(())
//! ```

mod adapter;
mod beforehand;
mod engine;
mod environment;
mod names;
mod on_cpu;

pub use adapter::{Opened, adapters, choose, driver, kind, open};
pub use beforehand::{Beforehand, Shape, upright};
pub use engine::{Backend, Engine, OnAdapter, Place};
pub use environment::{ensure_known as ensure_environment, why_none};
pub use names::Names;
pub use on_cpu::OnCpu;
