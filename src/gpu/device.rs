//! Whether the caller's device is lost, and which resources belong to it.

use std::fmt::{self, Debug, Write};

use crate::Error;
use crate::gpu::scopes;

/// The caller's device and queue.
#[derive(Clone, Debug)]
pub(crate) struct Pulse {
    device: wgpu::Device,
    queue: wgpu::Queue,
    /// Only written to by calls that must fail: see [`Pulse::check`].
    probe: wgpu::Buffer,
    /// Whether the owner of a resource can be found out.
    knows: bool,
}

impl Pulse {
    /// # Errors
    /// [`Error::Misuse`] if the queue is another device's, [`Error::Lost`] if the device is lost.
    pub(crate) fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Self, Error> {
        let known = belongs(queue, device);
        if known == Some(false) {
            let text = "the queue is of another device than the one given; take the queue that came with the device";
            return Err(Error::Misuse(text.into()));
        }
        let probe = || {
            let probe = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("gpu-stereo.probe"),
                size: wgpu::COPY_BUFFER_ALIGNMENT,
                usage: wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            queue.write_buffer(&probe, 0, &[]);
            probe
        };
        // What is made on a lost device is invalid.
        let probe = scopes::guarded_or_left(device, probe).map_err(|error| match error {
            Error::OutOfMemory => error,
            _ => lost(),
        })?;
        let pulse = Self { device: device.clone(), queue: queue.clone(), probe, knows: known.is_some() };
        pulse.check()?;
        Ok(pulse)
    }

    /// # Errors
    /// [`Error::Lost`] if the device is lost. In a browser this is known only when a result is awaited, and then from it.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn check(&self) -> Result<(), Error> {
        Ok(())
    }

    /// # Errors
    /// [`Error::Lost`] if the device is lost.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn check(&self) -> Result<(), Error> {
        // wgpu has one callback for the loss, which is the caller's. But a lost device objects to nothing, not even to a
        // write of nothing to a place where none can be.
        match scopes::guarded(&self.device, || self.queue.write_buffer(&self.probe, 1, &[])) {
            Ok(()) => Err(lost()),
            Err(_) => Ok(()),
        }
    }

    /// An error of the device's, or that the device is lost if that is why.
    pub(crate) fn cause(&self, error: Error) -> Error {
        self.check().err().unwrap_or(error)
    }

    /// Whether a texture, a buffer or an encoder is of this device. See [`belongs`].
    pub(crate) fn owns(&self, thing: &dyn Debug) -> bool {
        !self.knows || belongs(&self.queue, thing) != Some(false)
    }
}

fn lost() -> Error {
    Error::Lost("device lost; run again with a new device, or take another adapter".into())
}

/// Whether a thing of wgpu's was made by the device of `queue`. None where that cannot be found out: in a browser, which
/// looks itself.
///
/// wgpu has no function for this. It names things by numbers that begin anew with each instance, so a texture of another
/// instance is taken for the one of this instance that has its number, or wgpu panics because there is none. But all
/// things of a device share the lock of its error scopes, and say in their debug text whether it is taken. While the queue
/// writes its own debug text it holds that lock; so a thing that writes now that it is free has another one.
fn belongs(queue: &wgpu::Queue, thing: &dyn Debug) -> Option<bool> {
    // Another thread may hold a lock for a moment. So one of the queue's must be seen free and taken in turns.
    const TURNS: usize = 12; // by chance in one of thousands, if others take and leave it all the time
    const TRIES: usize = 1000;
    let mut turns = 0;
    for _ in 0..TRIES {
        let mut held = Look { thing, found: None };
        let _ = write!(held, "{queue:?}"); // ends as soon as it is known
        match held.found {
            Some(Lock::Free) => return Some(false),
            Some(Lock::Taken) if Shown::by(thing) == Some(Lock::Free) => turns += 1,
            _ => std::thread::yield_now(),
        }
        if turns == TURNS {
            return Some(true);
        }
    }
    None
}

/// How a thing shows the lock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Lock {
    Free,
    Taken,
}

/// Looks at `thing` while the lock of what is written is held.
struct Look<'a> {
    thing: &'a dyn Debug,
    found: Option<Lock>,
}

/// What wgpu shows of error scopes whose lock is free.
const SCOPES: &str = "ErrorSink";

/// What it shows of a lock that is taken.
const LOCKED: &str = "<locked>";

impl Write for Look<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        if !text.contains(SCOPES) {
            return Ok(());
        }
        self.found = Shown::by(self.thing);
        Err(fmt::Error)
    }
}

/// Finds the lock in a debug text.
struct Shown(Option<Lock>);

impl Shown {
    fn by(thing: &dyn Debug) -> Option<Lock> {
        let mut shown = Self(None);
        let _ = write!(shown, "{thing:?}");
        shown.0
    }
}

impl Write for Shown {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        if text.contains(SCOPES) {
            self.0 = Some(Lock::Free);
            return Err(fmt::Error);
        }
        // A buffer has another lock, behind this one.
        if text.contains(LOCKED) {
            self.0 = Some(Lock::Taken);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Maker = fn(&wgpu::Device) -> Box<dyn Debug>;

    /// Everything that a caller hands over.
    const THINGS: [(&str, Maker); 5] = [
        ("a device", |device| Box::new(device.clone())),
        ("an encoder", |device| Box::new(device.create_command_encoder(&Default::default()))),
        ("a buffer", |device| {
            let (size, usage) = (4, wgpu::BufferUsages::COPY_DST);
            Box::new(device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("ErrorSink <locked>"),
                size,
                usage,
                mapped_at_creation: false,
            }))
        }),
        ("a texture", |device| {
            Box::new(device.create_texture(&wgpu::TextureDescriptor {
                label: Some("ErrorSink <locked>"),
                size: wgpu::Extent3d { width: 4, height: 4, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::R8Unorm,
                usage: wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            }))
        }),
        ("a lost device's buffer", |device| {
            let device = device.clone();
            let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: 4,
                usage: wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: true,
            });
            device.destroy();
            Box::new(buffer)
        }),
    ];

    /// It rests on how wgpu shows things, so it is looked at with everything there is. The numbers are the same in both
    /// instances: those tell nothing.
    #[test]
    fn what_is_another_devices_is_known() {
        for (name, make) in THINGS {
            let [(device, queue), (other, other_queue)] =
                [(); 2].map(|()| wgpu::Device::noop(&wgpu::DeviceDescriptor::default()));
            let (own, foreign) = (make(&device), make(&other));
            for (queue, thing, owned) in [
                (&queue, &own, true),
                (&other_queue, &foreign, true),
                (&queue, &foreign, false),
                (&other_queue, &own, false),
            ] {
                assert_eq!(belongs(queue, thing), Some(owned), "{name}");
            }
        }
    }

    /// Others use both devices meanwhile.
    #[test]
    fn what_is_another_devices_is_known_under_load() {
        let [(device, queue), (other, _)] = [(); 2].map(|()| wgpu::Device::noop(&wgpu::DeviceDescriptor::default()));
        let done = std::sync::atomic::AtomicBool::new(false);
        std::thread::scope(|scope| {
            for device in [&device, &other] {
                let done = &done;
                scope.spawn(move || {
                    while !done.load(std::sync::atomic::Ordering::Relaxed) {
                        drop(device.push_error_scope(wgpu::ErrorFilter::Internal).pop());
                    }
                });
            }
            for _ in 0..2000 {
                assert_ne!(belongs(&queue, &device), Some(false));
            }
            let foreign = (0..2000).filter(|_| belongs(&queue, &other) == Some(false)).count();
            done.store(true, std::sync::atomic::Ordering::Relaxed);
            assert!(foreign > 1960, "{foreign} of 2000");
        });
    }

    #[test]
    fn a_lost_device_is_known() {
        let (device, queue) = wgpu::Device::noop(&wgpu::DeviceDescriptor::default());
        let pulse = Pulse::new(&device, &queue).unwrap();
        pulse.check().unwrap();
        pulse.check().unwrap();
        device.destroy();
        for _ in 0..2 {
            let Err(Error::Lost(text)) = pulse.check() else { panic!("not lost") };
            assert!(text.contains("device lost"), "{text}");
            device.poll(wgpu::PollType::Poll).unwrap(); // destroys the probe, too
        }
        assert!(matches!(Pulse::new(&device, &queue), Err(Error::Lost(_))));
    }
}
