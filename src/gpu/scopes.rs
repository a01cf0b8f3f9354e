//! The only code that opens error scopes: the errors that a device reports become [`Error`].

use std::pin::Pin;
use std::sync::{Mutex, PoisonError};
use std::task::{Context, Poll, Waker};

use crate::Error;

#[cfg(not(target_arch = "wasm32"))]
type Pending = dyn Future<Output = Result<(), Error>> + Send;
#[cfg(target_arch = "wasm32")]
type Pending = dyn Future<Output = Result<(), Error>>;

/// The errors that a device reports for some work: known at once outside browsers, in a browser later. A future.
#[must_use = "the errors that the device reports are lost if nobody looks"]
pub(crate) struct Verdict(State);

enum State {
    Known(Result<(), Error>),
    Awaited(Mutex<Pin<Box<Pending>>>),
    Given,
}

impl std::fmt::Debug for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let state = match &self.0 {
            State::Known(result) => return f.debug_tuple("Verdict").field(result).finish(),
            State::Awaited(_) => "awaited",
            State::Given => "given",
        };
        f.debug_tuple("Verdict").field(&state).finish()
    }
}

impl Verdict {
    /// Of the futures of error scopes, those that name the cause before those that name its consequences.
    fn of<F>(scopes: [F; 3]) -> Self
    where
        F: Future<Output = Option<wgpu::Error>> + wgpu::WasmNotSend + 'static,
    {
        let mut pending: Pin<Box<Pending>> = Box::pin(async move {
            let mut first = None;
            for scope in scopes {
                first = first.or(scope.await); // all of them, or the browser complains
            }
            match first {
                None => Ok(()),
                Some(wgpu::Error::OutOfMemory { .. }) => Err(Error::OutOfMemory),
                Some(error) => Err(Error::Refused(one_line(&error.to_string()))),
            }
        });
        match pending.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(result) => Self(State::Known(result)),
            Poll::Pending => Self(State::Awaited(Mutex::new(pending))),
        }
    }

    /// The error, if one is known; `None` if there is known to be none; else the verdict, to be awaited.
    pub(crate) fn or_later(self) -> Result<Option<Self>, Error> {
        match self.0 {
            State::Known(result) => result.map(|()| None),
            State::Awaited(_) => Ok(Some(self)),
            State::Given => Ok(None),
        }
    }

    /// The verdict, where it is known. It is an error if it is not: the work must not pass for done.
    #[cfg(any(not(target_arch = "wasm32"), test))]
    pub(crate) fn now(self) -> Result<(), Error> {
        let unknown = "it has not said yet whether it takes the work; await the asynchronous function of that name";
        match self.or_later()? {
            None => Ok(()),
            Some(_) => Err(Error::Lost(unknown.into())),
        }
    }
}

impl Future for Verdict {
    type Output = Result<(), Error>;

    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        match std::mem::replace(&mut self.0, State::Given) {
            State::Known(result) => Poll::Ready(result),
            State::Given => Poll::Ready(Ok(())),
            State::Awaited(pending) => {
                let mut future = pending.into_inner().unwrap_or_else(PoisonError::into_inner);
                let result = future.as_mut().poll(context);
                if result.is_pending() {
                    self.0 = State::Awaited(Mutex::new(future));
                }
                result
            }
        }
    }
}

/// Does work, and catches the errors that the device reports, which would else reach the caller's error handler.
pub(crate) fn watched<T>(device: &wgpu::Device, work: impl FnOnce() -> T) -> (T, Verdict) {
    let memory = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let internal = device.push_error_scope(wgpu::ErrorFilter::Internal);
    let validation = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let result = work();
    let (validation, internal, memory) = (validation.pop(), internal.pop(), memory.pop());
    // What is made without memory is invalid afterwards: the cause comes before its consequences.
    (result, Verdict::of([memory, internal, validation]))
}

/// As [`watched`], for functions that do not wait: outside browsers.
#[cfg(any(not(target_arch = "wasm32"), test))]
pub(crate) fn guarded<T>(device: &wgpu::Device, work: impl FnOnce() -> T) -> Result<T, Error> {
    let (result, verdict) = watched(device, work);
    verdict.now().map(|()| result)
}

/// As [`guarded`]. In a browser, where errors are not known yet, they go to the caller's own error scopes and error handler,
/// like those of the caller's own calls.
pub(crate) fn guarded_or_left<T>(device: &wgpu::Device, work: impl FnOnce() -> T) -> Result<T, Error> {
    #[cfg(not(target_arch = "wasm32"))]
    return guarded(device, work);
    #[cfg(target_arch = "wasm32")]
    {
        let _ = device;
        Ok(work())
    }
}

pub(crate) fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An error scope of a browser: its future is not ready at first, and wakes who waits for it.
    struct Late(u32, Option<wgpu::Error>);

    impl Future for Late {
        type Output = Option<wgpu::Error>;

        fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
            if self.0 == 0 {
                return Poll::Ready(self.1.take());
            }
            self.0 -= 1;
            context.waker().wake_by_ref();
            Poll::Pending
        }
    }

    fn validation() -> Option<wgpu::Error> {
        let text = || "the shader\n  is wrong".to_string();
        Some(wgpu::Error::Validation { source: text().into(), description: text() })
    }

    fn memory() -> Option<wgpu::Error> {
        Some(wgpu::Error::OutOfMemory { source: "no room".into() })
    }

    /// An error that arrives late is awaited, whichever scope it comes from.
    #[test]
    fn a_scope_that_answers_late_is_awaited() {
        for polls in 0..4 {
            for place in 0..3 {
                let scopes = || [0, 1, 2].map(|i| Late(polls, (i == place).then(validation).flatten()));
                let Err(Error::Refused(text)) = pollster::block_on(Verdict::of(scopes())) else {
                    panic!("{polls} {place}")
                };
                assert!(text.contains("the shader is wrong"), "{text}");
            }
            assert!(pollster::block_on(Verdict::of([0, 1, 2].map(|_| Late(polls, None)))).is_ok());
            let both = [Late(polls, memory()), Late(0, None), Late(0, validation())];
            assert!(matches!(pollster::block_on(Verdict::of(both)), Err(Error::OutOfMemory)));
        }
    }

    /// Without waiting, an unknown outcome is no success.
    #[test]
    fn what_is_not_known_is_no_success() {
        let late = || Verdict::of([Late(1, None), Late(0, None), Late(0, None)]);
        let Err(Error::Lost(text)) = late().now() else { panic!("success") };
        assert!(text.contains("await"), "{text}");
        let later = late().or_later().unwrap().unwrap();
        assert!(pollster::block_on(later).is_ok());
        assert!(Verdict::of([Late(0, None), Late(0, None), Late(0, None)]).or_later().unwrap().is_none());
        assert!(Verdict::of([Late(0, memory()), Late(0, None), Late(0, None)]).or_later().is_err());
    }

    /// A scope that is opened or closed elsewhere is one that nobody may wait for.
    #[test]
    fn scopes_are_opened_here_alone() {
        fn files(folder: &std::path::Path, found: &mut Vec<std::path::PathBuf>) {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() { files(&path, found) } else { found.push(path) }
            }
        }
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
        let mut found = Vec::new();
        files(&folder, &mut found);
        assert!(found.iter().any(|path| path.ends_with("scopes.rs")) && found.len() > 40, "{found:?}");
        let names = [["error", "_scope"].concat(), ["ErrorScope", "Guard"].concat()];
        for path in found {
            let text = String::from_utf8_lossy(&std::fs::read(&path).unwrap()).into_owned();
            let counted = text.matches(&names[0]).count() + text.matches(&names[1]).count();
            let allowed = match path.strip_prefix(&folder).unwrap().to_str().unwrap() {
                "gpu/scopes.rs" => 3,
                "gpu/device.rs" => 1, // a test of it
                _ => 0,
            };
            assert_eq!(counted, allowed, "{} opens error scopes; use `scopes::watched`", path.display());
        }
    }
}
