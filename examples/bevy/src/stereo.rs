//! A plugin: the matcher on Bevy's device, after the cameras of each frame.

use bevy::asset::RenderAssetUsages;
use bevy::core_pipeline::schedule::camera_driver;
use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy::render::extract_resource::{ExtractResource, ExtractResourcePlugin};
use bevy::render::render_asset::RenderAssets;
use bevy::render::render_resource::{TextureFormat, TextureUsages};
use bevy::render::renderer::{RenderContext, RenderDevice, RenderGraph, RenderQueue};
use bevy::render::texture::GpuImage;
use gpu_stereo::{Inputs, Outputs, Params, PixelFormat, StereoMatcher};

/// Of each view, in pixels.
pub const SIZE: UVec2 = UVec2::new(320, 240);

/// What is searched.
pub fn params() -> Params {
    Params::default_for(64)
}

/// The textures of the cameras, and those that the matcher fills.
#[derive(Resource, Clone, ExtractResource)]
#[extract_app(RenderApp)]
pub struct Rig {
    pub left: Handle<Image>,
    pub right: Handle<Image>,
    /// Pixels; -2048 where there is none.
    pub disparity: Handle<Image>,
    pub colours: Handle<Image>,
}

impl FromWorld for Rig {
    fn from_world(world: &mut World) -> Self {
        let mut images = world.resource_mut::<Assets<Image>>();
        let mut target = |format| {
            let mut image = Image::new_target_texture(SIZE.x, SIZE.y, format, None);
            image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
            image.asset_usage = RenderAssetUsages::RENDER_WORLD;
            images.add(image)
        };
        let [left, right] = [(); 2].map(|()| target(TextureFormat::Rgba8UnormSrgb));
        Self { left, right, disparity: target(TextureFormat::R32Float), colours: target(TextureFormat::Rgba8Unorm) }
    }
}

pub struct StereoPlugin;

impl Plugin for StereoPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Rig>().add_plugins(ExtractResourcePlugin::<Rig>::default());
        let render = app.sub_app_mut(RenderApp);
        render.add_systems(RenderGraph, record.after(camera_driver));
    }
}

/// Made at the first frame, when there is a device.
fn matcher(device: &RenderDevice, queue: &RenderQueue) -> StereoMatcher {
    let made = StereoMatcher::new(device.wgpu_device(), queue, SIZE.x, SIZE.y, PixelFormat::Rgba8, &params());
    made.unwrap_or_else(|error| panic!("the matcher: {error}"))
}

/// Into the encoder of the frame, behind what the cameras draw.
fn record(
    mut made: Local<Option<StereoMatcher>>,
    rig: Res<Rig>,
    images: Res<RenderAssets<GpuImage>>,
    (device, queue): (Res<RenderDevice>, Res<RenderQueue>),
    mut context: RenderContext,
) {
    let textures = [&rig.left, &rig.right, &rig.disparity, &rig.colours].map(|handle| images.get(handle));
    let [Some(left), Some(right), Some(disparity), Some(colours)] = textures else { return };
    let matcher = made.get_or_insert_with(|| matcher(&device, &queue));
    let inputs = Inputs::textures(&*left.texture, &*right.texture);
    let outputs = Outputs::default().disparity(&*disparity.texture).color(&*colours.texture);
    if let Err(error) = matcher.record(context.command_encoder(), &inputs, &outputs) {
        error!("the matcher: {error}");
    }
}
