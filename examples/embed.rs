//! The matcher inside another program, without a window: the program draws a pair of views into its own textures, the
//! matcher takes them and leaves disparities in a texture, and the program's own shader puts fog by depth over the left
//! view. All of it is one submission, and nothing but the finished picture comes back to the host.
//!
//!     cargo run --example embed

use gpu_stereo::{Inputs, Outputs, Params, PixelFormat, StereoMatcher, wgpu};
use wgpu::{TextureFormat, TextureUsages};

const WIDTH: u32 = 320;
const HEIGHT: u32 = 200;

/// A box in front of a wall: 24 and 8 px of disparity. The fog is half of what it can be at 16 px.
const SHADERS: &str = "
    @vertex fn corner(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
        return vec4(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
    }
    fn speckles(x: f32, y: f32) -> vec4<f32> {
        let cell = vec2<u32>(vec2(x, y) / 3.0);
        let hash = (cell.x * 0x9e3779b9u) ^ (cell.y * 0x85ebca6bu);
        return vec4(vec3(f32(((hash ^ (hash >> 15u)) * 0x2c1b3c6du) >> 24u) / 255.0), 1.0);
    }
    fn scene(at: vec2<f32>, eye: f32) -> vec4<f32> {
        let near = at.x + 24.0 * eye;
        if near > 120.0 && near < 220.0 && at.y > 60.0 && at.y < 140.0 {
            return speckles(near + 999.0, at.y) * vec4(1.0, 0.6, 0.3, 1.0);
        }
        return speckles(at.x + 8.0 * eye, at.y);
    }
    @fragment fn left_view(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
        return scene(at.xy, 0.0);
    }
    @fragment fn right_view(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
        return scene(at.xy, 1.0);
    }

    @group(0) @binding(0) var view: texture_2d<f32>;
    @group(0) @binding(1) var disparity: texture_2d<f32>;
    @fragment fn fog(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
        let d = textureLoad(disparity, vec2<u32>(at.xy), 0).x; // in px; -2048 where there is none
        let thickness = select(exp2(-d / 16.0), 1.0, d <= 0.0);
        return vec4(mix(textureLoad(view, vec2<u32>(at.xy), 0).rgb, vec3(1.0), thickness), thickness);
    }";

/// Draws with an entry point of [`SHADERS`].
fn draw(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    entry: &str,
    reads: &[&wgpu::TextureView],
    to: &wgpu::TextureView,
) {
    let source = wgpu::ShaderSource::Wgsl(SHADERS.into());
    let module = &device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
    let stage = wgpu::PipelineCompilationOptions::default();
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(entry),
        layout: None,
        vertex: wgpu::VertexState { module, entry_point: None, compilation_options: stage.clone(), buffers: &[] },
        primitive: Default::default(),
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(entry),
            compilation_options: stage,
            targets: &[Some(TextureFormat::Rgba8Unorm.into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    let attachment =
        wgpu::RenderPassColorAttachment { view: to, depth_slice: None, resolve_target: None, ops: Default::default() };
    let color_attachments = &[Some(attachment)];
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor { color_attachments, ..Default::default() });
    pass.set_pipeline(&pipeline);
    if !reads.is_empty() {
        let resource = |view| wgpu::BindingResource::TextureView(view);
        let entries: Vec<_> = (0..)
            .zip(reads)
            .map(|(binding, view)| wgpu::BindGroupEntry { binding, resource: resource(view) })
            .collect();
        let layout = &pipeline.get_bind_group_layout(0);
        pass.set_bind_group(
            0,
            &device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries }),
            &[],
        );
    }
    pass.draw(0..3, 0..1);
}

/// A frame of the program.
///
/// # Errors
/// If there is no device, or the fog is not what the scene gives.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    // The program's device: what the matcher would like is asked for; it also works without.
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: StereoMatcher::required_features(&adapter),
        required_limits: StereoMatcher::required_limits(&adapter),
        ..Default::default()
    }))?;
    let size = wgpu::Extent3d { width: WIDTH, height: HEIGHT, depth_or_array_layers: 1 };
    let texture = |label, format| {
        device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    };
    let color = TextureFormat::Rgba8Unorm;
    let textures = [
        texture("left", color),
        texture("right", color),
        texture("disparity", TextureFormat::R32Float),
        texture("fogged", color),
    ];
    let [left, right, disparity, fogged] = textures.each_ref().map(|texture| texture.create_view(&Default::default()));
    let matcher = StereoMatcher::new(&device, &queue, WIDTH, HEIGHT, PixelFormat::Rgba8, &Params::sgm(32))?;

    // One frame: the program's passes, the matcher between them, one submission.
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    draw(&device, &mut encoder, "left_view", &[], &left);
    draw(&device, &mut encoder, "right_view", &[], &right);
    matcher.record(
        &mut encoder,
        &Inputs::textures(&textures[0], &textures[1]),
        &Outputs::default().disparity(&textures[2]),
    )?;
    draw(&device, &mut encoder, "fog", &[&left, &disparity], &fogged);
    let picture = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("picture"),
        size: u64::from(4 * WIDTH * HEIGHT),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * WIDTH), rows_per_image: None };
    let to = wgpu::TexelCopyBufferInfo { buffer: &picture, layout };
    encoder.copy_texture_to_buffer(textures[3].as_image_copy(), to, size);
    queue.submit([encoder.finish()]);

    // The program itself decides when to wait. Alpha holds the thickness of the fog.
    picture.map_async(wgpu::MapMode::Read, .., |_| ());
    device.poll(wgpu::PollType::wait_indefinitely())?;
    let pixels = picture.get_mapped_range(..)?;
    let fog = |x: u32, y: u32| 100 * u32::from(pixels[4 * (y * WIDTH + x) as usize + 3]) / 255;
    let (wall, near) = (fog(270, 30), fog(170, 100));
    println!("{}: the fog hides {wall} % of the wall and {near} % of the box in front of it", adapter.get_info().name);
    // 2^(-8 / 16) and 2^(-24 / 16)
    if (70..=71).contains(&wall) && (34..=36).contains(&near) {
        Ok(())
    } else {
        Err("they should be 70 % and 35 %".into())
    }
}
