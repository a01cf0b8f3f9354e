//! The window: one wgpu device for egui, the matcher and the cloud of points.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use egui_wgpu::{Renderer, RendererOptions, ScreenDescriptor};
use gpu_stereo::{StereoMatcher, wgpu};
use winit::application::ApplicationHandler;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::window::{Window, WindowId};

use crate::app::App;
use crate::options::Options;

/// What the device objects to outside of a frame.
type Failure = Arc<Mutex<Option<String>>>;

/// Opens the window and stays until it is closed.
pub fn run(options: Options) -> Result<(), String> {
    let events = EventLoop::new().map_err(|error| format!("no window can be opened: {error}; is there a display?"))?;
    let mut viewer = Viewer { options: Some(options), open: None, ended: Ok(()) };
    events.run_app(&mut viewer).map_err(|error| format!("the window failed: {error}"))?;
    viewer.ended
}

struct Viewer {
    options: Option<Options>,
    open: Option<Open>,
    ended: Result<(), String>,
}

impl ApplicationHandler for Viewer {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        let Some(options) = self.options.take() else { return };
        match Open::new(events, options) {
            Ok(open) => self.open = Some(open),
            Err(error) => self.end(events, error),
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(open) = &mut self.open else { return };
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::Resized(_) => open.configure(),
            WindowEvent::RedrawRequested => {
                if let Err(error) = open.draw() {
                    self.end(events, error);
                }
                return;
            }
            _ => {}
        }
        // A dropped file comes to the app with egui's input.
        if open.egui.on_window_event(&open.window, &event).repaint {
            open.window.request_redraw();
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let Some(open) = &mut self.open else { return };
        if let Some(error) = open.failure.lock().ok().and_then(|mut failure| failure.take()) {
            return self.end(events, error);
        }
        let busy = open.app.advance();
        let now = Instant::now();
        if open.app.changed() || open.redraw_at.is_some_and(|at| at <= now) {
            open.redraw_at = None;
            open.window.request_redraw();
        }
        // While a frame is under way, the device is asked whether it is done; else the window sleeps.
        let poll = busy.then_some(now + Duration::from_millis(1));
        let until = [poll, open.redraw_at].into_iter().flatten().min();
        events.set_control_flow(until.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }
}

impl Viewer {
    fn end(&mut self, events: &ActiveEventLoop, error: String) {
        self.ended = Err(error);
        events.exit();
    }
}

struct Open {
    app: App,
    egui: egui_winit::State,
    renderer: Renderer,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    device: wgpu::Device,
    queue: wgpu::Queue,
    failure: Failure,
    redraw_at: Option<Instant>,
    window: Arc<Window>,
}

impl Open {
    fn new(events: &ActiveEventLoop, options: Options) -> Result<Self, String> {
        let size = winit::dpi::LogicalSize::new(1280.0, 860.0);
        let attributes = Window::default_attributes().with_title("gpu-stereo viewer").with_inner_size(size);
        let window = events.create_window(attributes).map_err(|error| format!("no window can be opened: {error}"))?;
        let window = Arc::new(window);
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let surface = instance.create_surface(window.clone()).map_err(|error| {
            format!("no driver can draw to this window: {error}; install one (Debian: mesa-vulkan-drivers)")
        })?;

        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            compatible_surface: Some(&surface),
            ..Default::default()
        }))
        .map_err(|error| format!("no adapter was found: {error}; install a driver (Debian: mesa-vulkan-drivers)"))?;
        // What the matcher makes use of is what this program needs, too.
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("viewer"),
            required_features: StereoMatcher::required_features(&adapter),
            required_limits: StereoMatcher::required_limits(&adapter),
            ..Default::default()
        }))
        .map_err(|error| format!("no device: {error}; update the driver"))?;
        let failure = Failure::default();
        let (on_error, on_loss) = (failure.clone(), failure.clone());
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| note(&on_error, &error.to_string())));
        device.set_device_lost_callback(move |reason, message| {
            if reason != wgpu::DeviceLostReason::Destroyed {
                note(&on_loss, &format!("the device was lost: {message}"));
            }
        });

        let side = window.inner_size();
        let mut config = surface
            .get_default_config(&adapter, side.width.max(1), side.height.max(1))
            .ok_or("the adapter cannot draw to this window; take another driver by WGPU_BACKEND")?;
        // Bytes as they are: neither egui nor the colour map want a conversion.
        let formats = surface.get_capabilities(&adapter).formats;
        let plain = [wgpu::TextureFormat::Rgba8Unorm, wgpu::TextureFormat::Bgra8Unorm];
        config.format = plain.into_iter().find(|format| formats.contains(format)).unwrap_or(config.format);
        surface.configure(&device, &config);

        let context = egui::Context::default();
        context.set_theme(egui::Theme::Dark);
        let most = device.limits().max_texture_dimension_2d as usize;
        let scale = Some(window.scale_factor() as f32);
        let egui = egui_winit::State::new(context, egui::ViewportId::ROOT, &window, scale, None, Some(most));
        let renderer =
            Renderer::new(&device, config.format, RendererOptions { dithering: false, ..Default::default() });
        let app = App::new(options, &device, &queue, adapter.get_info().name)?;
        Ok(Self { app, egui, renderer, surface, config, device, queue, failure, redraw_at: None, window })
    }

    fn configure(&mut self) {
        let size = self.window.inner_size();
        if size.width > 0 && size.height > 0 {
            (self.config.width, self.config.height) = (size.width, size.height);
            self.surface.configure(&self.device, &self.config);
            self.window.request_redraw();
        }
    }

    fn draw(&mut self) -> Result<(), String> {
        use wgpu::CurrentSurfaceTexture as Current;
        let frame = match self.surface.get_current_texture() {
            Current::Success(frame) | Current::Suboptimal(frame) => frame,
            Current::Outdated => {
                self.configure();
                return Ok(());
            }
            Current::Lost => return Err("the window's surface was lost; start again".into()),
            // Nothing is seen: the next event draws.
            _ => return Ok(()),
        };
        let input = self.egui.take_egui_input(&self.window);
        let context = self.egui.egui_ctx().clone();
        let (app, renderer) = (&mut self.app, &mut self.renderer);
        let mut output = context.run_ui(input, |ui| app.ui(ui, renderer));
        self.egui.handle_platform_output(&self.window, output.platform_output);
        let delay = output.viewport_output.get(&egui::ViewportId::ROOT).map(|viewport| viewport.repaint_delay);
        self.redraw_at = delay.and_then(|delay| Instant::now().checked_add(delay));

        let shapes = context.tessellate(output.shapes, output.pixels_per_point);
        let screen = ScreenDescriptor {
            size_in_pixels: [self.config.width, self.config.height],
            pixels_per_point: output.pixels_per_point,
        };
        for (id, deltas) in output.textures_delta.set.drain() {
            for delta in &deltas {
                self.renderer.update_texture(&self.device, &self.queue, id, delta);
            }
        }
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let more = self.renderer.update_buffers(&self.device, &self.queue, &mut encoder, &shapes, &screen);
        let view = frame.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("viewer.window"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        let mut pass = pass.forget_lifetime();
        self.renderer.render(&mut pass, &shapes, &screen);
        drop(pass);
        self.queue.submit(more.into_iter().chain([encoder.finish()]));
        self.window.pre_present_notify();
        self.queue.present(frame);
        for id in output.textures_delta.free.drain() {
            self.renderer.free_texture(&id);
        }
        self.app.presented();
        Ok(())
    }
}

/// Keeps the first failure, in one line.
fn note(failure: &Failure, message: &str) {
    if let Ok(mut failure) = failure.lock() {
        failure.get_or_insert_with(|| message.split_whitespace().collect::<Vec<_>>().join(" "));
    }
}
