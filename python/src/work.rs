//! Work that does not hold Python, on threads of this process.
//!
//! Rayon's own pool does not live through a fork: a child has none of its threads, and would wait for them forever. So each process has
//! a pool of its own.

use crate::errors::wrong;
use pyo3::marker::Ungil;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::process;
use std::sync::{Arc, Mutex, PoisonError};

/// The pool, and the process that made it.
static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// The pool of this process.
pub fn pool() -> PyResult<Arc<ThreadPool>> {
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((maker, pool)) = &*pool
        && *maker == process::id()
    {
        return Ok(Arc::clone(pool));
    }
    let made = ThreadPoolBuilder::new().thread_name(|i| format!("gpu-stereo {i}")).build();
    let made = Arc::new(made.map_err(|error| wrong(format!("no threads can be started: {error}")))?);
    // Another process' pool waits for threads that are not here.
    std::mem::forget(pool.replace((process::id(), Arc::clone(&made))));
    Ok(made)
}

/// Does work on all cores; Python runs meanwhile.
pub fn detached<T: Ungil + Send>(py: Python<'_>, work: impl FnOnce() -> T + Ungil + Send) -> PyResult<T> {
    let pool = pool()?;
    Ok(py.detach(|| pool.install(work)))
}

/// The process that made something with threads or a device, which a fork does not take along.
#[derive(Clone, Copy)]
pub struct Maker(u32);

impl Maker {
    /// This process.
    pub fn here() -> Self {
        Self(process::id())
    }

    /// Refuses to use it in a child.
    pub fn ensure_here(self, what: &str) -> PyResult<()> {
        if self.0 == process::id() {
            return Ok(());
        }
        Err(wrong(format!(
            "{what} was made before the process was forked, and a child has neither its threads nor its device; make one in each process"
        )))
    }
}
