//! The only code that waits for the device.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker};
#[cfg(not(target_arch = "wasm32"))]
use std::time::Duration;

use crate::Error;
use crate::gpu::scopes;

/// A buffer that the host reads.
pub(crate) fn buffer(device: &wgpu::Device, label: &str, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

fn lost(error: &dyn std::fmt::Display) -> Error {
    Error::Lost(format!("{}; run again, or take another adapter", scopes::one_line(&error.to_string())))
}

/// What becomes of a request to map a buffer.
#[derive(Debug, Default)]
struct Request {
    result: Option<Result<(), String>>,
    waker: Option<Waker>,
}

/// A request to map a buffer once all work submitted before is done. A future, driven by the device or by the [`Waiter`]. If it
/// is dropped before, the buffer remains to be unmapped.
#[derive(Clone, Debug)]
pub(crate) struct Mapping(Arc<Mutex<Request>>);

impl Mapping {
    /// Asks for the whole buffer.
    pub(crate) fn new(buffer: &wgpu::Buffer, mode: wgpu::MapMode) -> Self {
        let mapping = Self(Arc::default());
        let told = mapping.clone();
        buffer.map_async(mode, .., move |result| told.tell(result.map_err(|error| error.to_string())));
        mapping
    }

    fn request(&self) -> MutexGuard<'_, Request> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn tell(&self, result: Result<(), String>) {
        let waker = {
            let mut request = self.request();
            request.result.get_or_insert(result);
            request.waker.take()
        };
        if let Some(waker) = waker {
            waker.wake();
        }
    }

    fn is_done(&self) -> bool {
        self.request().result.is_some()
    }

    /// The result, if it is there.
    fn result(&self) -> Option<Result<(), Error>> {
        self.request().result.clone().map(|result| result.map_err(|text| lost(&text)))
    }

    /// Polls the device, and returns the result if there is one. Does not wait.
    pub(crate) fn now(&self, device: &wgpu::Device) -> Option<Result<(), Error>> {
        if !self.is_done() {
            let _ = device.poll(wgpu::PollType::Poll); // that nothing is done yet is no error
        }
        self.result()
    }

    /// Blocks until the result is there.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn wait(&self, device: &wgpu::Device) -> Result<(), Error> {
        /// Meanwhile those are told that wait for earlier work.
        const AT_A_TIME: Duration = Duration::from_millis(100);
        self.drive(device, Some(AT_A_TIME));
        self.result().unwrap_or_else(|| Err(lost(&"it did not answer")))
    }

    /// Waits for all that was submitted, or in turns of `at_a_time`: others may want the device in between.
    #[cfg(not(target_arch = "wasm32"))]
    fn drive(&self, device: &wgpu::Device, at_a_time: Option<Duration>) {
        let mut idle = 0;
        while !self.is_done() {
            match device.poll(wgpu::PollType::Wait { submission_index: None, timeout: at_a_time }) {
                Err(wgpu::PollError::Timeout) => {}
                Err(error) => self.tell(Err(error.to_string())),
                Ok(status) if !status.is_queue_empty() || self.is_done() => {}
                // The queue is empty, so another thread polled the callback and is about to store the result.
                Ok(_) if idle < 1000 => {
                    idle += 1;
                    std::thread::sleep(Duration::from_millis(1));
                }
                Ok(_) => self.tell(Err("it did not answer".into())),
            }
        }
    }
}

/// Polls a device while futures are awaited: a thread, started at the first need. In a browser the device polls itself.
#[derive(Debug, Default)]
pub(crate) struct Waiter {
    #[cfg(not(target_arch = "wasm32"))]
    requests: std::sync::OnceLock<std::sync::mpsc::Sender<Mapping>>,
}

impl Waiter {
    /// Waits for a mapping.
    pub(crate) async fn until(&self, device: &wgpu::Device, mapping: &Mapping) -> Result<(), Error> {
        std::future::poll_fn(|context| self.poll(device, mapping, context)).await
    }

    /// Polls a mapping as a future.
    pub(crate) fn poll(
        &self,
        device: &wgpu::Device,
        mapping: &Mapping,
        context: &mut Context<'_>,
    ) -> Poll<Result<(), Error>> {
        if let Some(result) = mapping.now(device) {
            return Poll::Ready(result);
        }
        let first = {
            let mut request = mapping.request();
            if let Some(result) = request.result.clone() {
                return Poll::Ready(result.map_err(|text| lost(&text)));
            }
            request.waker.replace(context.waker().clone()).is_none()
        };
        if first {
            self.attend(device, mapping);
        }
        Poll::Pending
    }

    #[cfg(target_arch = "wasm32")]
    fn attend(&self, _: &wgpu::Device, _: &Mapping) {}

    #[cfg(not(target_arch = "wasm32"))]
    fn attend(&self, device: &wgpu::Device, mapping: &Mapping) {
        /// The device is held this long at most.
        const AT_A_TIME: Duration = Duration::from_millis(1);
        let requests = self.requests.get_or_init(|| {
            let (sender, requests) = std::sync::mpsc::channel::<Mapping>();
            let device = device.clone();
            let work = move || requests.iter().for_each(|mapping| mapping.drive(&device, Some(AT_A_TIME)));
            // Without a thread the receiver is dropped, which the next line finds.
            let _ = std::thread::Builder::new().name("gpu-stereo.waiter".into()).spawn(work);
            sender
        });
        if requests.send(mapping.clone()).is_err() {
            mapping.tell(Err("no thread can be started to wait for the device".into()));
        }
    }
}

/// Part of a mapped buffer, for the host to write.
pub(crate) fn written(buffer: &wgpu::Buffer, part: std::ops::Range<u64>) -> Result<wgpu::BufferViewMut, Error> {
    buffer.get_mapped_range_mut(part).map_err(|error| lost(&error))
}

/// Hands the bytes of a mapped buffer to `take`, and unmaps it.
pub(crate) fn taken<T>(
    device: &wgpu::Device,
    buffer: &wgpu::Buffer,
    take: impl FnOnce(&[u8]) -> T,
) -> Result<T, Error> {
    scopes::guarded_or_left(device, || {
        let value = match buffer.get_mapped_range(..) {
            Ok(view) => Ok(take(&view)),
            Err(error) => Err(lost(&error)),
        };
        buffer.unmap();
        value
    })?
}

/// Waits for all submitted work, then hands the bytes of `buffer` to `take`.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) fn read<T>(device: &wgpu::Device, buffer: &wgpu::Buffer, take: impl FnOnce(&[u8]) -> T) -> Result<T, Error> {
    scopes::guarded(device, || Mapping::new(buffer, wgpu::MapMode::Read))?.wait(device)?;
    taken(device, buffer, take)
}

/// Copies `bytes` from the start of `buffer` to the host.
pub(crate) async fn copy(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    waiter: &Waiter,
    from: &wgpu::Buffer,
    bytes: u64,
) -> Result<Vec<u8>, Error> {
    let ((staging, mapping), verdict) = scopes::watched(device, || {
        let staging = buffer(device, "gpu-stereo.readback", bytes);
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(from, 0, &staging, 0, bytes);
        queue.submit([encoder.finish()]);
        let mapping = Mapping::new(&staging, wgpu::MapMode::Read);
        (staging, mapping)
    });
    verdict.await?;
    waiter.until(device, &mapping).await?;
    taken(device, &staging, <[u8]>::to_vec)
}

/// Waits for a future on this thread.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) fn block_on<T>(future: impl Future<Output = T>) -> T {
    struct Unpark(std::thread::Thread);
    impl std::task::Wake for Unpark {
        fn wake(self: Arc<Self>) {
            self.0.unpark();
        }
    }
    let waker = Waker::from(Arc::new(Unpark(std::thread::current())));
    let mut future = std::pin::pin!(future);
    loop {
        match future.as_mut().poll(&mut Context::from_waker(&waker)) {
            Poll::Ready(value) => return value,
            Poll::Pending => std::thread::park(),
        }
    }
}
