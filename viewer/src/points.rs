//! The map as a cloud of points that can be turned, drawn into a texture with a pass of its own.

use std::num::NonZeroU64;

use gpu_stereo::wgpu;

use crate::files::Camera;
use crate::textures::{Textures, viewed};

/// Bytes of `View` in points.wgsl: a matrix, four vectors of four and one of two, padded.
const VIEW_BYTES: u64 = 64 + 3 * 16 + 16;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Behind the points: what no picture is full of, and easy to tell from black.
pub const BACKGROUND: [u8; 3] = [24, 28, 36];

/// Where the cloud is seen from: angles around its middle, and the distance as a share of the middle's depth. At rest
/// it is seen as the left camera saw it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    pub yaw: f32,
    pub pitch: f32,
    pub distance: f32,
}

impl Orbit {
    pub const REST: Self = Self { yaw: 0.0, pitch: 0.0, distance: 1.0 };

    /// Turned by a drag over so many points of the screen.
    pub fn turned(self, [x, y]: [f32; 2]) -> Self {
        Self { yaw: self.yaw - 0.006 * x, pitch: (self.pitch + 0.006 * y).clamp(-1.5, 1.5), ..self }
    }

    /// Nearer or farther by the wheel.
    pub fn nearer(self, wheel: f32) -> Self {
        Self { distance: (self.distance * (-0.002 * wheel).exp()).clamp(0.02, 20.0), ..self }
    }
}

/// What a picture of the cloud depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene {
    pub orbit: Orbit,
    pub camera: Camera,
    /// Side of a point; at 1 the points close up at rest.
    pub size: f32,
    /// The disparity of the cloud's middle.
    pub middle: f32,
    /// Pixels of the map, and of the picture.
    pub map: [u32; 2],
    pub picture: [u32; 2],
    /// Changes with the map.
    pub changes: u64,
}

pub struct Points {
    pipeline: wgpu::RenderPipeline,
    view: wgpu::Buffer,
    target: Option<(wgpu::TextureView, wgpu::TextureView)>,
    drawn: Option<Scene>,
}

impl Points {
    pub fn new(device: &wgpu::Device) -> Self {
        let module = device.create_shader_module(wgpu::include_wgsl!("points.wgsl"));
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("viewer.points"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: None,
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState { topology: wgpu::PrimitiveTopology::TriangleStrip, ..Default::default() },
            // Reversed: 1 is near, 0 infinitely far.
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: None,
                compilation_options: Default::default(),
                targets: &[Some(wgpu::TextureFormat::Rgba8Unorm.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let view = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("viewer.view"),
            size: VIEW_BYTES,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self { pipeline, view, target: None, drawn: None }
    }

    /// The picture, drawn anew if the scene is another one. With it, whether it is in a new texture.
    pub fn draw(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        textures: &Textures,
        scene: Scene,
    ) -> (&wgpu::TextureView, bool) {
        let new = self.drawn.is_none_or(|drawn| drawn.picture != scene.picture);
        let again = self.drawn != Some(scene);
        self.drawn = Some(scene);
        if new {
            self.target = None;
        }
        let (colour, depth) = self.target.get_or_insert_with(|| {
            use wgpu::{TextureFormat as Format, TextureUsages as Usage};
            let target =
                |format, more| viewed(device, "viewer.points", scene.picture, format, Usage::RENDER_ATTACHMENT | more);
            (target(Format::Rgba8Unorm, Usage::TEXTURE_BINDING), target(DEPTH, Usage::empty()))
        });
        if again {
            queue.write_buffer(&self.view, 0, &uniform(&scene));
            let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
            let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("viewer.points"),
                layout: &self.pipeline.get_bind_group_layout(0),
                entries: &[
                    entry(
                        0,
                        wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                            buffer: &self.view,
                            offset: 0,
                            size: NonZeroU64::new(VIEW_BYTES),
                        }),
                    ),
                    entry(1, wgpu::BindingResource::TextureView(&textures.disparity)),
                    entry(2, wgpu::BindingResource::TextureView(&textures.left)),
                ],
            });
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let [r, g, b] = BACKGROUND.map(|v| f64::from(v) / 255.0);
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("viewer.points"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: colour,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a: 1.0 }),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: depth,
                    depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
                    stencil_ops: None,
                }),
                ..Default::default()
            });
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &bind_group, &[]);
            pass.draw(0..4, 0..scene.map[0] * scene.map[1]);
            drop(pass);
            queue.submit([encoder.finish()]);
        }
        (colour, new)
    }
}

/// `View` of points.wgsl.
fn uniform(scene: &Scene) -> Vec<u8> {
    let Scene { orbit, camera, middle, map, picture, .. } = *scene;
    let [width, height] = map.map(|side| side as f32);
    let [picture_width, picture_height] = picture.map(|side| side as f32);
    // Without a calibration the shape is that of a usual lens, and a unit is the baseline.
    let (focal, baseline) = if camera.focal > 0.0 { (camera.focal, camera.baseline) } else { (width, 1.0) };
    let baseline = if baseline > 0.0 { baseline } else { 1.0 };
    let image_centre = [(width - 1.0) / 2.0, (height - 1.0) / 2.0];
    let centre = camera.centre.unwrap_or(image_centre);
    let depth = focal * baseline / (middle + camera.doffs).max(1.0 / 16.0);
    let pivot = [(image_centre[0] - centre[0]) * depth / focal, (image_centre[1] - centre[1]) * depth / focal, depth];

    // First around the vertical axis, then around the horizontal one.
    let ((sy, cy), (sp, cp)) = (orbit.yaw.sin_cos(), orbit.pitch.sin_cos());
    let turn = [[cy, 0.0, sy], [sp * sy, cp, -sp * cy], [-cp * sy, sp, cp * cy]];
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    // The middle stays where it is on the screen.
    let to = pivot.map(|v| v * orbit.distance);
    let shift: [f32; 3] = std::array::from_fn(|i| to[i] - dot(turn[i], pivot));

    // The picture shows the whole left image, its pixels `scale` pixels wide.
    let scale = (picture_width / width).min(picture_height / height);
    let (fx, fy) = (2.0 * scale * focal / picture_width, -2.0 * scale * focal / picture_height);
    let ox = 2.0 * scale * (centre[0] - image_centre[0]) / picture_width;
    let oy = -2.0 * scale * (centre[1] - image_centre[1]) / picture_height;
    let near = 0.01 * depth;
    // Rows of the projection after the turn: x, y, near as z (divided by w: 1 at the near plane), depth as w.
    let row = |i: usize| [turn[i][0], turn[i][1], turn[i][2], shift[i]];
    let (x, y, z) = (row(0), row(1), row(2));
    let rows: [[f32; 4]; 4] = [
        std::array::from_fn(|j| fx * x[j] + ox * z[j]),
        std::array::from_fn(|j| fy * y[j] + oy * z[j]),
        [0.0, 0.0, 0.0, near],
        z,
    ];
    let mut numbers: Vec<f32> = (0..16).map(|i| rows[i % 4][i / 4]).collect();
    numbers.extend([x[0], x[1], x[2], 0.0, y[0], y[1], y[2], 0.0]);
    numbers.extend([focal, baseline, camera.doffs, scene.size]);
    numbers.extend([centre[0], centre[1], 0.0, 0.0]);
    numbers.iter().flat_map(|number| number.to_ne_bytes()).collect()
}
