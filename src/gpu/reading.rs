//! Maps on their way to the host.

use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll, Waker};

use crate::gpu::device::Pulse;
use crate::gpu::maps::MapBytes;
use crate::gpu::readback::{self, Mapping, Waiter};
use crate::gpu::scopes::Verdict;
use crate::gpu::spans::span;
use crate::{Error, Matched};

/// Maps on their way to the host. A future that any executor drives; it owns all that it needs, so that the matcher may go
/// on meanwhile. Where nobody waits for it, [`Reading::try_take`] looks whether they are there.
#[derive(Debug)]
#[must_use = "the maps are lost if nobody takes them"]
pub struct Reading {
    state: Option<Result<Awaited, Error>>,
}

/// A buffer that is going to be mapped, and what is made of it.
#[derive(Debug)]
pub(crate) struct Awaited {
    pub(crate) device: wgpu::Device,
    pub(crate) pulse: Pulse,
    /// The errors that the device reports, where they were not known yet.
    pub(crate) verdict: Option<Verdict>,
    pub(crate) waiter: Arc<Waiter>,
    pub(crate) mapping: Mapping,
    pub(crate) buffer: wgpu::Buffer,
    pub(crate) maps: MapBytes,
    pub(crate) spare: Arc<Mutex<Vec<wgpu::Buffer>>>,
}

impl Awaited {
    /// The maps, and the buffer goes back to the others.
    fn taken(self, mapped: Result<(), Error>) -> Result<Matched, Error> {
        let matched = mapped.and_then(|()| {
            readback::taken(&self.device, &self.buffer, |bytes| self.maps.matched(&bytes[..self.maps.bytes() as usize]))
        });
        self.pulse.check()?; // nobody goes on with a lost device by mistake
        self.spare.lock().unwrap_or_else(PoisonError::into_inner).push(self.buffer);
        matched
    }

    /// The error that the device reports, if there is one; then `mapped` tells whether the buffer is mapped.
    fn poll_with(
        &mut self,
        context: &mut Context<'_>,
        mapped: impl FnOnce(&Self, &mut Context<'_>) -> Poll<Result<(), Error>>,
    ) -> Poll<Result<(), Error>> {
        if let Some(verdict) = &mut self.verdict {
            match Pin::new(verdict).poll(context) {
                Poll::Ready(Ok(())) => self.verdict = None,
                other => return other,
            }
        }
        mapped(self, context)
    }
}

impl Reading {
    pub(crate) fn awaited(awaited: Awaited) -> Self {
        Self { state: Some(Ok(awaited)) }
    }

    pub(crate) fn failed(error: Error) -> Self {
        Self { state: Some(Err(error)) }
    }

    /// The maps, if they have arrived. Does not wait. `None` once they were taken.
    pub fn try_take(&mut self) -> Option<Result<Matched, Error>> {
        let mapped = match self.state.as_mut()? {
            Ok(awaited) => {
                let now = |awaited: &Awaited| awaited.mapping.now(&awaited.device).map_or(Poll::Pending, Poll::Ready);
                match awaited.poll_with(&mut Context::from_waker(Waker::noop()), |awaited, _| now(awaited)) {
                    Poll::Ready(mapped) => mapped,
                    Poll::Pending => return None,
                }
            }
            Err(_) => Ok(()),
        };
        self.finish(mapped)
    }

    /// The maps. Blocks until they are there.
    ///
    /// # Errors
    /// [`Error::Lost`] if the device fails; [`Error::Misuse`] if the maps were taken before.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn wait_blocking(mut self) -> Result<Matched, Error> {
        self.take_blocking()
    }

    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn take_blocking(&mut self) -> Result<Matched, Error> {
        span!(DEBUG, "wait");
        let mapped = match &mut self.state {
            Some(Ok(awaited)) => {
                let verdict = awaited.verdict.take().map_or(Ok(()), Verdict::now);
                verdict.and_then(|()| awaited.mapping.wait(&awaited.device))
            }
            _ => Ok(()),
        };
        self.finish(mapped).unwrap_or_else(Self::gone)
    }

    fn finish(&mut self, mapped: Result<(), Error>) -> Option<Result<Matched, Error>> {
        Some(self.state.take()?.and_then(|awaited| awaited.taken(mapped)))
    }

    fn gone() -> Result<Matched, Error> {
        Err(Error::Misuse("the maps of this Reading were taken before; read once more to have them again".into()))
    }
}

impl Future for Reading {
    type Output = Result<Matched, Error>;

    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        let mapped = match &mut self.state {
            Some(Ok(awaited)) => {
                let mapped = |awaited: &Awaited, context: &mut Context<'_>| {
                    awaited.waiter.poll(&awaited.device, &awaited.mapping, context)
                };
                match awaited.poll_with(context, mapped) {
                    Poll::Ready(mapped) => mapped,
                    Poll::Pending => return Poll::Pending,
                }
            }
            _ => Ok(()),
        };
        Poll::Ready(self.finish(mapped).unwrap_or_else(Self::gone))
    }
}
